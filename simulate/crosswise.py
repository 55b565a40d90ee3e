"""What a leg does across its own direction: inertia of its strip, friction of its joints. Absent unless an effect asks for it."""

from __future__ import annotations

import math

from numba import njit

from measure.tables import Array

from .compiled import Program, call_joint_resistance, call_leg_transverse, pointer
from .packing import FULL, STOWED

Triple = tuple[float, float, float]

# Places in the workspace of a run: rotation (9), mass matrix (36), right side (6), arm (3) and axis (3) of a leg, g and its slope.
ROTATION, SYSTEM, RIGHT, ARM, AXIS, G = 0, 9, 45, 51, 54, 57
STATES, BY_EFFECTS = 13, 16  # in a rate: places of the state and of the power of the effects


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def leg_crosswise(values: Array, called: Program, at: int, state: Array, length: float, v: float, w: Array, out: Array) -> None:
    """Inertia across a leg and friction in its joints, into the system.

    M_t = g (1 - n n'),   bias = g (1 - n n') c + g' l' v_t - n |v_t|^2 (g / l + g' / 2),   c = w x (w x r)

    added as G' M_t G, G = [1, -[r]x]. The leg turns with w_l = n x v_t / l, and its joints resist w_l and w - w_l.
    """
    transverse_mass(values, called, at, length, w)
    g, slope = w[G], w[G + 1]
    r, n = (w[ARM], w[ARM + 1], w[ARM + 2]), (w[AXIS], w[AXIS + 1], w[AXIS + 2])
    spin = (state[10], state[11], state[12])
    swing = cross(spin, r)
    moving = (state[7] + swing[0] - v * n[0], state[8] + swing[1] - v * n[1], state[9] + swing[2] - v * n[2])
    moment, lever = joint_moments(values, called, spin, moving, n, length, out)
    centripetal = cross(spin, swing)
    along = dot(n, centripetal) * g + dot(moving, moving) * (g / length + 0.5 * slope)
    force = (
        along * n[0] - g * centripetal[0] - slope * v * moving[0] + lever[0],
        along * n[1] - g * centripetal[1] - slope * v * moving[1] + lever[1],
        along * n[2] - g * centripetal[2] - slope * v * moving[2] + lever[2],
    )
    turned = cross(r, force)
    for k in range(3):
        w[RIGHT + k] += force[k]
        w[RIGHT + 3 + k] += turned[k] + moment[k]
    add_across(g, r, n, w)


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def joint_moments(
    values: Array, called: Program, spin: Triple, moving: Triple, n: Triple, length: float, out: Array
) -> tuple[Triple, Triple]:
    """Friction of a leg's two joints: moment on the platform, and force at the platform joint."""
    swing = cross(n, moving)
    turning = (swing[0] / length, swing[1] / length, swing[2] / length)
    against = (spin[0] - turning[0], spin[1] - turning[1], spin[2] - turning[2])
    base = joint_resistance(values, called, math.sqrt(dot(turning, turning)))
    joint = joint_resistance(values, called, math.sqrt(dot(against, against)))
    out[BY_EFFECTS] -= base * dot(turning, turning) + joint * dot(against, against)
    moment = (-joint * against[0], -joint * against[1], -joint * against[2])
    on_leg = (-base * turning[0] - moment[0], -base * turning[1] - moment[1], -base * turning[2] - moment[2])
    lever = cross(on_leg, n)
    return moment, (lever[0] / length, lever[1] / length, lever[2] / length)


@njit(cache=True, forceinline=True)
def transverse_mass(values: Array, called: Program, at: int, length: float, w: Array) -> None:
    """Inertia that effects add across a leg at its platform joint, and its slope over the length, into w[G] and w[G + 1]."""
    w[G], w[G + 1] = 0.0, 0.0
    full = values[at + STOWED] + values[at + FULL]
    for row in range(called.leg_transverse.shape[0]):
        p = pointer(values, called.leg_transverse[row, 1])
        call_leg_transverse(called.leg_transverse[row, 0], (length, full, p, pointer(w, G)))


@njit(cache=True, forceinline=True)
def joint_resistance(values: Array, called: Program, rate: float) -> float:
    """Sum of the resistances that effects put into a joint, N m s."""
    total = 0.0
    for row in range(called.joint_resistance.shape[0]):
        total += call_joint_resistance(called.joint_resistance[row, 0], (rate, pointer(values, called.joint_resistance[row, 1])))
    return total


@njit(cache=True, error_model="numpy", fastmath={"contract"}, forceinline=True)
def add_across(g: float, r: Triple, n: Triple, w: Array) -> None:
    """Adds G' g (1 - n n') G to the lower half of the mass matrix."""
    lever = cross(r, n)
    jacobian = (n[0], n[1], n[2], lever[0], lever[1], lever[2])
    for i in range(6):
        for k in range(i + 1):
            w[SYSTEM + 6 * i + k] -= g * jacobian[i] * jacobian[k]
    squared = dot(r, r)
    for i in range(3):
        w[SYSTEM + 7 * i] += g
        w[SYSTEM + 7 * (3 + i)] += g * squared
        for k in range(i + 1):
            w[SYSTEM + 6 * (3 + i) + 3 + k] -= g * r[i] * r[k]
    w[SYSTEM + 19] -= g * r[2]
    w[SYSTEM + 20] += g * r[1]
    w[SYSTEM + 24] += g * r[2]
    w[SYSTEM + 26] -= g * r[0]
    w[SYSTEM + 30] -= g * r[1]
    w[SYSTEM + 31] += g * r[0]


@njit(cache=True, fastmath={"contract"}, forceinline=True)
def cross(a: Triple, b: Triple) -> Triple:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, fastmath={"contract"}, forceinline=True)
def dot(a: Triple, b: Triple) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
