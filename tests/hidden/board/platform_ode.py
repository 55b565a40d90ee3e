"""The six-leg platform written a second time, for scipy's integrators: Newton and Euler in body axes, the hysteretic force a state.

Nothing here is taken from the project's kernel but the numbers of the model. With n the unit vectors of the legs, G = [1, -[r]x] of
the platform joints and p their acceleration, a leg with axial mass a and transverse mass g holds back with M_b p + bias:

    M_b = a n n' + g (1 - n n'),   bias = n |v_t|^2 ((a - g) / l - g' / 2) + g' l' v_t

State: centre of mass (3), rotation matrix (9), velocity (3), angular velocity in body axes (3), R of each leg (6).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from simulate.model.model import Model

from .camera import Motion, values_of
from .leg_law import Law
from .outside import KINDS as OUTSIDE

Array = np.ndarray
Values = dict[str, list[float]]

SAID = (
    *("hub-inertia", "viscous-friction", "power-law-friction", "stribeck-friction", "rate-dependent-asymptotes", "curved-asymptotes"),
    *("transition-zone", "force-relaxation", "leg-disparity", "leg-mass", "end-stop-dissipation", "gravity-imbalance"),
    *("counterweight-inertia", "pulley-inertia", "pulley-friction", "cable-pendulum", "air-drag", "handrail-contact", "base-excitation"),
    *("centre-of-mass-offset", "release-pose", "eddy-damping", "ripple"),
)
"""Effects that this right-hand side knows."""


_LEVEL, _UP = np.array([1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def _rail(p: Sequence[float], m: float, t: float, x: Array, v: Array) -> Array:
    """A handrail: beyond its clearance it pushes back in proportion, and rubs."""
    clearance, stiffness = p
    radius = math.hypot(x[0], x[1])
    inwards = -x * _LEVEL / max(radius, 1e-12)
    return stiffness * max(radius - clearance, 0.0) * (inwards - 0.2 * v / np.sqrt(v @ v + 5e-3**2))


# Forces on the platform, N, of the effect's values p, the moving mass m, time t, place x and velocity v.
_PUSHES: dict[str, Callable[[Sequence[float], float, float, Array, Array], Array]] = {
    "gravity-imbalance": lambda p, m, t, x, v: p[0] * _UP,
    "pulley-friction": lambda p, m, t, x, v: -p[0] * np.tanh(v[2] / 2e-3) * _UP,
    "cable-pendulum": lambda p, m, t, x, v: -p[0] * x * _LEVEL,
    "air-drag": lambda p, m, t, x, v: -p[0] * np.sqrt(v @ v) * v,
    "base-excitation": lambda p, m, t, x, v: -m * p[0] * np.sin(2 * np.pi * p[1] * t + p[2]) * np.array(p[3:]),
    "handrail-contact": _rail,
}


def moved_by_ode(model: Model, times: Array, method: str = "DOP853", rtol: float = 1e-10, atol: float = 1e-12) -> Motion:
    """A deployment by one of scipy's integrators, tight; no step longer than a millisecond, lest a stop be stepped over."""
    platform = PlatformInBodyAxes(model)
    solved = solve_ivp(platform, (0.0, times[-1]), platform.start(), method=method, t_eval=times, rtol=rtol, atol=atol, max_step=1e-3)
    if not solved.success:
        raise RuntimeError(f"scipy's {method} gave up at {solved.t[-1]:.3f} s: {solved.message}")
    matrices = np.moveaxis(solved.y[3:12].reshape(3, 3, -1), -1, 0)
    return motion_of(times, solved.y[:3].T - matrices @ platform.centre, Rotation.from_matrix(matrices).as_quat(scalar_first=True))


def motion_of(times: Array, place: Array, quaternion: Array) -> Motion:
    """A motion whose quaternions do not jump to their other sign."""
    turned = np.where(np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0, -1.0, 1.0)
    return Motion(times, place, quaternion * np.concatenate([[1.0], np.cumprod(turned)])[:, None])


class Legs(NamedTuple):
    """The six legs at an instant: unit vector, length, its rate, and the velocity of the platform joint; a column for each leg."""

    axis: Array
    length: Array
    rate: Array
    joint: Array


class PlatformInBodyAxes:
    """The right-hand side. Model quantities that effects change are changed here, by this file's own few lines."""

    def __init__(self, model: Model) -> None:
        self.p = p = {name: values.tolist() for name, values in values_of(model.effects).items()}
        self.require_said(model)
        self.model, self.law = model, Law(model)
        self.pushes = [(_PUSHES[name], p[name]) for name in p if name in _PUSHES]
        outside = [effect for effect in model.effects if effect.name in OUTSIDE and effect.platform_wrench is not None]
        self.outside = [(effect.platform_wrench, p[effect.name]) for effect in outside]
        self._weigh(model, p)
        self._measure(model, p)

    def _weigh(self, model: Model, p: Values) -> None:
        """Masses and inertias, of the platform in six numbers, and the stops."""
        body, gravity, stop = model.platform, model.gravity, model.end_stop
        sideways = _first(p, "counterweight-inertia", 1.0)
        self.moving = body.mass_kg * gravity.mass_factor
        self.inertia = np.multiply(body.inertia_kg_m2, gravity.mass_factor * sideways)
        across, along = self.moving * sideways, self.moving + _first(p, "pulley-inertia")
        self.mass = np.array([across, across, along, *self.inertia])
        self.weight = body.mass_kg * gravity.acceleration_m_per_s2
        self.strip = _first(p, "leg-mass")
        self.axial = _first(p, "hub-inertia") + self.strip
        self.stop = stop.stiffness_N_per_m, stop.damping_N_s_per_m + _first(p, "end-stop-dissipation"), stop.smoothing_m

    def _measure(self, model: Model, p: Values) -> None:
        """Joints, a column for each leg, and the lengths at which its stops begin."""
        g = model.geometry
        assert g is not None
        base, joints = np.transpose(g.base_joints_m), np.transpose(g.platform_joints_m)
        self.centre = np.add(model.platform.centre_of_mass_m, p.get("centre-of-mass-offset", np.zeros(3)))
        self.base, self.joints = base, joints - self.centre[:, None]
        self.stowed, self.full = (
            np.linalg.norm(joints + np.array([[0.0], [0.0], [z]]) - base, axis=0) for z in (g.stowed_height_m, g.deployed_height_m)
        )
        start = self.start()
        released = self.legs(start[:3], start[3:12].reshape(3, 3), np.zeros(3), np.zeros((3, 3)))
        self.free = list(zip(np.minimum(self.stowed, released.length).tolist(), self.full.tolist(), strict=True))

    def require_said(self, model: Model) -> None:
        """Refuse an effect that this right-hand side would leave out without a word."""
        for effect in model.effects:
            if effect.name not in (*SAID, *OUTSIDE) and effect.acts_on != "measurement":
                raise ValueError(f"{effect.name} is not written in this right-hand side")

    def start(self) -> Array:
        """The state at the release."""
        r, g = self.model.release, self.model.geometry
        assert g is not None
        more = np.array(self.p.get("release-pose", np.zeros(9)))
        rotation = Rotation.from_rotvec(np.asarray(r.theta_rad) + more[3:6]).as_matrix()
        arm, turning = rotation @ self.centre, np.asarray(r.angular_velocity_rad_per_s)
        place = np.array([0.0, 0.0, g.stowed_height_m]) + r.position_m + more[:3] + arm
        velocity = np.asarray(r.velocity_m_per_s) + more[6:] + np.cross(turning, arm)
        return np.concatenate([place, rotation.ravel(), velocity, rotation.T @ turning, self.law.first])

    def legs(self, place: Array, rotation: Array, velocity: Array, turning: Array) -> Legs:
        """Where the legs are and how they move. turning : the rate of the rotation matrix."""
        way = place[:, None] + rotation @ self.joints - self.base
        length = np.sqrt(_dot(way, way))
        axis, joint = way / length, velocity[:, None] + turning @ self.joints
        return Legs(axis, length, _dot(axis, joint), joint)

    def __call__(self, t: float, y: Array) -> Array:
        """Rates of the state."""
        place, rotation, velocity, spin, force = y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:18], y[18:]
        spinning = skew(spin)
        turning = rotation @ spinning
        legs = self.legs(place, rotation, velocity, turning)
        u, v = legs.length - self.stowed, legs.rate
        pushed = force + self.law.added(u, v, t, force) + self.stops(legs.length.tolist(), v.tolist())
        free = self._free(t, place, velocity, rotation)
        free[3:] -= spinning @ (self.inertia * spin)
        acceleration = self._accelerated(free, pushed, rotation, turning @ (spinning @ self.joints), legs)
        return np.concatenate([velocity, turning.ravel(), acceleration, self.law.rate(u.tolist(), v.tolist(), force.tolist())])

    def _accelerated(self, free: Array, pushed: Array, rotation: Array, centripetal: Array, legs: Legs) -> Array:
        """Of the centre of mass, and of the rotation in body axes, by what acts beside the legs and by their push."""
        reach = np.concatenate([legs.axis, _cross(self.joints, rotation.T @ legs.axis)])
        right = free + reach @ pushed
        if self.axial == 0.0:
            return right / self.mass
        return np.linalg.solve(self._held_back(right, rotation, centripetal, legs, reach), right)

    def _free(self, t: float, place: Array, velocity: Array, rotation: Array) -> Array:
        """Weight and wrench, the moment in body axes."""
        total = self.wrench(t, place, velocity)
        total[2] -= self.weight
        total[3:] = total[3:] @ rotation
        return total

    def stops(self, length: Sequence[float], rate: Sequence[float]) -> list[float]:
        """The force of each leg's stops: at full length, and where the strip is coiled up."""
        legs = zip(self.free, length, rate, strict=True)
        return [self._stop(least - at, -v) - self._stop(at - most, v) for (least, most), at, v in legs]

    def _stop(self, deep: float, inwards: float) -> float:
        """(k p + c p') erf(p / s) against a penetration p above zero."""
        k, c, s = self.stop
        return (k * deep + c * inwards) * math.erf(deep / s) if deep > 0.0 else 0.0

    def wrench(self, t: float, place: Array, velocity: Array) -> Array:
        """Force, N, and moment about the centre of mass, N m, in world axes; only what comes from outside the catalogue has a moment."""
        total = np.zeros(6)
        for push, p in self.pushes:
            total[:3] += push(p, self.moving, t, place, velocity)
        for wrench, p in self.outside:
            wrench(t, place.tolist(), velocity.tolist(), p, total)
        return total

    def _held_back(self, right: Array, rotation: Array, centripetal: Array, legs: Legs, reach: Array) -> Array:
        """The inertia of spools and strips, felt at the platform joints, into the right side; the matrix with it is returned."""
        slope = self.strip / (3.0 * self.full)
        across, sideways = slope * legs.length, legs.joint - legs.rate * legs.axis
        more = self.axial - across
        right -= reach @ (more * _dot(legs.axis, centripetal) + _dot(sideways, sideways) * (more / legs.length - slope / 2))
        matrix = np.diag(self.mass) + (reach * more) @ reach.T
        if self.strip > 0.0:
            arms = np.array([np.hstack([np.eye(3), -rotation @ skew(r)]) for r in self.joints.T])
            matrix += np.einsum("k,kia,kib->ab", across, arms, arms)
            right -= np.einsum("kia,ik->a", arms, across * centripetal + slope * legs.rate * sideways)
        return matrix


def _first(p: Values, name: str, absent: float = 0.0) -> float:
    """The first value of an effect."""
    return p[name][0] if name in p else absent


def skew(a: Array) -> Array:
    """The matrix of the vector product a x."""
    x, y, z = a.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _dot(a: Array, b: Array) -> Array:
    """Scalar products column by column."""
    return np.einsum("ik,ik->k", a, b)


def _cross(a: Array, b: Array) -> Array:
    """Vector products column by column, faster than numpy's for so few."""
    (x, y, z), (p, q, r) = a, b
    return np.array([y * r - z * q, z * p - x * r, x * q - y * p])
