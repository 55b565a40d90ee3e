"""The force law of a leg and the effects on it, written a second time, in its differential form.

R' = beta u' (h_l - R) uncoiling,   R' = beta u' (R - h_u) coiling
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from simulate.model.effect import Effect
from simulate.model.model import Model

from .camera import values_of
from .outside import KINDS as OUTSIDE

Array = np.ndarray


class Law:
    """The force law of six legs and what effects change about it, from elongation, speed, time and R: (6,) each."""

    def __init__(self, model: Model) -> None:
        law, self.p = model.actuator, values_of(model.effects)
        self.outside = [effect for effect in model.effects if effect.name in OUTSIDE and effect.leg_force is not None]
        self.shift = self.p.get("leg-disparity", np.zeros(6))
        self.slopes: tuple[Array, Array] = np.broadcast_to(law.a_l_N_per_m, 6), np.broadcast_to(law.a_u_N_per_m, 6)
        self.levels: tuple[Array, Array] = np.broadcast_to(law.b_l_N, 6) + self.shift, np.broadcast_to(law.b_u_N, 6) + self.shift
        self.beta = np.broadcast_to(law.beta_per_m, 6)
        self.first = np.broadcast_to(law.initial_force_N, 6) + self.shift

    def rate(self, u: Array, v: Array, force: Array) -> Array:
        """R' = beta u' (h_l - R) uncoiling, beta u' (R - h_u) coiling."""
        lower, upper = self.asymptotes(u, v)
        return self.beta * v * np.where(v > 0, lower - force, force - upper)

    def asymptotes(self, u: Array, v: Array) -> tuple[Array, Array]:
        """h_l and h_u, N."""
        lower, upper = (self.slopes[side] * u + self.levels[side] + self._bent(side, u, v) for side in (0, 1))
        return lower, upper

    def _bent(self, side: int, u: Array, v: Array) -> Array:
        c2, c3 = self.p.get("curved-asymptotes", (0.0, 0.0))
        a1, a2, b1, b2 = self.p.get("rate-dependent-asymptotes", np.zeros(8))[4 * side : 4 * side + 4]
        s = np.abs(v)
        return c2 * u**2 + c3 * u**3 + (a1 * s + a2 * s**2) * u + b1 * s + b2 * s**2

    def added(self, u: Array, v: Array, t: Any, force: Array) -> Array:
        """Friction, brakes, ripples, the transition zone and relaxation, N."""
        (c,) = self.p.get("viscous-friction", (0.0,))
        k, n = self.p.get("power-law-friction", (0.0, 2.0))
        stick, v_s = self.p.get("stribeck-friction", (0.0, 0.05))
        eddy, v_0 = self.p.get("eddy-damping", (0.0, 0.1))
        missing, length = self.p.get("transition-zone", (0.0, 0.08))
        lost, tau = self.p.get("force-relaxation", (0.0, 0.5))
        friction = c * v + k * v * (v**2 + 1e-6) ** ((n - 1) / 2) + stick * np.tanh(v / 2e-3) * np.exp(-((v / v_s) ** 2))
        wave, period, phase = self.p.get("ripple", (0.0, 1.0, 0.0))
        friction += eddy * v / (1.0 + (v / v_0) ** 2)
        friction -= wave * np.sin(2 * np.pi * u / period + phase)
        known = -friction - missing * np.exp(-np.maximum(u, 0.0) / length) + force * lost * np.expm1(-t / tau)
        return known + sum(self._from_outside(effect, u) for effect in self.outside)

    @staticmethod
    def _from_outside(effect: Effect, u: Array) -> Array:
        """An effect that no catalogue holds, by its own formula of the elongation: there is no other."""
        p = effect.flat()
        return np.array([effect.leg_force(float(x), 0.0, 0.0, 0.0, 0.0, p) for x in u])


def loop_by_ode(model: Model, times: Array, u: Array, v: Array, a: Array, start_force_N: float) -> Array:
    """The force of one actuator along an imposed motion, R by its differential equation; legs that differ are not on the shaker."""
    law = Law(replace(model, effects=tuple(effect for effect in model.effects if effect.name != "leg-disparity")))
    law.slopes, law.levels, law.beta = _mean(law.slopes), _mean(law.levels), np.full(1, np.mean(law.beta))
    at, speed = CubicHermiteSpline(times, u, v), CubicHermiteSpline(times, v, a)
    longest = 4e-3 / max(float(np.max(np.abs(a))) ** 0.5, 1e-3)
    solved = solve_ivp(
        lambda t, force: law.rate(at(t), speed(t), force),
        (times[0], times[-1]),
        [start_force_N],
        method="LSODA",
        t_eval=times,
        rtol=1e-9,
        atol=1e-10,
        max_step=longest,
    )
    mass = sum(float(law.p.get(name, (0.0,))[0]) for name in ("hub-inertia", "leg-mass"))
    force = solved.y[0]
    return force + law.added(u, v, times, force) - mass * a


def _mean(sides: tuple[Array, Array]) -> tuple[Array, Array]:
    return np.full(1, np.mean(sides[0])), np.full(1, np.mean(sides[1]))
