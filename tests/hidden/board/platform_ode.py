"""The six-leg platform written a second time, for scipy's integrators: Newton and Euler in body axes, the hysteretic force a state.

Nothing here is taken from the project's kernel but the numbers of the model. With n the unit vectors of the legs, G = [1, -[r]x] of
the platform joints and p their acceleration, a leg with axial mass a and transverse mass g holds back with M_b p + bias:

    M_b = a n n' + g (1 - n n'),   bias = n |v_t|^2 ((a - g) / l - g' / 2) + g' l' v_t

State: centre of mass (3), rotation matrix (9), velocity (3), angular velocity in body axes (3), R of each leg (6).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import erf

from simulate.model.model import Model

from .camera import Motion, values_of
from .leg_law import Law
from .outside import KINDS as OUTSIDE

Array = np.ndarray

SAID = (
    *("hub-inertia", "viscous-friction", "power-law-friction", "stribeck-friction", "rate-dependent-asymptotes", "curved-asymptotes"),
    *("transition-zone", "force-relaxation", "leg-disparity", "leg-mass", "end-stop-dissipation", "gravity-imbalance"),
    *("counterweight-inertia", "pulley-inertia", "pulley-friction", "cable-pendulum", "air-drag", "handrail-contact", "base-excitation"),
    *("centre-of-mass-offset", "release-pose", "eddy-damping", "ripple"),
)
"""Effects that this right-hand side knows."""


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


@dataclass(frozen=True)
class Legs:
    """The six legs at an instant: arm of the platform joint, unit vector, length, its rate, and the joint's velocity."""

    arm: Array
    axis: Array
    length: Array
    rate: Array
    joint: Array


class PlatformInBodyAxes:
    """The right-hand side. Model quantities that effects change are changed here, by this file's own few lines."""

    def __init__(self, model: Model) -> None:
        self.p = p = values_of(model.effects)
        self.require_said(model)
        g, body = model.geometry, model.platform
        assert g is not None
        self.model, self.law = model, Law(model)
        self.outside = [effect for effect in model.effects if effect.name in OUTSIDE and effect.platform_wrench is not None]
        self.base = np.asarray(g.base_joints_m)
        self.centre = np.asarray(body.centre_of_mass_m) + p.get("centre-of-mass-offset", np.zeros(3))
        self.joints = np.asarray(g.platform_joints_m) - self.centre
        self.stowed, self.full = (
            np.linalg.norm(np.add(g.platform_joints_m, (0.0, 0.0, z)) - self.base, axis=1) for z in (g.stowed_height_m, g.deployed_height_m)
        )
        factor = model.gravity.mass_factor
        sideways = float(p.get("counterweight-inertia", (1.0,))[0])
        self.moving = body.mass_kg * factor
        pulley = float(p.get("pulley-inertia", (0.0,))[0])
        self.mass = np.diag([self.moving * sideways, self.moving * sideways, self.moving + pulley])
        self.inertia = np.diag(body.inertia_kg_m2) * factor * sideways
        self.stop = model.end_stop.stiffness_N_per_m, model.end_stop.damping_N_s_per_m + float(p.get("end-stop-dissipation", (0.0,))[0])
        self.strip = float(p.get("leg-mass", (0.0,))[0])
        self.axial = float(p.get("hub-inertia", (0.0,))[0]) + self.strip
        start = self.start()
        released = self.legs(start[:3], start[3:12].reshape(3, 3), np.zeros(3), np.zeros(3))
        self.lowest = np.minimum(self.stowed, released.length)

    def require_said(self, model: Model) -> None:
        """Refuse an effect that this right-hand side would leave out without a word."""
        for effect in model.effects:
            if effect.name not in (*SAID, *OUTSIDE) and effect.acts_on != "measurement":
                raise ValueError(f"{effect.name} is not written in this right-hand side")

    def start(self) -> Array:
        """The state at the release."""
        r, g = self.model.release, self.model.geometry
        assert g is not None
        more = self.p.get("release-pose", np.zeros(9))
        rotation = Rotation.from_rotvec(np.asarray(r.theta_rad) + more[3:6]).as_matrix()
        arm, turning = rotation @ self.centre, np.asarray(r.angular_velocity_rad_per_s)
        place = np.array([0.0, 0.0, g.stowed_height_m]) + r.position_m + more[:3] + arm
        velocity = np.asarray(r.velocity_m_per_s) + more[6:] + np.cross(turning, arm)
        return np.concatenate([place, rotation.ravel(), velocity, rotation.T @ turning, self.law.first])

    def legs(self, place: Array, rotation: Array, velocity: Array, turning: Array) -> Legs:
        """Where the legs are and how they move."""
        arm = self.joints @ rotation.T
        way = place + arm - self.base
        length = np.linalg.norm(way, axis=1)
        axis, joint = way / length[:, None], velocity + _cross(turning, arm)
        return Legs(arm, axis, length, np.sum(axis * joint, axis=1), joint)

    def __call__(self, t: float, y: Array) -> Array:
        """Rates of the state."""
        place, rotation, velocity, spin, force = y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:18], y[18:]
        turning = rotation @ spin
        legs = self.legs(place, rotation, velocity, turning)
        u = legs.length - self.stowed
        pushed = force + self.law.added(u, legs.rate, t, force) + self.stops(legs.length, legs.rate)
        matrix, right = self._bare(spin)
        wrench = self.wrench(t, place, velocity)
        right[:3] += wrench[:3] + legs.axis.T @ pushed
        right[3:] += (wrench[3:] + np.sum(_cross(legs.arm, legs.axis * pushed[:, None]), axis=0)) @ rotation
        if self.axial > 0.0:
            self._held_back(matrix, right, rotation, turning, legs)
        acceleration = np.linalg.solve(matrix, right)
        spinning = rotation @ _skew(spin)
        return np.concatenate([velocity, spinning.ravel(), acceleration, self.law.rate(u, legs.rate, force)])

    def _bare(self, spin: Array) -> tuple[Array, Array]:
        matrix, right = np.zeros((6, 6)), np.zeros(6)
        matrix[:3, :3], matrix[3:, 3:] = self.mass, self.inertia
        right[2] = -self.model.platform.mass_kg * self.model.gravity.acceleration_m_per_s2
        right[3:] = -np.cross(spin, self.inertia @ spin)
        return matrix, right

    def stops(self, length: Array, rate: Array) -> Array:
        """(k p + c p') erf(p / s) against a penetration p above zero, at full length and where the strip is coiled up."""
        (k, c), s = self.stop, self.model.end_stop.smoothing_m
        over, under = np.maximum(length - self.full, 0.0), np.maximum(self.lowest - length, 0.0)
        return -(k * over + c * rate * (over > 0)) * erf(over / s) + (k * under - c * rate * (under > 0)) * erf(under / s)

    def wrench(self, t: float, place: Array, velocity: Array) -> Array:
        """Force, N, and moment about the centre of mass, N m, in world axes; only what comes from outside the catalogue has a moment."""
        p, total, outside = self.p, np.zeros(3), np.zeros(6)
        total[2] += float(p.get("gravity-imbalance", (0.0,))[0]) - float(p.get("pulley-friction", (0.0,))[0]) * np.tanh(velocity[2] / 2e-3)
        total[:2] -= float(p.get("cable-pendulum", (0.0,))[0]) * place[:2]
        total -= float(p.get("air-drag", (0.0,))[0]) * np.linalg.norm(velocity) * velocity
        if "base-excitation" in p:
            size, frequency, phase, *axis = p["base-excitation"]
            total -= self.moving * size * np.sin(2 * np.pi * frequency * t + phase) * np.array(axis)
        if "handrail-contact" in p:
            clearance, stiffness = p["handrail-contact"]
            radius = float(np.hypot(place[0], place[1]))
            normal = stiffness * max(radius - clearance, 0.0)
            total -= 0.2 * normal * velocity / np.sqrt(velocity @ velocity + 5e-3**2)
            total[:2] -= normal * place[:2] / max(radius, 1e-12)
        for effect in self.outside:
            effect.platform_wrench(t, place, velocity, effect.flat(), outside)
        outside[:3] += total
        return outside

    def _held_back(self, matrix: Array, right: Array, rotation: Array, turning: Array, legs: Legs) -> None:
        """The inertia of spools and strips, felt at the platform joints, into matrix and right side."""
        slope = self.strip / (3.0 * self.full)
        across = slope * legs.length
        sideways = legs.joint - legs.rate[:, None] * legs.axis
        outer = legs.axis[:, :, None] * legs.axis[:, None, :]
        mass = self.axial * outer + across[:, None, None] * (np.eye(3) - outer)
        centripetal = _cross(turning, _cross(turning, legs.arm))
        speed = np.sum(sideways**2, axis=1) * ((self.axial - across) / legs.length - slope / 2)
        bias = legs.axis * speed[:, None] + (slope * legs.rate)[:, None] * sideways
        reach = np.concatenate([np.broadcast_to(np.eye(3), (6, 3, 3)), -rotation @ np.array([_skew(r) for r in self.joints])], axis=2)
        matrix += np.einsum("kia,kij,kjb->ab", reach, mass, reach)
        right -= np.einsum("kia,ki->a", reach, np.einsum("kij,kj->ki", mass, centripetal) + bias)


def _skew(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _cross(a: Array, b: Array) -> Array:
    """Vector products row by row, faster than numpy's for so few."""
    x, y, z = a.T
    p, q, r = b.T
    return np.stack([y * r - z * q, z * p - x * r, x * q - y * p], axis=-1)
