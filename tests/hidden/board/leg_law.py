"""The force law of a leg and the effects on it, written a second time, in its differential form.

R' = beta u' (h_l - R) uncoiling,   R' = beta u' (R - h_u) coiling
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from simulate.model.effect import Effect
from simulate.model.model import Actuator, Model

from .camera import values_of
from .outside import KINDS as OUTSIDE

Array = np.ndarray


# Forces beside R, N, each of the effect's values p, elongation u, its rate v, time t and R.
_ADDED: dict[str, Callable[[Sequence[float], Array, Array, Any, Array], Array]] = {
    "viscous-friction": lambda p, u, v, t, force: -p[0] * v,
    "power-law-friction": lambda p, u, v, t, force: -p[0] * v * (v**2 + 1e-6) ** ((p[1] - 1) / 2),
    "stribeck-friction": lambda p, u, v, t, force: -p[0] * np.tanh(v / 2e-3) * np.exp(-((v / p[1]) ** 2)),
    "eddy-damping": lambda p, u, v, t, force: -p[0] * v / (1.0 + (v / p[1]) ** 2),
    "ripple": lambda p, u, v, t, force: p[0] * np.sin(2 * np.pi * u / p[1] + p[2]),
    "transition-zone": lambda p, u, v, t, force: -p[0] * np.exp(-np.maximum(u, 0.0) / p[1]),
    "force-relaxation": lambda p, u, v, t, force: force * p[0] * np.expm1(-t / p[1]),
}


def _bent_by_speed(p: Sequence[float], side: int, u: float, s: float) -> float:
    a1, a2, b1, b2 = p[4 * side : 4 * side + 4]
    return (a1 * s + a2 * s**2) * u + b1 * s + b2 * s**2


# What bends h_l (side 0) or h_u (side 1), N, of the effect's values p, elongation u and speed s.
_BENT: dict[str, Callable[[Sequence[float], int, float, float], float]] = {
    "curved-asymptotes": lambda p, side, u, s: p[0] * u**2 + p[1] * u**3,
    "rate-dependent-asymptotes": _bent_by_speed,
}


class Law:
    """The force law of six legs and what effects change about it: plain numbers where arrays of six would be slower."""

    def __init__(self, model: Model, without: Sequence[str] = ()) -> None:
        law, p = model.actuator, {name: v.tolist() for name, v in values_of(model.effects).items() if name not in without}
        shift = np.array(p.get("leg-disparity", np.zeros(6)))
        self.lower = np.column_stack([_six(law.a_l_N_per_m), _six(law.b_l_N) + shift]).tolist()
        self.upper = np.column_stack([_six(law.a_u_N_per_m), _six(law.b_u_N) + shift]).tolist()
        self.beta, self.first = _six(law.beta_per_m).tolist(), (_six(law.initial_force_N) + shift).tolist()
        self.forces = [(_ADDED[name], p[name]) for name in p if name in _ADDED]
        self.bends = [(_BENT[name], p[name]) for name in p if name in _BENT]
        self.outside = [effect for effect in model.effects if effect.name in OUTSIDE and effect.leg_force is not None]

    def rate(self, u: Sequence[float], v: Sequence[float], force: Sequence[float]) -> list[float]:
        """R' = beta |u'| (h - R) of each leg, h that asymptote towards which R goes."""
        return [self.beta[leg] * abs(v[leg]) * (self.ahead(leg, v[leg] > 0.0, u[leg], v[leg]) - force[leg]) for leg in range(len(u))]

    def ahead(self, leg: int, out: bool, u: float, v: float) -> float:
        """The asymptote ahead, N: h_l of a leg that goes out, h_u of one that comes in."""
        slope, level = self.lower[leg] if out else self.upper[leg]
        ahead = slope * u + level
        for bent, p in self.bends:
            ahead += bent(p, 0 if out else 1, u, abs(v))
        return ahead

    def added(self, u: Array, v: Array, t: Any, force: Array) -> Array:
        """Friction, brakes, ripples, the transition zone and relaxation, N: of those that there are."""
        total = np.zeros(len(u))
        for formula, p in self.forces:
            total += formula(p, u, v, t, force)
        for effect in self.outside:
            total += self._from_outside(effect, u)
        return total

    @staticmethod
    def _from_outside(effect: Effect, u: Array) -> list[float]:
        """An effect that no catalogue holds, by its own formula of the elongation: there is no other."""
        p = effect.flat().tolist()
        return [effect.leg_force(x, 0.0, 0.0, 0.0, 0.0, p) for x in u.tolist()]


def _six(values: Any) -> Array:
    return np.array(np.broadcast_to(values, 6), dtype=float)


def loop_by_ode(model: Model, times: Array, u: Array, v: Array, a: Array, start_force_N: float) -> Array:
    """The force of one actuator along an imposed motion, R by its differential equation; legs that differ are not on the shaker."""
    law = Law(replace(model, actuator=_mean(model.actuator)), without=("leg-disparity",))
    moved = CubicHermiteSpline(times, np.column_stack([u, v]), np.column_stack([v, a]))
    longest = 4e-3 / max(float(np.max(np.abs(a))) ** 0.5, 1e-3)

    def rate(t: float, force: Array) -> list[float]:
        at, speed = moved(t).tolist()
        return law.rate([at], [speed], force.tolist())

    solved = solve_ivp(
        rate,
        (times[0], times[-1]),
        [start_force_N],
        method="LSODA",
        t_eval=times,
        rtol=1e-9,
        atol=1e-10,
        max_step=longest,
    )
    mass = sum(float(p[0]) for name, p in values_of(model.effects).items() if name in ("hub-inertia", "leg-mass"))
    force = solved.y[0]
    return force + law.added(u, v, times, force) - mass * a


def _mean(law: Actuator) -> Actuator:
    """Legs that are all alike."""
    values = {key: float(np.mean(getattr(law, key))) for key in ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "beta_per_m")}
    return replace(law, **values)
