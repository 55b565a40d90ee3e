"""The mechanics of the six-leg platform, compiled: from a state to its rate of change.

The legs are massless but for what effects add along them, so nothing has to be closed (r the arm of a platform joint):

    (M + sum m_h J'J) a = sum J' (F - m_h c) + wrench - bias,   l' = J v,   l'' = J a + c,   J = [e, r x e]

State: position of the centre of mass (3), unit quaternion (4), velocity (3), angular velocity (3), world axes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit

from measure.tables import Array

from .compiled import Program, call_platform_mass, call_platform_wrench, pointer
from .crosswise import ARM, AXIS, RIGHT, ROTATION, SYSTEM, G, cross, leg_crosswise, transverse_mass
from .law import advance, asymptotes, axial_mass, direct_force
from .packing import FULL, INERTIA, JOINT, LEG, LEG_SIZE, LINE, MASS, STOP, STOWED, WEIGHT

LEGS = 6
STATES = 13
POWERS = 4  # behind the rate of the state: power of the legs, the stops, the weight, the effects

# Places in the workspace of a run, behind those of `crosswise`. LEG_OUT: elongation, speed, hysteretic and whole force, six each.
WRENCH, H, H0, LEG_OUT = 60, 66, 68, 70
WORK = LEG_OUT + 4 * LEGS


class Legs(NamedTuple):
    """What the six legs carry from step to step, (6,) each: elongation, hysteretic force, elongation at the last reversal, heading."""

    elongation: Array
    stored: Array
    turned: Array
    heading: Array


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def derivative(values: Array, called: Program, state: Array, legs: Legs, t0: float, t: float, w: Array, out: Array) -> None:
    """Rate of the state and, behind it, the power of legs, stops, weight and effects (N m/s), into out.

    legs : elongation and hysteretic force of each leg at the start of the step, time t0.
    w : workspace; afterwards elongation, speed, hysteretic and whole force of each leg stand at LEG_OUT.
    """
    rotate(state, w)
    start_system(values, called, state, w)
    out[STATES : STATES + POWERS] = 0.0
    for leg in range(LEGS):
        leg_forces(values, called, leg, state, legs, t0, t, w, out)
    platform_forces(values, called, state, t, w, out)
    solve(w)
    x, v = state, out
    v[0], v[1], v[2] = x[7], x[8], x[9]
    v[3] = -0.5 * (x[10] * x[4] + x[11] * x[5] + x[12] * x[6])
    v[4] = 0.5 * (x[10] * x[3] + x[11] * x[6] - x[12] * x[5])
    v[5] = 0.5 * (x[11] * x[3] + x[12] * x[4] - x[10] * x[6])
    v[6] = 0.5 * (x[12] * x[3] + x[10] * x[5] - x[11] * x[4])
    out[7:13] = w[RIGHT : RIGHT + 6]


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def start_system(values: Array, called: Program, state: Array, w: Array) -> None:
    """Mass matrix and right side of the platform: mass, turned inertia, effects on both, weight, gyroscopic moment."""
    w[SYSTEM : SYSTEM + 42] = 0.0
    for i in range(3):
        w[SYSTEM + 7 * i] = values[MASS + i]
        w[RIGHT + i] = values[WEIGHT + i]
        for j in range(3):
            inertia = 0.0
            for k in range(3):
                inertia += w[3 * i + k] * values[INERTIA + k] * w[3 * j + k]
            w[SYSTEM + 6 * (3 + i) + 3 + j] = inertia
    for row in range(called.platform_mass.shape[0]):
        p = pointer(values, called.platform_mass[row, 1])
        call_platform_mass(called.platform_mass[row, 0], (pointer(state, 0), p, pointer(w, SYSTEM)))
    s = SYSTEM + 21
    x, y, z = state[10], state[11], state[12]
    spin0 = w[s] * x + w[s + 1] * y + w[s + 2] * z
    spin1 = w[s + 6] * x + w[s + 7] * y + w[s + 8] * z
    spin2 = w[s + 12] * x + w[s + 13] * y + w[s + 14] * z
    w[RIGHT + 3] = -(y * spin2 - z * spin1)
    w[RIGHT + 4] = -(z * spin0 - x * spin2)
    w[RIGHT + 5] = -(x * spin1 - y * spin0)


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def leg_forces(values: Array, called: Program, leg: int, state: Array, legs: Legs, t0: float, t: float, w: Array, out: Array) -> None:
    """One leg: its law, its stop and its effects, into the system."""
    at = LEG + leg * LEG_SIZE
    length = leg_axis(values, at, state, w, ROTATION, w, ARM, w, AXIS)
    u = length - values[at + STOWED]
    rx, ry, rz = w[ARM], w[ARM + 1], w[ARM + 2]
    ex, ey, ez = w[AXIS], w[AXIS + 1], w[AXIS + 2]
    ox, oy, oz = state[10], state[11], state[12]
    swing_x, swing_y, swing_z = oy * rz - oz * ry, oz * rx - ox * rz, ox * ry - oy * rx
    px, py, pz = state[7] + swing_x, state[8] + swing_y, state[9] + swing_z
    v = px * ex + py * ey + pz * ez
    stored = stored_force(values, called, at, legs.elongation[leg], legs.stored[leg], u, v, t0, t, w)
    stop = stop_force(values, u - values[at + FULL], v)
    added = direct_force(values, called, u, v, t, stored, u - legs.turned[leg])
    mass = axial_mass(values, called, u)
    # l'' = J a + c: centripetal part of the joint along the leg, and the turning of the leg itself
    cross = ex * (oy * swing_z - oz * swing_y) + ey * (oz * swing_x - ox * swing_z) + ez * (ox * swing_y - oy * swing_x)
    bias = cross + (px * px + py * py + pz * pz - v * v) / length
    force = stored + stop + added
    push = force - mass * bias
    jacobian = (ex, ey, ez, ry * ez - rz * ey, rz * ex - rx * ez, rx * ey - ry * ex)
    for i in range(6):
        w[RIGHT + i] += jacobian[i] * push
    if mass != 0.0:
        for i in range(6):
            for k in range(i + 1):
                w[SYSTEM + 6 * i + k] += mass * jacobian[i] * jacobian[k]
    if called.leg_transverse.shape[0] + called.joint_resistance.shape[0] > 0:
        leg_crosswise(values, called, at, state, length, v, w, out)
    out[STATES] += stored * v
    out[STATES + 1] += stop * v
    out[STATES + 3] += added * v
    w[LEG_OUT + leg], w[LEG_OUT + 6 + leg], w[LEG_OUT + 12 + leg], w[LEG_OUT + 18 + leg] = u, v, stored, force


@njit(cache=True, forceinline=True)
def stored_force(
    values: Array, called: Program, at: int, u0: float, force0: float, u: float, v: float, t0: float, t: float, w: Array
) -> float:
    """Hysteretic force at u, on the way from (u0, force0) without reversal."""
    if u == u0:
        return force0
    asymptotes(values, at + LINE, called, u0, v, t0, w, H0)
    asymptotes(values, at + LINE, called, u, v, t, w, H)
    side = 0 if u > u0 else 1
    return advance(force0, u - u0, w[H0 + side], w[H + side], values[at + LINE + 4])


@njit(cache=True, forceinline=True)
def stop_force(values: Array, penetration: float, v: float) -> float:
    """Force of the stop at full length, negative: -(k p + c v) erf(p / s) for a penetration p above zero."""
    if penetration <= 0.0:
        return 0.0
    return -(values[STOP] * penetration + values[STOP + 1] * v) * math.erf(penetration / values[STOP + 2])


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def platform_forces(values: Array, called: Program, state: Array, t: float, w: Array, out: Array) -> None:
    """Wrenches and inertia that effects add to the platform, and the power of the weight."""
    for row in range(called.platform_wrench.shape[0]):
        w[WRENCH : WRENCH + 6] = 0.0
        p = pointer(values, called.platform_wrench[row, 1])
        call_platform_wrench(called.platform_wrench[row, 0], (t, pointer(state, 0), pointer(state, 7), p, pointer(w, WRENCH)))
        for i in range(6):
            w[RIGHT + i] += w[WRENCH + i]
            out[STATES + 3] += w[WRENCH + i] * state[7 + i]
    for i in range(3):
        out[STATES + 2] += values[WEIGHT + i] * state[7 + i]


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def solve(w: Array) -> None:
    """Solve the 6 x 6 system in place by Cholesky, reading its lower half; the accelerations replace the right side."""
    for i in range(6):
        for j in range(i + 1):
            total = w[SYSTEM + 6 * i + j]
            for k in range(j):
                total -= w[SYSTEM + 6 * i + k] * w[SYSTEM + 6 * j + k]
            if i == j:
                w[SYSTEM + 7 * i] = 1.0 / math.sqrt(total)
            else:
                w[SYSTEM + 6 * i + j] = total * w[SYSTEM + 7 * j]
    for i in range(6):
        for k in range(i):
            w[RIGHT + i] -= w[SYSTEM + 6 * i + k] * w[RIGHT + k]
        w[RIGHT + i] *= w[SYSTEM + 7 * i]
    for i in range(5, -1, -1):
        for k in range(i + 1, 6):
            w[RIGHT + i] -= w[SYSTEM + 6 * k + i] * w[RIGHT + k]
        w[RIGHT + i] *= w[SYSTEM + 7 * i]


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def kinetic_energy(values: Array, called: Program, state: Array, w: Array) -> float:
    """Half of v' M v with everything that moves, J; expects the legs of this state in the workspace."""
    start_system(values, called, state, w)
    energy = 0.0
    for i in range(6):
        for k in range(6):
            energy += 0.5 * w[SYSTEM + 6 * i + k] * state[7 + i] * state[7 + k]
    for leg in range(LEGS):
        energy += 0.5 * axial_mass(values, called, w[LEG_OUT + leg]) * w[LEG_OUT + 6 + leg] ** 2
        if called.leg_transverse.shape[0] > 0:
            at = LEG + leg * LEG_SIZE
            length = leg_axis(values, at, state, w, ROTATION, w, ARM, w, AXIS)
            transverse_mass(values, called, at, length, w)
            swing = cross((state[10], state[11], state[12]), (w[ARM], w[ARM + 1], w[ARM + 2]))
            squared = (state[7] + swing[0]) ** 2 + (state[8] + swing[1]) ** 2 + (state[9] + swing[2]) ** 2
            energy += 0.5 * w[G] * (squared - w[LEG_OUT + 6 + leg] ** 2)
    return energy


@njit(cache=True, forceinline=True)
def rotate(state: Array, matrix: Array) -> None:
    """Rotation matrix of the state, platform axes to world axes, row by row into matrix[0:9]."""
    w, x, y, z = state[3], state[4], state[5], state[6]
    matrix[0], matrix[1], matrix[2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    matrix[3], matrix[4], matrix[5] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    matrix[6], matrix[7], matrix[8] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@njit(cache=True, forceinline=True)
def leg_axis(values: Array, at: int, state: Array, R: Array, r0: int, arm: Array, a0: int, axis: Array, e0: int) -> float:
    """Arm of the platform joint and direction of a leg, in world axes; returns the leg's length."""
    j = at + JOINT
    for k in range(3):
        arm[a0 + k] = R[r0 + 3 * k] * values[j] + R[r0 + 3 * k + 1] * values[j + 1] + R[r0 + 3 * k + 2] * values[j + 2]
        axis[e0 + k] = state[k] + arm[a0 + k] - values[at + k]
    length = math.sqrt(axis[e0] ** 2 + axis[e0 + 1] ** 2 + axis[e0 + 2] ** 2)
    for k in range(3):
        axis[e0 + k] /= length
    return length
