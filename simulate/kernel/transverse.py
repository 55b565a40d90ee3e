"""What a leg does across its own direction: inertia of its strip, friction of its joints. Absent unless an effect asks for it."""

from __future__ import annotations

import math

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaPointers
from simulate.dispatch.lanes import Lanes, Rows
from simulate.kernel import contributions
from simulate.kernel.layout import ARM, AXIS, EACH, LENGTH, RIGHT, SLOPE, SYSTEM, TRIAL, G, V

Triple = tuple[Lanes, Lanes, Lanes]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_transverse(w: Rows, flat: Array, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Inertia across the leg at hand and friction in its joints, into the system.

    M_t = g (1 - n n'),   bias = g (1 - n n') c + g' l' v_t - n |v_t|^2 (g / l + g' / 2),   c = w x (w x r)

    added as G' M_t G, G = [1, -[r]x]. The leg turns with w_l = n x v_t / l, and its joints resist w_l and w - w_l.
    """
    contributions.transverse_inertia(flat, by_run, formulas, n)
    g, slope, v, length = w[G], w[SLOPE], w[V], w[LENGTH]
    r, e, spin = triple(w, ARM), triple(w, AXIS), triple(w, TRIAL + 10)
    swing, flight = cross(spin, r), triple(w, TRIAL + 7)
    moving = (flight[0] + swing[0] - v * e[0], flight[1] + swing[1] - v * e[1], flight[2] + swing[2] - v * e[2])
    moment, lever = joint_moments(w, flat, by_run, formulas, n, moving, with_work)
    centripetal = cross(spin, swing)
    along = dot(e, centripetal) * g + dot(moving, moving) * (g / length + 0.5 * slope)
    force = (
        along * e[0] - g * centripetal[0] - slope * v * moving[0] + lever[0],
        along * e[1] - g * centripetal[1] - slope * v * moving[1] + lever[1],
        along * e[2] - g * centripetal[2] - slope * v * moving[2] + lever[2],
    )
    turned = cross(r, force)
    for k in range(3):
        w[RIGHT + k] += force[k]
        w[RIGHT + 3 + k] += turned[k] + moment[k]
    add_across(w, g, r, e)


@njit(cache=True, error_model="numpy", forceinline=True)
def joint_moments(
    w: Rows, flat: Array, by_run: Array, formulas: FormulaPointers, n: int, moving: Triple, with_work: bool
) -> tuple[Triple, Triple]:
    """Friction of a leg's two joints: moment on the platform, and force at the platform joint."""
    e, spin, per = triple(w, AXIS), triple(w, TRIAL + 10), 1.0 / w[LENGTH]
    swing = cross(e, moving)
    turning = (swing[0] * per, swing[1] * per, swing[2] * per)
    against = (spin[0] - turning[0], spin[1] - turning[1], spin[2] - turning[2])
    base = resistance(w, flat, by_run, formulas, n, math.sqrt(dot(turning, turning)), with_work)
    joint = resistance(w, flat, by_run, formulas, n, math.sqrt(dot(against, against)), with_work)
    moment = (-joint * against[0], -joint * against[1], -joint * against[2])
    on_leg = (-base * turning[0] - moment[0], -base * turning[1] - moment[1], -base * turning[2] - moment[2])
    lever = cross(on_leg, e)
    return moment, (lever[0] * per, lever[1] * per, lever[2] * per)


@njit(cache=True, error_model="numpy", forceinline=True)
def resistance(w: Rows, flat: Array, by_run: Array, formulas: FormulaPointers, n: int, rate: Lanes, with_work: bool) -> Lanes:
    """Resistance of a joint that turns at this rate, N m s."""
    w[EACH] = rate
    for i in range(n):
        flat[EACH * n + i] = contributions.sum_joint_resistance(flat, by_run, formulas, i, n, flat[EACH * n + i], with_work)
    return w[EACH]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_across(w: Rows, g: Lanes, r: Triple, e: Triple) -> None:
    """Adds G' g (1 - n n') G to the lower half of the mass matrix."""
    lever = cross(r, e)
    jacobian = (e[0], e[1], e[2], lever[0], lever[1], lever[2])
    for row in range(6):
        for column in range(row + 1):
            w[SYSTEM + row * (row + 1) // 2 + column] -= g * jacobian[row] * jacobian[column]
    x, y, z = r
    w[SYSTEM] += g
    w[SYSTEM + 2] += g
    w[SYSTEM + 5] += g
    w[SYSTEM + 7] -= g * z
    w[SYSTEM + 8] += g * y
    w[SYSTEM + 9] += g * (y * y + z * z)
    w[SYSTEM + 10] += g * z
    w[SYSTEM + 12] -= g * x
    w[SYSTEM + 13] -= g * x * y
    w[SYSTEM + 14] += g * (x * x + z * z)
    w[SYSTEM + 15] -= g * y
    w[SYSTEM + 16] += g * x
    w[SYSTEM + 18] -= g * x * z
    w[SYSTEM + 19] -= g * y * z
    w[SYSTEM + 20] += g * (x * x + y * y)


@njit(cache=True, error_model="numpy", forceinline=True)
def triple(w: Rows, row: int) -> Triple:
    """Three rows of a run."""
    return w[row], w[row + 1], w[row + 2]


@njit(cache=True, error_model="numpy", forceinline=True)
def cross(a: Triple, b: Triple) -> Triple:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy", forceinline=True)
def dot(a: Triple, b: Triple) -> Lanes:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
