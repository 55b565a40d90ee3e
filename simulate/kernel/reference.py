"""The six-leg platform a second time, in plain NumPy: the right-hand side that the compiled kernel is held against.

Nothing of the kernel is used but the formulas of the effects, which exist once. It is some thousand times slower and is there to be
read: `accelerations` is Newton and Euler for one rigid body on six legs,

    (M + sum G' M_b G) a = sum G' (F n - b) + wrench - gyroscopic moment,      G = [1, -[r]x]
    M_b = m n n' + g (1 - n n'),    b = M_b w x (w x r) + n |v_t|^2 ((m - g)/l - g'/2) + g' l' v_t

with n the direction of a leg, l its length, r the arm of its platform joint, m its inertia along and g across the leg, v_t the velocity
of the joint across it. The hysteretic force is the exact function of the path since the last step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from measure.common.arrays import Array
from simulate.kernel.speed_polynomials import with_rate_worked_in
from simulate.model.model import Model
from simulate.model.rig import geometry_of, per_leg

_NEVER = -1e9


@dataclass(frozen=True)
class State:
    """Centre of mass, unit quaternion (scalar first), velocity, angular velocity, height and rate of the base ring; world axes, SI."""

    place: Array
    quaternion: Array
    velocity: Array
    spin: Array
    base: Array

    def moved(self, rate: State, by: float) -> State:
        """The state along a rate of change."""
        return State(*(getattr(self, name) + by * getattr(rate, name) for name in ("place", "quaternion", "velocity", "spin", "base")))


@dataclass(frozen=True)
class Legs:
    """What the legs remember from the last step, (6,) each: elongation, hysteretic force, elongation at the last reversal, direction,
    and the elongation of the strip, which lags behind the leg's where there is play."""

    elongation: Array
    force: Array
    turned_at: Array
    heading: Array
    strip: Array


class Reference:
    """A model, its state at the release, and how both move on."""

    def __init__(self, model: Model) -> None:
        self.model = with_rate_worked_in(model)
        at = self.at = self.model.adjusted()
        g, body = geometry_of(at), at.platform
        self.centre, factor = np.array(body.centre_of_mass_m), at.gravity.mass_factor
        self.base, self.joints = np.array(g.base_joints_m), np.array(g.platform_joints_m) - self.centre
        self.stowed, self.full = (self._lengths(height) for height in (g.stowed_height_m, g.deployed_height_m))
        self.mass, self.inertia = body.mass_kg * factor, np.diag(body.inertia_kg_m2) * factor
        self.weight = np.array([0.0, 0.0, -body.mass_kg * at.gravity.acceleration_m_per_s2])
        self.acting: list[tuple[Any, list[float]]] = [(e, [*e.flat().tolist(), *e.constants_of(at)]) for e in self.model.effects]
        self.lowest = np.minimum(self.lengths_of(self.release()) - self.stowed, 0.0)

    def _lengths(self, height: float) -> Array:
        return np.linalg.norm(self.joints + self.centre + [0.0, 0.0, height] - self.base, axis=1)

    def lengths_of(self, state: State) -> Array:
        """(6,) lengths of the legs, which stand on the base ring."""
        return np.linalg.norm(state.place - [0.0, 0.0, state.base[0]] + self.joints @ rotation(state.quaternion).T - self.base, axis=1)

    def release(self) -> State:
        """The state at the release: the stowed pose, moved, turned and set going as the model says."""
        given, turn = self.at.release, np.array(self.at.release.theta_rad)
        angle = float(np.linalg.norm(turn))
        q = np.array([math.cos(angle / 2), *(turn * (0.5 if angle == 0.0 else math.sin(angle / 2) / angle))])
        arm, spin = rotation(q) @ self.centre, np.array(given.angular_velocity_rad_per_s)
        place = np.array([0.0, 0.0, geometry_of(self.at).stowed_height_m]) + given.position_m + arm
        return State(place, q, given.velocity_m_per_s + np.cross(spin, arm), spin, np.zeros(2))

    def legs_at_release(self) -> Legs:
        """The legs at the release, none of which has turned back yet."""
        force = per_leg(self.at.actuator.initial_force_N)
        u = self.lengths_of(self.release()) - self.stowed
        return Legs(u, force, np.full(6, _NEVER), np.zeros(6), u)

    def strip(self, u: Array, before: Legs) -> Array:
        """(6,) what of the elongation of the legs reaches their strips, m."""
        for effect, p in self.acting:
            if effect.strip_elongation:
                u = np.array([effect.strip_elongation(u[i], before.strip[i], p) for i in range(6)])
        return u

    def hysteretic(self, u: Array, v: Array, t: float, before: Legs, t0: float) -> Array:
        """(6,) force that started at `before` and ran along the active asymptote, replaced by its chord, N."""
        law, u = self.at.actuator, self.strip(u, before)
        x = per_leg(law.beta_per_m) * np.abs(u - before.strip)
        active = np.empty((2, 6))
        for row, (where, when) in enumerate(((before.strip, t0), (u, t))):
            both = np.array([per_leg(law.a_l_N_per_m) * where + per_leg(law.b_l_N), per_leg(law.a_u_N_per_m) * where + per_leg(law.b_u_N)])
            for effect, p in self.acting:
                for i in range(6) if effect.leg_asymptotes else ():
                    h = both[:, i].copy()
                    effect.leg_asymptotes(where[i], v[i], when, p, h)
                    both[:, i] = h
            active[row] = np.where(u > before.strip, *both)
        lag = np.divide(active[1] - active[0], x, out=np.zeros(6), where=x > 1e-12)
        return np.where(x > 1e-12, active[1] - lag + (before.force - active[0] + lag) * np.exp(-x), before.force)

    def stops(self, u: Array, v: Array) -> Array:
        """(6,) force of the stops at both ends of the stroke, N."""
        stop = self.at.end_stop
        over, under = np.maximum(u - self.full + self.stowed, 0.0), np.maximum(self.lowest - u, 0.0)
        eased = np.array([math.erf(p / stop.smoothing_m) for p in over + under])
        return (stop.stiffness_N_per_m * (under - over) - stop.damping_N_s_per_m * v) * eased

    def accelerations(self, state: State, t: float, before: Legs, t0: float) -> tuple[Array, Array, Array]:
        """Linear and angular acceleration and that of the base (7,), elongation (6,) and hysteretic force (6,) of the legs.

        Seven equations: with the base, whose height is a coordinate like the others, the legs have G = [1, -[r]x, -z].
        """
        turn, spin = rotation(state.quaternion), state.spin
        matrix = np.zeros((6, 6))
        base_mass, on_base = self._base(state)
        matrix[:3, :3], matrix[3:, 3:] = self.mass * np.eye(3), turn @ self.inertia @ turn.T
        pose, twist = np.concatenate([state.place, state.quaternion]), np.concatenate([state.velocity, spin])
        right = np.concatenate([self.weight, np.zeros(3)])
        for effect, p in self.acting:
            if effect.platform_mass:
                flat = matrix.ravel().copy()
                effect.platform_mass(pose, p, flat)
                matrix = flat.reshape(6, 6)
            if effect.platform_wrench:
                effect.platform_wrench(t, pose, twist, p, right)
        right[3:] -= np.cross(spin, matrix[3:, 3:] @ spin)
        matrix, right = np.pad(matrix, (0, 1)), np.append(right, on_base)
        matrix[6, 6] = base_mass
        up = np.array([0.0, 0.0, 1.0])
        arms = self.joints @ turn.T
        ways = state.place - state.base[0] * up + arms - self.base
        length = np.linalg.norm(ways, axis=1)
        n, moving = ways / length[:, None], state.velocity - state.base[1] * up + np.cross(spin, arms)
        u, v = length - self.stowed, np.sum(ways / length[:, None] * moving, axis=1)
        stored = self.hysteretic(u, v, t, before, t0)
        push = stored + self.stops(u, v)
        for effect, p in self.acting:
            if effect.leg_force:
                push += [effect.leg_force(u[i], v[i], t, stored[i], u[i] - before.turned_at[i], p) for i in range(6)]
        for i in range(6):
            mass, across = self._inertia(u[i], length[i], self.full[i])
            lateral, outer = moving[i] - v[i] * n[i], np.outer(n[i], n[i])
            own = mass * outer + across[0] * (np.eye(3) - outer)
            bias = own @ np.cross(spin, np.cross(spin, arms[i])) + across[1] * v[i] * lateral
            bias += n[i] * (lateral @ lateral) * ((mass - across[0]) / length[i] - across[1] / 2)
            moment, lever = self._joints(n[i], np.cross(n[i], lateral) / length[i], spin, length[i])
            g = np.hstack([np.eye(3), -skew(arms[i]), -up[:, None]])
            matrix = matrix + g.T @ own @ g
            right += g.T @ (push[i] * n[i] - bias + lever) + np.concatenate([np.zeros(3), moment, [0.0]])
        free = 7 if base_mass > 0.0 else 6
        return np.append(np.linalg.solve(matrix[:free, :free], right[:free]), np.zeros(7 - free)), u, stored

    def _base(self, state: State) -> tuple[float, float]:
        """Mass of the base ring, kg, and the force of what holds it, N: its springs have carried the platform since before the release."""
        mass, force = 0.0, -self.weight[2]
        for effect, p in self.acting:
            if effect.base_mass:
                mass += effect.base_mass(p)
            if effect.base_force:
                force += effect.base_force(state.base[0], state.base[1], p)
        return mass, force

    def _inertia(self, u: float, length: float, full: float) -> tuple[float, Array]:
        """Inertia along a leg, kg; across it, kg, and its slope over the length, kg/m."""
        across = np.zeros(2)
        for effect, p in self.acting:
            if effect.leg_transverse:
                effect.leg_transverse(length, full, p, across)
        return sum(effect.leg_mass(u, p) for effect, p in self.acting if effect.leg_mass), across

    def _joints(self, n: Array, turning: Array, spin: Array, length: float) -> tuple[Array, Array]:
        """Friction of a leg's joints: moment on the platform, and the force by which the leg hands on what acts on it."""
        moment, on_leg = np.zeros(3), np.zeros(3)
        for effect, p in self.acting:
            if effect.joint_resistance:
                at_base = -effect.joint_resistance(float(np.linalg.norm(turning)), p) * turning
                at_platform = -effect.joint_resistance(float(np.linalg.norm(spin - turning)), p) * (spin - turning)
                moment, on_leg = moment + at_platform, on_leg + at_base - at_platform
        return moment, np.cross(on_leg, n) / length

    def rate(self, state: State, t: float, before: Legs, t0: float) -> tuple[State, Array, Array]:
        """Rate of change of the state, and what the legs do."""
        a, u, force = self.accelerations(state, t, before, t0)
        w, q = state.spin, state.quaternion
        turning = 0.5 * np.array([-w @ q[1:], *(w * q[0] + np.cross(w, q[1:]))])
        return State(state.velocity, turning, a[:3], a[3:6], np.array([state.base[1], a[6]])), u, force

    def later(self, state: State, first: State, t: float, step: float, legs: Legs) -> State:
        """The state at the end of a step, from its first rate: the other three stages of classical Runge-Kutta."""
        second = self.rate(state.moved(first, step / 2), t + step / 2, legs, t)[0]
        third = self.rate(state.moved(second, step / 2), t + step / 2, legs, t)[0]
        last = self.rate(state.moved(third, step), t + step, legs, t)[0]
        for rate, weight in ((first, 1), (second, 2), (third, 2), (last, 1)):
            state = state.moved(rate, weight * step / 6)
        return replace(state, quaternion=state.quaternion / np.linalg.norm(state.quaternion))

    def run(self, step: float, steps: int) -> tuple[Array, Array]:
        """Classical Runge-Kutta from the release on: (steps + 1, 3) origin of the platform frame, (steps + 1, 4) quaternion."""
        state, legs, places = self.release(), self.legs_at_release(), []
        for k in range(steps + 1):
            t = k * step
            places.append(np.concatenate([state.place - rotation(state.quaternion) @ self.centre, state.quaternion]))
            first, u, force = self.rate(state, t, legs, max(t - step, 0.0))
            legs = carried(legs, u, force, self.strip(u, legs))
            state = self.later(state, first, t, step, legs)
        rows = np.array(places)
        return rows[:, :3], rows[:, 3:]


def carried(before: Legs, u: Array, force: Array, strip: Array) -> Legs:
    """The legs at the start of a step: a leg whose travel has changed its sign turned back where the last step began."""
    travel = u - before.elongation
    turned = np.where(travel * before.heading < 0.0, before.elongation, before.turned_at)
    return Legs(u, force, turned, np.where(travel != 0.0, travel, before.heading), strip)


def rotation(q: Array) -> Array:
    """Rotation matrix (3, 3), platform axes to world axes, of a unit quaternion (4,): (q0^2 - |q|^2) 1 + 2 q q' + 2 q0 [q]x."""
    return (q[0] ** 2 - q[1:] @ q[1:]) * np.eye(3) + 2 * np.outer(q[1:], q[1:]) + 2 * q[0] * skew(q[1:])


def skew(a: Array) -> Array:
    """The matrix [a]x of the vector product a x b."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])
