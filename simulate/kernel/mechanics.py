"""The mechanics of the six-leg platform, compiled: from states to their rates of change, for runs side by side.

The legs are massless but for what effects add along them, so nothing has to be closed (r the arm of a platform joint):

    (M + sum m_h J'J) a = sum J' (F - m_h c) + wrench - bias,   l' = J v,   l'' = J a + c,   J = [e, r x e]

Rows of `w` are those of `layout`, a row the number of every run of the block; `flat` is the same memory number by number, and n
how many runs stand side by side, for formulas that are called run by run. `runge_kutta` puts the pieces together.
"""

from __future__ import annotations

import math

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaPointers
from simulate.dispatch.lanes import Lanes, Rows, any_of, chosen, inverse_root
from simulate.kernel import contributions
from simulate.kernel.layout import (
    ADDED,
    ARM,
    AXIAL_MASS,
    AXIS,
    BIAS,
    EASED,
    ELONGATION,
    FULL,
    INERTIA,
    JOINT,
    LEG,
    LEG_BEFORE,
    LEG_SIZE,
    LEG_VALUE,
    LENGTH,
    LEVER,
    LINE,
    LOWEST,
    MASS,
    OUT,
    OUT_FORCE,
    OUT_R,
    OUT_STOP,
    OUT_STRIP,
    OUT_V,
    PER_LENGTH,
    RATE,
    RIGHT,
    ROTATION,
    STATES,
    STOP,
    STOP_FORCE,
    STORED,
    STOWED,
    STRIP,
    STRIP_NOW,
    SYSTEM,
    TRIAL,
    TURNED,
    WEIGHT,
    H,
    R,
    U,
    V,
)
from simulate.law import advance, remaining

_EASED = 6.0  # smoothing lengths from which a stop has set in to the last digit


@njit(cache=True, error_model="numpy", forceinline=True)
def assemble_platform(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Mass matrix and right side of the platform: mass, turned inertia, effects on both, weight, gyroscopic moment."""
    for k in range(21):
        w[SYSTEM + k] = 0.0
    p, q, s = by_lane[INERTIA], by_lane[INERTIA + 1], by_lane[INERTIA + 2]
    a, b, c = w[ROTATION], w[ROTATION + 1], w[ROTATION + 2]
    d, e, f = w[ROTATION + 3], w[ROTATION + 4], w[ROTATION + 5]
    g, h, k = w[ROTATION + 6], w[ROTATION + 7], w[ROTATION + 8]
    w[SYSTEM] = by_lane[MASS]
    w[SYSTEM + 2] = by_lane[MASS + 1]
    w[SYSTEM + 5] = by_lane[MASS + 2]
    w[SYSTEM + 9] = p * a * a + q * b * b + s * c * c
    w[SYSTEM + 13] = p * a * d + q * b * e + s * c * f
    w[SYSTEM + 14] = p * d * d + q * e * e + s * f * f
    w[SYSTEM + 18] = p * a * g + q * b * h + s * c * k
    w[SYSTEM + 19] = p * d * g + q * e * h + s * f * k
    w[SYSTEM + 20] = p * g * g + q * h * h + s * k * k
    contributions.change_platform_mass(w, flat, by_lane, by_run, formulas, n, with_work)
    x, y, z = w[TRIAL + 10], w[TRIAL + 11], w[TRIAL + 12]
    xx, xy, yy = w[SYSTEM + 9], w[SYSTEM + 13], w[SYSTEM + 14]
    xz, yz, zz = w[SYSTEM + 18], w[SYSTEM + 19], w[SYSTEM + 20]
    a, b, c = xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z
    w[RIGHT] = by_lane[WEIGHT]
    w[RIGHT + 1] = by_lane[WEIGHT + 1]
    w[RIGHT + 2] = by_lane[WEIGHT + 2]
    w[RIGHT + 3] = z * b - y * c
    w[RIGHT + 4] = x * c - z * a
    w[RIGHT + 5] = y * a - x * b
    w[RATE + STATES] = 0.0
    w[RATE + STATES + 1] = 0.0
    lift = by_lane[WEIGHT] * w[TRIAL + 7] + by_lane[WEIGHT + 1] * w[TRIAL + 8]
    w[RATE + STATES + 2] = lift + by_lane[WEIGHT + 2] * w[TRIAL + 9]


@njit(cache=True, error_model="numpy", forceinline=True)
def load_leg(w: Rows, by_lane: Rows, leg: int) -> None:
    """Bring a leg to the rows of the leg at hand, so that one copy of the code serves all legs with constant rows."""
    for k in range(LINE + 5):
        w[LEG_VALUE + k] = by_lane[LEG + leg * LEG_SIZE + k]
    w[LEG_BEFORE] = w[ELONGATION + leg]
    w[LEG_BEFORE + 1] = w[STORED + leg]
    w[LEG_BEFORE + 2] = w[TURNED + leg]
    w[LEG_BEFORE + 3] = w[STRIP + leg]


@njit(cache=True, error_model="numpy", forceinline=True)
def leg_kinematics(w: Rows) -> None:
    """Arm, direction, length, elongation and speed of the leg at hand, and c of l'' = J a + c."""
    j = LEG_VALUE + JOINT
    b0, b1, b2 = w[j], w[j + 1], w[j + 2]
    rx = w[ROTATION] * b0 + w[ROTATION + 1] * b1 + w[ROTATION + 2] * b2
    ry = w[ROTATION + 3] * b0 + w[ROTATION + 4] * b1 + w[ROTATION + 5] * b2
    rz = w[ROTATION + 6] * b0 + w[ROTATION + 7] * b1 + w[ROTATION + 8] * b2
    ex = w[TRIAL] + rx - w[LEG_VALUE]
    ey = w[TRIAL + 1] + ry - w[LEG_VALUE + 1]
    ez = w[TRIAL + 2] + rz - w[LEG_VALUE + 2]
    squared = ex * ex + ey * ey + ez * ez
    length, per = math.sqrt(squared), inverse_root(squared)
    ex, ey, ez = ex * per, ey * per, ez * per
    ox, oy, oz = w[TRIAL + 10], w[TRIAL + 11], w[TRIAL + 12]
    sx, sy, sz = oy * rz - oz * ry, oz * rx - ox * rz, ox * ry - oy * rx
    px, py, pz = w[TRIAL + 7] + sx, w[TRIAL + 8] + sy, w[TRIAL + 9] + sz
    v = px * ex + py * ey + pz * ez
    # centripetal part of the joint along the leg, and the turning of the leg itself
    inward = ex * (oy * sz - oz * sy) + ey * (oz * sx - ox * sz) + ez * (ox * sy - oy * sx)
    w[BIAS] = inward + (px * px + py * py + pz * pz - v * v) * per
    w[LENGTH], w[PER_LENGTH] = length, per
    w[U] = length - w[LEG_VALUE + STOWED]
    w[V] = v
    w[ARM], w[ARM + 1], w[ARM + 2] = rx, ry, rz
    w[AXIS], w[AXIS + 1], w[AXIS + 2] = ex, ey, ez
    w[LEVER], w[LEVER + 1], w[LEVER + 2] = ry * ez - rz * ey, rz * ex - rx * ez, rx * ey - ry * ex


@njit(cache=True, error_model="numpy", forceinline=True)
def leg_forces(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Hysteretic force, stops and effects of the leg at hand."""
    line = LEG_VALUE + LINE
    w[STRIP_NOW] = w[U]
    contributions.uncoil_strip(flat, by_lane, by_run, formulas, n, with_work)
    a_l, b_l, a_u, b_u = w[line], w[line + 1], w[line + 2], w[line + 3]
    u0, u = w[LEG_BEFORE + 3], w[STRIP_NOW]
    w[H], w[H + 1] = a_l * u0 + b_l, a_u * u0 + b_u
    w[H + 2], w[H + 3] = a_l * u + b_l, a_u * u + b_u
    w[ADDED] = w[AXIAL_MASS] = 0.0
    contributions.move_asymptotes(flat, by_lane, by_run, formulas, n, with_work)
    travel = u - u0
    h0, h1 = chosen(travel > 0.0, w[H], w[H + 1]), chosen(travel > 0.0, w[H + 2], w[H + 3])
    w[R] = advance(w[LEG_BEFORE + 1], travel, h0, h1, w[line + 4])
    stop_forces(w, flat, by_lane, n, with_work)
    contributions.add_leg_forces(w, flat, by_lane, by_run, formulas, n, with_work)


@njit(cache=True, error_model="numpy", forceinline=True)
def stop_forces(w: Rows, flat: Array, by_lane: Rows, n: int, with_work: bool) -> None:
    """Force of the stops at both ends of the stroke, (k p + c |p|') erf(p / s) against a penetration p above zero.

    One stands at full length, the other where the strip is coiled up: at the stowed length, or at the length at the release where
    that is shorter, for what holds the leg there holds its stop too.
    """
    over, under = w[U] - w[LEG_VALUE + FULL], w[LEG_VALUE + LOWEST] - w[U]
    p, side = chosen(over > 0.0, over, under), chosen(over > 0.0, -1.0, 1.0)
    w[STOP_FORCE] = 0.0
    if any_of(p > 0.0):
        ease_in(w, flat, p, p / by_lane[STOP + 2], n, with_work)
        speed = -side * w[V]
        force = side * (by_lane[STOP] * p + by_lane[STOP + 1] * speed) * w[EASED]
        w[STOP_FORCE] = chosen(p > 0.0, force, 0.0)


@njit(cache=True, error_model="numpy", forceinline=True)
def ease_in(w: Rows, flat: Array, p: Lanes, x: Lanes, n: int, with_work: bool) -> None:
    """erf(x) into the row EASED, computed only where a leg has just reached its stop; with account of work by the library, run by run."""
    w[EASED] = 1.0
    easing = (p > 0.0) & (x < _EASED)
    if any_of(easing):
        if with_work:
            w[EASED] = x
            for i in range(n):
                x_i = flat[EASED * n + i]
                flat[EASED * n + i] = math.erf(x_i) if 0.0 < x_i < _EASED else 1.0
        else:
            w[EASED] = chosen(easing, error_function(chosen(easing, x, 0.0)), 1.0)


@njit(cache=True, error_model="numpy", forceinline=True)
def error_function(x: Lanes) -> Lanes:
    """erf(x) for 0 <= x <= 6 to 1e-15: 1 - exp(-x^2) P(t) / (1 + 2 x), t = 9 / (x + 3) - 2.

    P is the Chebyshev series of (1 + 2 x) exp(x^2) erfc(x) up to degree 18, written in powers of t; what is left off is below 1e-16.
    """
    wide, high = x + 3.0, 1.0 + 2.0 * x
    per = 1.0 / (wide * high)
    t = 9.0 * per * high - 2.0
    t2 = t * t
    t4 = t2 * t2
    t8 = t4 * t4
    a = (1.28634166581727 + t * 0.025471885548613283) + t2 * (-0.12735942774306006 - t * 0.11341004764045223)
    b = (-0.054129044084213485 - t * 0.015381524492546931) + t2 * (-0.0019191155915813495 + t * 2.755877062984942e-4)
    c = (1.1950144253883473e-4 - t * 3.7357448137977576e-6) + t2 * (-6.216402262604243e-6 + t * 1.6837257468510623e-7)
    d = (3.4540280463554684e-7 - t * 2.761978908117735e-8) + t2 * (-1.895283376484912e-8 + t * 3.4131903750887e-9)
    e = (8.316153202388638e-10 - t * 2.465741772990729e-10) - t2 * 1.677823983457615e-11
    left = (a + t4 * b) + t8 * ((c + t4 * d) + t8 * e)
    return 1.0 - remaining(x * x) * left * (per * wide)


@njit(cache=True, error_model="numpy", forceinline=True)
def push_platform(w: Rows, with_work: bool) -> None:
    """Force and axial inertia of the leg at hand into the right side, its power into the energy balance."""
    push = w[R] + w[STOP_FORCE] + w[ADDED] - w[AXIAL_MASS] * w[BIAS]
    for k in range(3):
        w[RIGHT + k] += w[AXIS + k] * push
        w[RIGHT + 3 + k] += w[LEVER + k] * push
    if with_work:
        w[RATE + STATES] += w[R] * w[V]
        w[RATE + STATES + 1] += w[STOP_FORCE] * w[V]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_axial_mass(w: Rows) -> None:
    """m J'J of the leg at hand into the mass matrix."""
    m = w[AXIAL_MASS]
    jacobian = (w[AXIS], w[AXIS + 1], w[AXIS + 2], w[LEVER], w[LEVER + 1], w[LEVER + 2])
    for row in range(6):
        heavy = m * jacobian[row]
        for column in range(row + 1):
            w[SYSTEM + row * (row + 1) // 2 + column] += heavy * jacobian[column]


@njit(cache=True, error_model="numpy", forceinline=True)
def store_leg(w: Rows, leg: int) -> None:
    """What the leg at hand does, to the rows of its number."""
    w[OUT + leg] = w[U]
    w[OUT_V + leg] = w[V]
    w[OUT_R + leg] = w[R]
    w[OUT_STOP + leg] = w[STOP_FORCE]
    w[OUT_STRIP + leg] = w[STRIP_NOW]
    w[OUT_FORCE + leg] = w[R] + w[STOP_FORCE] + w[ADDED]
