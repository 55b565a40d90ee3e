"""The restoring force of one leg: between two reversals it is known exactly.

Uncoiling (u' > 0) the force approaches the lower asymptote h_l = a_l u + b_l, coiling (u' < 0) the upper one
h_u = a_u u + b_u, both at the rate beta per metre of elongation:

    dR/du = beta (h_l - R)     uncoiling
    dR/du = beta (R - h_u)     coiling

This is eq. (1)-(2) of Aridon et al. 2009 with plain brackets and a time derivative on the left,
R' = beta u' (h - R sgn u'), h = ((h_u + h_l) sgn u' - (h_u - h_l)) / 2. As printed, with absolute-value bars, R runs
away from both asymptotes; the bracket form also recovers when a moving asymptote leaves R outside the band.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import (
    Program,
    call_leg_asymptotes,
    call_leg_force,
    call_leg_mass,
    flat_parameters,
    program,
)
from simulate.dispatch.intrinsics import bits_of, number_of, pointer
from simulate.model.effect import Effect

A_L, B_L, A_U, B_U, BETA, LINE_VALUES = 0, 1, 2, 3, 4, 5
NEVER = -1e9  # elongation at the last reversal where there was none


@njit(cache=True, error_model="numpy", forceinline=True)
def advance(start_force: float, travel: float, start_asymptote: float, end_asymptote: float, beta: float) -> float:
    """Force after a travel `u - u_0` without reversal, from `start_force`, along the active asymptote. Exact.

        R(u) = h(u) - s a/beta + (R_0 - h(u_0) + s a/beta) exp(-beta |u - u_0|),   s a |u - u_0| = h(u) - h(u_0)

    A curved or moving asymptote is replaced by its chord over the travel. Written so that no travel gives R_0 to the digit,
    and without a branch, so that runs side by side go through it in vector registers.
    """
    x = beta * abs(travel) + 1e-300
    faded = fading(x)
    return start_force + (start_force - start_asymptote) * faded + (end_asymptote - start_asymptote) * (1.0 + faded / x)


@njit(cache=True, error_model="numpy", forceinline=True)
def fading(x: float) -> float:
    """exp(-x) - 1 for x >= 0 to the last digits: 2^k (exp(r) - 1) + (2^k - 1) with -x = k ln 2 + r, |r| <= ln 2 / 2.

    The library's function is a call a number; this one is arithmetic without a branch. Adding 1.5 * 2^52 leaves k, rounded, in
    the lowest bits of the sum, from where it goes into the exponent. exp(r) - 1 is its Taylor polynomial of degree 13, summed
    in pairs so that no long chain of operations has to wait for itself.
    """
    y = -x if x < 700.0 else -700.0
    rounded = y * 1.4426950408889634 + 6755399441055744.0
    k = rounded - 6755399441055744.0
    power = number_of((bits_of(rounded) << 52) + 4607182418800017408)
    r = (y - k * 0.6931471803691238) - k * 1.9082149292705877e-10
    r2 = r * r
    r4 = r2 * r2
    low = (1.0 / 2.0 + r * (1.0 / 6.0)) + r2 * (1.0 / 24.0 + r * (1.0 / 120.0))
    middle = (1.0 / 720.0 + r * (1.0 / 5040.0)) + r2 * (1.0 / 40320.0 + r * (1.0 / 362880.0))
    high = (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) + r2 * (1.0 / 479001600.0 + r * (1.0 / 6227020800.0))
    grown = r + r2 * (low + r4 * (middle + r4 * high))
    return power * grown + (power - 1.0)


def restoring_force(
    elongation_m: Any, start_elongation_m: float, start_force_N: float, slope: float, intercept: float, beta: float
) -> Array:
    """Force along a monotone branch that starts at (u_0, R_0); the active line is h(u) = slope u + intercept.

    Parameters
    ----------
    elongation_m : u, any shape, all on one side of `start_elongation_m`.
    slope, intercept : N/m and N, of the lower line while uncoiling, of the upper one while coiling.
    beta : 1/m, above zero.

    Returns
    -------
    R in N, of the shape of `elongation_m`. Source: the exact solution of eq. (1) for straight asymptotes.
    """
    u = np.asarray(elongation_m, dtype=float)
    s = np.sign(u - start_elongation_m)
    shift = s * slope / beta
    line, start_line = slope * u + intercept, slope * start_elongation_m + intercept
    return line - shift + (start_force_N - start_line + shift) * np.exp(-beta * np.abs(u - start_elongation_m))


def force_rate(velocity: Any, force: Any, lower: Any, upper: Any, beta: Any) -> Array:
    """R' of eq. (1) with plain brackets, N/s; the differential form, for integrators that want it.

    R' = beta u' (h - R sgn u'),   h = ((h_u + h_l) sgn u' - (h_u - h_l)) / 2
    """
    s = np.sign(velocity)
    h = ((upper + lower) * s - (upper - lower)) / 2
    return beta * velocity * (h - force * s)


def steady_loop_area(height_N: float, stroke_m: float, beta_per_m: float) -> float:
    """Area of the steady loop between flat asymptotes `height_N` apart, J: D S (1 - (2 / (S beta)) tanh(S beta / 2))."""
    x = stroke_m * beta_per_m / 2
    return height_N * stroke_m * (1 - math.tanh(x) / x)


@lru_cache(maxsize=64)
def _parameters(effects: tuple[Effect, ...]) -> Array:
    return flat_parameters(effects)


def loop_force(
    lines: Array,
    time_s: Array,
    elongation_m: Array,
    speed_m_per_s: Array,
    acceleration_m_per_s2: Array,
    start_force_N: float,
    effects: tuple[Effect, ...] = (),
) -> Array:
    """Force of an actuator along a given elongation: the law, sample to sample exact, and every effect on the leg.

        F = R + sum F_effect - (sum m_effect) u''

    Parameters
    ----------
    lines : (5,) a_l, b_l, a_u, b_u, beta.
    time_s, elongation_m, speed_m_per_s, acceleration_m_per_s2 : (n,) each.
    start_force_N : the hysteretic force R at the first sample.

    Returns
    -------
    (n,) force in N, before any effect of the load cell (`Effect.observe_force`).
    """
    values = np.concatenate([np.asarray(lines, dtype=float), _parameters(effects)])
    called = program(effects, LINE_VALUES)
    return loop_kernel(values, called, time_s, elongation_m, speed_m_per_s, acceleration_m_per_s2, float(start_force_N))


@njit(cache=True)
def loop_kernel(values: Array, called: Program, time: Array, u: Array, v: Array, acceleration: Array, start_force: float) -> Array:
    """`loop_force` on bare arrays: `values` holds the five line values and then the parameters of the effects."""
    n = len(u)
    force = np.empty(n)
    before, after = np.empty(2), np.empty(2)
    R, turned_at, direction = start_force, NEVER, 0.0
    asymptotes(values, 0, called, u[0], v[0], time[0], before, 0)
    for i in range(n):
        if i > 0:
            step = u[i] - u[i - 1]
            if step * direction < 0.0:
                turned_at = u[i - 1]
            if step != 0.0:
                direction = step
            asymptotes(values, 0, called, u[i], v[i], time[i], after, 0)
            side = 0 if step > 0.0 else 1
            R = advance(R, step, before[side], after[side], values[BETA])
            before[0], before[1] = after[0], after[1]
        force[i] = R + direct_force(values, called, u[i], v[i], time[i], R, u[i] - turned_at)
        force[i] -= axial_mass(values, called, u[i]) * acceleration[i]
    return force


@njit(cache=True, forceinline=True)
def asymptotes(values: Array, line: int, called: Program, u: float, v: float, t: float, h: Array, at: int) -> None:
    """Lower and upper asymptote at an elongation, into h[at] and h[at + 1]; the five line values start at `line`."""
    h[at] = values[line + A_L] * u + values[line + B_L]
    h[at + 1] = values[line + A_U] * u + values[line + B_U]
    for row in range(called.leg_asymptotes.shape[0]):
        p = pointer(values, called.leg_asymptotes[row, 1])
        call_leg_asymptotes(called.leg_asymptotes[row, 0], (u, v, t, p, pointer(h, at)))


@njit(cache=True, forceinline=True)
def direct_force(values: Array, called: Program, u: float, v: float, t: float, R: float, travel: float) -> float:
    """Sum of the forces that effects add to a leg, N."""
    total = 0.0
    for row in range(called.leg_force.shape[0]):
        total += call_leg_force(called.leg_force[row, 0], (u, v, t, R, travel, pointer(values, called.leg_force[row, 1])))
    return total


@njit(cache=True, forceinline=True)
def axial_mass(values: Array, called: Program, u: float) -> float:
    """Sum of the inertia that effects add along a leg, kg."""
    total = 0.0
    for row in range(called.leg_mass.shape[0]):
        total += call_leg_mass(called.leg_mass[row, 0], (u, pointer(values, called.leg_mass[row, 1])))
    return total
