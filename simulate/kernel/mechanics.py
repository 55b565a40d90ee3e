"""The mechanics of the six-leg platform, compiled: from states to their rates of change, for runs side by side.

The legs are massless but for what effects add along them, so nothing has to be closed (r the arm of a platform joint):

    (M + sum m_h J'J) a = sum J' (F - m_h c) + wrench - bias,   l' = J v,   l'' = J a + c,   J = [e, r x e]

Rows of `w` are those of `layout`; n is how many runs stand side by side. `rk_stage` puts the pieces together.
"""

from __future__ import annotations

import math

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaPointers
from simulate.kernel import contributions
from simulate.kernel.layout import (
    ADDED,
    ARM,
    AXIAL_MASS,
    AXIS,
    BIAS,
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
from simulate.law import advance


@njit(cache=True, error_model="numpy", forceinline=True)
def assemble_platform(w: Array, by_lane: Array, by_run: Array, formulas: FormulaPointers, n: int) -> None:
    """Mass matrix and right side of the platform: mass, turned inertia, effects on both, weight, gyroscopic moment."""
    w[SYSTEM * n : (RIGHT + 6) * n] = 0.0
    for i in range(n):
        p, q, s = by_lane[INERTIA * n + i], by_lane[(INERTIA + 1) * n + i], by_lane[(INERTIA + 2) * n + i]
        a, b, c = w[ROTATION * n + i], w[(ROTATION + 1) * n + i], w[(ROTATION + 2) * n + i]
        d, e, f = w[(ROTATION + 3) * n + i], w[(ROTATION + 4) * n + i], w[(ROTATION + 5) * n + i]
        g, h, k = w[(ROTATION + 6) * n + i], w[(ROTATION + 7) * n + i], w[(ROTATION + 8) * n + i]
        w[SYSTEM * n + i] = by_lane[MASS * n + i]
        w[(SYSTEM + 2) * n + i] = by_lane[(MASS + 1) * n + i]
        w[(SYSTEM + 5) * n + i] = by_lane[(MASS + 2) * n + i]
        w[(SYSTEM + 9) * n + i] = p * a * a + q * b * b + s * c * c
        w[(SYSTEM + 13) * n + i] = p * a * d + q * b * e + s * c * f
        w[(SYSTEM + 14) * n + i] = p * d * d + q * e * e + s * f * f
        w[(SYSTEM + 18) * n + i] = p * a * g + q * b * h + s * c * k
        w[(SYSTEM + 19) * n + i] = p * d * g + q * e * h + s * f * k
        w[(SYSTEM + 20) * n + i] = p * g * g + q * h * h + s * k * k
    contributions.change_platform_mass(w, by_run, formulas, n)
    for i in range(n):
        x, y, z = w[(TRIAL + 10) * n + i], w[(TRIAL + 11) * n + i], w[(TRIAL + 12) * n + i]
        xx, xy, yy = w[(SYSTEM + 9) * n + i], w[(SYSTEM + 13) * n + i], w[(SYSTEM + 14) * n + i]
        xz, yz, zz = w[(SYSTEM + 18) * n + i], w[(SYSTEM + 19) * n + i], w[(SYSTEM + 20) * n + i]
        a, b, c = xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z
        w[RIGHT * n + i] = by_lane[WEIGHT * n + i]
        w[(RIGHT + 1) * n + i] = by_lane[(WEIGHT + 1) * n + i]
        w[(RIGHT + 2) * n + i] = by_lane[(WEIGHT + 2) * n + i]
        w[(RIGHT + 3) * n + i] = z * b - y * c
        w[(RIGHT + 4) * n + i] = x * c - z * a
        w[(RIGHT + 5) * n + i] = y * a - x * b
        w[(RATE + STATES) * n + i] = 0.0
        w[(RATE + STATES + 1) * n + i] = 0.0
        lift = by_lane[WEIGHT * n + i] * w[(TRIAL + 7) * n + i] + by_lane[(WEIGHT + 1) * n + i] * w[(TRIAL + 8) * n + i]
        w[(RATE + STATES + 2) * n + i] = lift + by_lane[(WEIGHT + 2) * n + i] * w[(TRIAL + 9) * n + i]


@njit(cache=True, error_model="numpy", forceinline=True)
def load_leg(w: Array, by_lane: Array, leg: int, n: int) -> None:
    """Bring a leg to the rows of the leg at hand, so that one copy of the code serves all legs with constant rows."""
    start = (LEG + leg * LEG_SIZE) * n
    for k in range((LINE + 5) * n):
        w[LEG_VALUE * n + k] = by_lane[start + k]
    for i in range(n):
        w[LEG_BEFORE * n + i] = w[(ELONGATION + leg) * n + i]
        w[(LEG_BEFORE + 1) * n + i] = w[(STORED + leg) * n + i]
        w[(LEG_BEFORE + 2) * n + i] = w[(TURNED + leg) * n + i]
        w[(LEG_BEFORE + 3) * n + i] = w[(STRIP + leg) * n + i]


@njit(cache=True, error_model="numpy", forceinline=True)
def leg_kinematics(w: Array, n: int) -> None:
    """Arm, direction, length, elongation and speed of the leg at hand, and c of l'' = J a + c."""
    j = LEG_VALUE + JOINT
    for i in range(n):
        b0, b1, b2 = w[j * n + i], w[(j + 1) * n + i], w[(j + 2) * n + i]
        rx = w[ROTATION * n + i] * b0 + w[(ROTATION + 1) * n + i] * b1 + w[(ROTATION + 2) * n + i] * b2
        ry = w[(ROTATION + 3) * n + i] * b0 + w[(ROTATION + 4) * n + i] * b1 + w[(ROTATION + 5) * n + i] * b2
        rz = w[(ROTATION + 6) * n + i] * b0 + w[(ROTATION + 7) * n + i] * b1 + w[(ROTATION + 8) * n + i] * b2
        ex = w[TRIAL * n + i] + rx - w[LEG_VALUE * n + i]
        ey = w[(TRIAL + 1) * n + i] + ry - w[(LEG_VALUE + 1) * n + i]
        ez = w[(TRIAL + 2) * n + i] + rz - w[(LEG_VALUE + 2) * n + i]
        length = math.sqrt(ex * ex + ey * ey + ez * ez)
        per = 1.0 / length
        ex, ey, ez = ex * per, ey * per, ez * per
        ox, oy, oz = w[(TRIAL + 10) * n + i], w[(TRIAL + 11) * n + i], w[(TRIAL + 12) * n + i]
        sx, sy, sz = oy * rz - oz * ry, oz * rx - ox * rz, ox * ry - oy * rx
        px, py, pz = w[(TRIAL + 7) * n + i] + sx, w[(TRIAL + 8) * n + i] + sy, w[(TRIAL + 9) * n + i] + sz
        v = px * ex + py * ey + pz * ez
        # centripetal part of the joint along the leg, and the turning of the leg itself
        inward = ex * (oy * sz - oz * sy) + ey * (oz * sx - ox * sz) + ez * (ox * sy - oy * sx)
        w[BIAS * n + i] = inward + (px * px + py * py + pz * pz - v * v) * per
        w[LENGTH * n + i] = length
        w[U * n + i] = length - w[(LEG_VALUE + STOWED) * n + i]
        w[V * n + i] = v
        w[ARM * n + i], w[(ARM + 1) * n + i], w[(ARM + 2) * n + i] = rx, ry, rz
        w[AXIS * n + i], w[(AXIS + 1) * n + i], w[(AXIS + 2) * n + i] = ex, ey, ez
        w[LEVER * n + i], w[(LEVER + 1) * n + i], w[(LEVER + 2) * n + i] = ry * ez - rz * ey, rz * ex - rx * ez, rx * ey - ry * ex


@njit(cache=True, error_model="numpy", forceinline=True)
def leg_forces(w: Array, by_lane: Array, by_run: Array, formulas: FormulaPointers, t0: float, t: float, n: int, with_work: bool) -> None:
    """Hysteretic force, stops and effects of the leg at hand."""
    line = LEG_VALUE + LINE
    contributions.uncoil_strip(w, by_run, formulas, n)
    for i in range(n):
        a_l, b_l, a_u, b_u = w[line * n + i], w[(line + 1) * n + i], w[(line + 2) * n + i], w[(line + 3) * n + i]
        u0, u = w[(LEG_BEFORE + 3) * n + i], w[STRIP_NOW * n + i]
        w[H * n + i], w[(H + 1) * n + i] = a_l * u0 + b_l, a_u * u0 + b_u
        w[(H + 2) * n + i], w[(H + 3) * n + i] = a_l * u + b_l, a_u * u + b_u
        w[STOP_FORCE * n + i] = w[ADDED * n + i] = w[AXIAL_MASS * n + i] = 0.0
    contributions.move_asymptotes(w, by_run, formulas, t0, t, n)
    for i in range(n):
        travel = w[STRIP_NOW * n + i] - w[(LEG_BEFORE + 3) * n + i]
        # chosen by arithmetic: a choice between two places would be read lane by lane
        out, back = (1.0, 0.0) if travel > 0.0 else (0.0, 1.0)
        h0 = out * w[H * n + i] + back * w[(H + 1) * n + i]
        h1 = out * w[(H + 2) * n + i] + back * w[(H + 3) * n + i]
        w[R * n + i] = advance(w[(LEG_BEFORE + 1) * n + i], travel, h0, h1, w[(line + 4) * n + i])
    near = 0
    for i in range(n):
        near |= 1 if (w[U * n + i] > w[(LEG_VALUE + FULL) * n + i]) | (w[U * n + i] < w[(LEG_VALUE + LOWEST) * n + i]) else 0
    if near:
        stop_forces(w, by_lane, n)
    contributions.add_leg_forces(w, by_run, formulas, t, n, with_work)


@njit(cache=True, error_model="numpy", forceinline=True)
def stop_forces(w: Array, by_lane: Array, n: int) -> None:
    """Force of the stops at both ends of the stroke, (k p + c |p|') erf(p / s) against a penetration p above zero.

    One stands at full length, the other where the strip is coiled up: at the stowed length, or at the length at the release where
    that is shorter, for what holds the leg there holds its stop too.
    """
    for i in range(n):
        over, under = w[U * n + i] - w[(LEG_VALUE + FULL) * n + i], w[(LEG_VALUE + LOWEST) * n + i] - w[U * n + i]
        p, side = (over, -1.0) if over > 0.0 else (under, 1.0)
        if p > 0.0:
            x = p / by_lane[(STOP + 2) * n + i]
            eased = math.erf(x) if x < 6.0 else 1.0
            speed = -side * w[V * n + i]
            w[STOP_FORCE * n + i] = side * (by_lane[STOP * n + i] * p + by_lane[(STOP + 1) * n + i] * speed) * eased


@njit(cache=True, error_model="numpy", forceinline=True)
def add_leg(w: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Force and axial inertia of the leg at hand into right side and mass matrix, its power into the energy balance."""
    for i in range(n):
        push = w[R * n + i] + w[STOP_FORCE * n + i] + w[ADDED * n + i] - w[AXIAL_MASS * n + i] * w[BIAS * n + i]
        w[RIGHT * n + i] += w[AXIS * n + i] * push
        w[(RIGHT + 1) * n + i] += w[(AXIS + 1) * n + i] * push
        w[(RIGHT + 2) * n + i] += w[(AXIS + 2) * n + i] * push
        w[(RIGHT + 3) * n + i] += w[LEVER * n + i] * push
        w[(RIGHT + 4) * n + i] += w[(LEVER + 1) * n + i] * push
        w[(RIGHT + 5) * n + i] += w[(LEVER + 2) * n + i] * push
    if with_work:
        for i in range(n):
            w[(RATE + STATES) * n + i] += w[R * n + i] * w[V * n + i]
            w[(RATE + STATES + 1) * n + i] += w[STOP_FORCE * n + i] * w[V * n + i]
    if formulas.leg_mass[1] > 0:
        for i in range(n):
            m = w[AXIAL_MASS * n + i]
            a, b, c = w[AXIS * n + i], w[(AXIS + 1) * n + i], w[(AXIS + 2) * n + i]
            d, e, f = w[LEVER * n + i], w[(LEVER + 1) * n + i], w[(LEVER + 2) * n + i]
            ma, mb, mc, md, me, mf = m * a, m * b, m * c, m * d, m * e, m * f
            w[SYSTEM * n + i] += ma * a
            w[(SYSTEM + 1) * n + i] += mb * a
            w[(SYSTEM + 2) * n + i] += mb * b
            w[(SYSTEM + 3) * n + i] += mc * a
            w[(SYSTEM + 4) * n + i] += mc * b
            w[(SYSTEM + 5) * n + i] += mc * c
            w[(SYSTEM + 6) * n + i] += md * a
            w[(SYSTEM + 7) * n + i] += md * b
            w[(SYSTEM + 8) * n + i] += md * c
            w[(SYSTEM + 9) * n + i] += md * d
            w[(SYSTEM + 10) * n + i] += me * a
            w[(SYSTEM + 11) * n + i] += me * b
            w[(SYSTEM + 12) * n + i] += me * c
            w[(SYSTEM + 13) * n + i] += me * d
            w[(SYSTEM + 14) * n + i] += me * e
            w[(SYSTEM + 15) * n + i] += mf * a
            w[(SYSTEM + 16) * n + i] += mf * b
            w[(SYSTEM + 17) * n + i] += mf * c
            w[(SYSTEM + 18) * n + i] += mf * d
            w[(SYSTEM + 19) * n + i] += mf * e
            w[(SYSTEM + 20) * n + i] += mf * f


@njit(cache=True, error_model="numpy", forceinline=True)
def store_leg(w: Array, leg: int, n: int) -> None:
    """What the leg at hand does, to the rows of its number."""
    for i in range(n):
        w[(OUT + leg) * n + i] = w[U * n + i]
        w[(OUT_V + leg) * n + i] = w[V * n + i]
        w[(OUT_R + leg) * n + i] = w[R * n + i]
        w[(OUT_STOP + leg) * n + i] = w[STOP_FORCE * n + i]
        w[(OUT_STRIP + leg) * n + i] = w[STRIP_NOW * n + i]
        w[(OUT_FORCE + leg) * n + i] = w[R * n + i] + w[STOP_FORCE * n + i] + w[ADDED * n + i]
