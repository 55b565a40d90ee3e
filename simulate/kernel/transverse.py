"""What a leg does across its own direction: inertia of its strip, friction of its joints. Absent unless an effect asks for it."""

from __future__ import annotations

import math

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaPointers
from simulate.dispatch.lanes import Lanes, Rows
from simulate.kernel import contributions
from simulate.kernel.layout import ARM, AXIAL_MASS, AXIS, JOINT_RATE, PER_LENGTH, RESISTANCE, RIGHT, SLOPE, SYSTEM, TRIAL, G, V

Triple = tuple[Lanes, Lanes, Lanes]


@njit(cache=True, error_model="numpy", forceinline=True)
def act_across(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """What the leg at hand does across its direction, into the right side: the rest of its inertia, friction of its joints."""
    nothing = 0.0 * w[V]
    force = moment = (nothing, nothing, nothing)
    if formulas.joint_resistance[1] > 0:
        force, moment = joint_friction(w, flat, by_lane, by_run, formulas, n, with_work)
    if formulas.leg_transverse[1] > 0:
        contributions.transverse_inertia(w, flat, by_lane, by_run, formulas, n, with_work)
        bias = transverse_bias(w)
        force = force[0] - bias[0], force[1] - bias[1], force[2] - bias[2]
    turned = cross(triple(w, ARM), force)
    for k in range(3):
        w[RIGHT + k] += force[k]
        w[RIGHT + 3 + k] += turned[k] + moment[k]


@njit(cache=True, error_model="numpy", forceinline=True)
def transverse_bias(w: Rows) -> Triple:
    """What of the inertia across the leg at hand does not depend on the acceleration, N at the platform joint.

    M_t = g (1 - n n'),   bias = g (1 - n n') c + g' l' v_t - n |v_t|^2 (g / l + g' / 2),   c = w x (w x r)
    """
    g, slope, r, e, spin, moving = w[G], w[SLOPE], triple(w, ARM), triple(w, AXIS), triple(w, TRIAL + 10), across(w)
    centripetal = cross(spin, cross(spin, r))
    along = dot(e, centripetal) * g + dot(moving, moving) * (g * w[PER_LENGTH] + 0.5 * slope)
    changing = slope * w[V]
    return (
        g * centripetal[0] + changing * moving[0] - along * e[0],
        g * centripetal[1] + changing * moving[1] - along * e[1],
        g * centripetal[2] + changing * moving[2] - along * e[2],
    )


@njit(cache=True, error_model="numpy", forceinline=True)
def joint_friction(
    w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool
) -> tuple[Triple, Triple]:
    """Friction of the two joints of the leg at hand: force at the platform joint, and moment on the platform.

    The leg turns with w_l = n x v_t / l, and its joints resist w_l and w - w_l, with c_1 and c_2:

        force = (c_2 w x n - (c_1 + c_2) v_t / l) / l,      moment = -c_2 (w - w_l)
    """
    e, spin, per, moving = triple(w, AXIS), triple(w, TRIAL + 10), w[PER_LENGTH], across(w)
    swing = cross(e, moving)
    turning = (swing[0] * per, swing[1] * per, swing[2] * per)
    against = (spin[0] - turning[0], spin[1] - turning[1], spin[2] - turning[2])
    w[JOINT_RATE], w[JOINT_RATE + 1] = math.sqrt(dot(turning, turning)), math.sqrt(dot(against, against))
    contributions.resist_in_joints(w, flat, by_lane, by_run, formulas, n, with_work)
    base, joint = w[RESISTANCE], w[RESISTANCE + 1]
    held, lagging, sideways = joint * per, (base + joint) * per * per, cross(spin, e)
    return (
        (
            held * sideways[0] - lagging * moving[0],
            held * sideways[1] - lagging * moving[1],
            held * sideways[2] - lagging * moving[2],
        ),
        (-joint * against[0], -joint * against[1], -joint * against[2]),
    )


@njit(cache=True, error_model="numpy", forceinline=True)
def across(w: Rows) -> Triple:
    """Velocity of the platform joint of the leg at hand across the leg."""
    swing, flight, v, e = cross(triple(w, TRIAL + 10), triple(w, ARM)), triple(w, TRIAL + 7), w[V], triple(w, AXIS)
    return flight[0] + swing[0] - v * e[0], flight[1] + swing[1] - v * e[1], flight[2] + swing[2] - v * e[2]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_transverse_mass(w: Rows) -> None:
    """Inertia across the leg at hand into the lower half of the mass matrix, its part along the leg off the inertia along it.

    G' M_t G = g G' G - g J' J, G = [1, -[r]x]
    """
    g, r = w[G], triple(w, ARM)
    x, y, z = g * r[0], g * r[1], g * r[2]
    w[AXIAL_MASS] -= g
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
