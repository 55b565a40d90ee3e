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
from typing import Any

import numpy as np
from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.lanes import larger, power_of_two


@njit(cache=True, error_model="numpy", forceinline=True)
def advance(start_force: Any, travel: Any, start_asymptote: Any, end_asymptote: Any, beta: Any) -> Any:
    """Force after a travel `u - u_0` without reversal, from `start_force`, along the active asymptote. Exact.

        R(u) = h(u) - s a/beta + (R_0 - h(u_0) + s a/beta) exp(-beta |u - u_0|),   s a |u - u_0| = h(u) - h(u_0)

    A curved or moving asymptote is replaced by its chord over the travel. Written so that no travel gives R_0 to the digit,
    and without a branch: the arguments are plain numbers or those of runs side by side.
    """
    x = beta * abs(travel) + 1e-300
    faded = fading(x)
    return start_force + (start_force - start_asymptote) * faded + (end_asymptote - start_asymptote) * (1.0 + faded / x)


@njit(cache=True, error_model="numpy", forceinline=True)
def fading(x: Any) -> Any:
    """exp(-x) - 1 for x >= 0 to the last digits."""
    power, grown = parts_of_exponential(x)
    return power * grown + (power - 1.0)


@njit(cache=True, error_model="numpy", forceinline=True)
def remaining(x: Any) -> Any:
    """exp(-x) for x >= 0 to the last digits."""
    power, grown = parts_of_exponential(x)
    return power * grown + power


@njit(cache=True, error_model="numpy", forceinline=True)
def nearest_whole(x: Any) -> Any:
    """The nearest whole number, of two the even one, of a number that is small against 2^51."""
    return (x + 6755399441055744.0) - 6755399441055744.0


@njit(cache=True, error_model="numpy", forceinline=True)
def parts_of_exponential(x: Any) -> Any:
    """2^k and exp(r) - 1 of exp(-x), x >= 0: -x = k ln 2 + r, |r| <= ln 2 / 2.

    The library's function is a call a number; this one is arithmetic without a branch. Adding 1.5 * 2^52 leaves k, rounded, in
    the lowest bits of the sum, from where it goes into the exponent. exp(r) - 1 is its Taylor polynomial of degree 13, summed
    in pairs so that no long chain of operations has to wait for itself.
    """
    y = larger(-x, -700.0)
    rounded = y * 1.4426950408889634 + 6755399441055744.0
    k = rounded - 6755399441055744.0
    power = power_of_two(rounded)
    r = (y - k * 0.6931471803691238) - k * 1.9082149292705877e-10
    r2 = r * r
    r4 = r2 * r2
    low = (1.0 / 2.0 + r * (1.0 / 6.0)) + r2 * (1.0 / 24.0 + r * (1.0 / 120.0))
    middle = (1.0 / 720.0 + r * (1.0 / 5040.0)) + r2 * (1.0 / 40320.0 + r * (1.0 / 362880.0))
    high = (1.0 / 3628800.0 + r * (1.0 / 39916800.0)) + r2 * (1.0 / 479001600.0 + r * (1.0 / 6227020800.0))
    return power, r + r2 * (low + r4 * (middle + r4 * high))


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
