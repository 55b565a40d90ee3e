"""What a leg does across its own direction: inertia of its strip, friction of its joints. Absent unless an effect asks for it."""

from __future__ import annotations

import math

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaPointers
from simulate.kernel import contributions
from simulate.kernel.layout import ARM, AXIS, LENGTH, RIGHT, SLOPE, SYSTEM, TRIAL, G, V

Triple = tuple[float, float, float]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_transverse(w: Array, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Inertia across the leg at hand and friction in its joints, into the system.

    M_t = g (1 - n n'),   bias = g (1 - n n') c + g' l' v_t - n |v_t|^2 (g / l + g' / 2),   c = w x (w x r)

    added as G' M_t G, G = [1, -[r]x]. The leg turns with w_l = n x v_t / l, and its joints resist w_l and w - w_l.
    """
    contributions.transverse_inertia(w, by_run, formulas, n)
    for i in range(n):
        g, slope, v, length = w[G * n + i], w[SLOPE * n + i], w[V * n + i], w[LENGTH * n + i]
        r, e, spin = triple(w, ARM, n, i), triple(w, AXIS, n, i), triple(w, TRIAL + 10, n, i)
        swing, flight = cross(spin, r), triple(w, TRIAL + 7, n, i)
        moving = (flight[0] + swing[0] - v * e[0], flight[1] + swing[1] - v * e[1], flight[2] + swing[2] - v * e[2])
        moment, lever = joint_moments(w, by_run, formulas, n, i, moving, with_work)
        centripetal = cross(spin, swing)
        along = dot(e, centripetal) * g + dot(moving, moving) * (g / length + 0.5 * slope)
        force = (
            along * e[0] - g * centripetal[0] - slope * v * moving[0] + lever[0],
            along * e[1] - g * centripetal[1] - slope * v * moving[1] + lever[1],
            along * e[2] - g * centripetal[2] - slope * v * moving[2] + lever[2],
        )
        turned = cross(r, force)
        for k in range(3):
            w[(RIGHT + k) * n + i] += force[k]
            w[(RIGHT + 3 + k) * n + i] += turned[k] + moment[k]
        add_across(w, g, r, e, n, i)


@njit(cache=True, error_model="numpy", forceinline=True)
def joint_moments(
    w: Array, by_run: Array, formulas: FormulaPointers, n: int, i: int, moving: Triple, with_work: bool
) -> tuple[Triple, Triple]:
    """Friction of a leg's two joints: moment on the platform, and force at the platform joint."""
    e, spin, per = triple(w, AXIS, n, i), triple(w, TRIAL + 10, n, i), 1.0 / w[LENGTH * n + i]
    swing = cross(e, moving)
    turning = (swing[0] * per, swing[1] * per, swing[2] * per)
    against = (spin[0] - turning[0], spin[1] - turning[1], spin[2] - turning[2])
    base = contributions.sum_joint_resistance(w, by_run, formulas, i, n, math.sqrt(dot(turning, turning)), with_work)
    joint = contributions.sum_joint_resistance(w, by_run, formulas, i, n, math.sqrt(dot(against, against)), with_work)
    moment = (-joint * against[0], -joint * against[1], -joint * against[2])
    on_leg = (-base * turning[0] - moment[0], -base * turning[1] - moment[1], -base * turning[2] - moment[2])
    lever = cross(on_leg, e)
    return moment, (lever[0] * per, lever[1] * per, lever[2] * per)


@njit(cache=True, error_model="numpy", forceinline=True)
def add_across(w: Array, g: float, r: Triple, e: Triple, n: int, i: int) -> None:
    """Adds G' g (1 - n n') G to the lower half of the mass matrix."""
    lever = cross(r, e)
    jacobian = (e[0], e[1], e[2], lever[0], lever[1], lever[2])
    for row in range(6):
        for column in range(row + 1):
            w[(SYSTEM + row * (row + 1) // 2 + column) * n + i] -= g * jacobian[row] * jacobian[column]
    x, y, z = r
    w[SYSTEM * n + i] += g
    w[(SYSTEM + 2) * n + i] += g
    w[(SYSTEM + 5) * n + i] += g
    w[(SYSTEM + 7) * n + i] -= g * z
    w[(SYSTEM + 8) * n + i] += g * y
    w[(SYSTEM + 9) * n + i] += g * (y * y + z * z)
    w[(SYSTEM + 10) * n + i] += g * z
    w[(SYSTEM + 12) * n + i] -= g * x
    w[(SYSTEM + 13) * n + i] -= g * x * y
    w[(SYSTEM + 14) * n + i] += g * (x * x + z * z)
    w[(SYSTEM + 15) * n + i] -= g * y
    w[(SYSTEM + 16) * n + i] += g * x
    w[(SYSTEM + 18) * n + i] -= g * x * z
    w[(SYSTEM + 19) * n + i] -= g * y * z
    w[(SYSTEM + 20) * n + i] += g * (x * x + y * y)


@njit(cache=True, error_model="numpy", forceinline=True)
def triple(w: Array, row: int, n: int, i: int) -> Triple:
    """Three rows of a run."""
    return w[row * n + i], w[(row + 1) * n + i], w[(row + 2) * n + i]


@njit(cache=True, error_model="numpy", forceinline=True)
def cross(a: Triple, b: Triple) -> Triple:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy", forceinline=True)
def dot(a: Triple, b: Triple) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
