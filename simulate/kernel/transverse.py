"""What a leg does across its own direction: inertia of its strip, friction of its joints. Absent unless an effect asks for it."""

from __future__ import annotations

import math

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaPointers
from simulate.dispatch.lanes import Lanes, Rows
from simulate.kernel import contributions
from simulate.kernel.layout import ARM, AXIAL_MASS, AXIS, EACH, JOINT_RATE, LENGTH, RIGHT, SLOPE, SYSTEM, TRIAL, G, V

Triple = tuple[Lanes, Lanes, Lanes]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_transverse(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Inertia across the leg at hand, into the system; of its mass matrix the part along the leg goes off the inertia along it.

    M_t = g (1 - n n'),   bias = g (1 - n n') c + g' l' v_t - n |v_t|^2 (g / l + g' / 2),   c = w x (w x r)

    added as G' M_t G = g G' G - g J' J, G = [1, -[r]x].
    """
    contributions.transverse_inertia(w, flat, by_lane, by_run, formulas, n, with_work)
    g, slope, length = w[G], w[SLOPE], w[LENGTH]
    r, e, spin, moving = triple(w, ARM), triple(w, AXIS), triple(w, TRIAL + 10), across(w)
    centripetal = cross(spin, cross(spin, r))
    along = dot(e, centripetal) * g + dot(moving, moving) * (g / length + 0.5 * slope)
    changing = slope * w[V]
    push_across(
        w,
        (
            along * e[0] - g * centripetal[0] - changing * moving[0],
            along * e[1] - g * centripetal[1] - changing * moving[1],
            along * e[2] - g * centripetal[2] - changing * moving[2],
        ),
    )
    w[AXIAL_MASS] -= g
    add_point_mass(w, g, r)


@njit(cache=True, error_model="numpy", forceinline=True)
def add_joint_friction(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Friction of the two joints of the leg at hand: moment on the platform, and force at the platform joint.

    The leg turns with w_l = n x v_t / l, and its joints resist w_l and w - w_l.
    """
    e, spin, per = triple(w, AXIS), triple(w, TRIAL + 10), 1.0 / w[LENGTH]
    swing = cross(e, across(w))
    turning = (swing[0] * per, swing[1] * per, swing[2] * per)
    against = (spin[0] - turning[0], spin[1] - turning[1], spin[2] - turning[2])
    w[JOINT_RATE] = math.sqrt(dot(turning, turning))
    contributions.resist_in_joint(w, flat, by_lane, by_run, formulas, n, with_work)
    base = w[EACH]
    w[JOINT_RATE] = math.sqrt(dot(against, against))
    contributions.resist_in_joint(w, flat, by_lane, by_run, formulas, n, with_work)
    joint = w[EACH]
    moment = (-joint * against[0], -joint * against[1], -joint * against[2])
    on_leg = (-base * turning[0] - moment[0], -base * turning[1] - moment[1], -base * turning[2] - moment[2])
    lever = cross(on_leg, e)
    push_across(w, (lever[0] * per, lever[1] * per, lever[2] * per))
    for k in range(3):
        w[RIGHT + 3 + k] += moment[k]


@njit(cache=True, error_model="numpy", forceinline=True)
def across(w: Rows) -> Triple:
    """Velocity of the platform joint of the leg at hand across the leg."""
    swing, flight, v, e = cross(triple(w, TRIAL + 10), triple(w, ARM)), triple(w, TRIAL + 7), w[V], triple(w, AXIS)
    return flight[0] + swing[0] - v * e[0], flight[1] + swing[1] - v * e[1], flight[2] + swing[2] - v * e[2]


@njit(cache=True, error_model="numpy", forceinline=True)
def push_across(w: Rows, force: Triple) -> None:
    """A force at the platform joint of the leg at hand, into the right side."""
    turned = cross(triple(w, ARM), force)
    for k in range(3):
        w[RIGHT + k] += force[k]
        w[RIGHT + 3 + k] += turned[k]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_point_mass(w: Rows, g: Lanes, r: Triple) -> None:
    """Adds g G' G to the lower half of the mass matrix: a mass at the end of the arm r."""
    x, y, z = g * r[0], g * r[1], g * r[2]
    w[SYSTEM] += g
    w[SYSTEM + 2] += g
    w[SYSTEM + 5] += g
    w[SYSTEM + 7] -= z
    w[SYSTEM + 8] += y
    w[SYSTEM + 9] += y * r[1] + z * r[2]
    w[SYSTEM + 10] += z
    w[SYSTEM + 12] -= x
    w[SYSTEM + 13] -= x * r[1]
    w[SYSTEM + 14] += x * r[0] + z * r[2]
    w[SYSTEM + 15] -= y
    w[SYSTEM + 16] += x
    w[SYSTEM + 18] -= x * r[2]
    w[SYSTEM + 19] -= y * r[2]
    w[SYSTEM + 20] += x * r[0] + y * r[1]


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
