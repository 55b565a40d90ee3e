"""The iterations of Gauss-Newton for a subset that something thin covers in part, compiled; covered pixels get no weight.

Tukey's biweight: Beaton and Tukey, Technometrics 16 (1974) 147.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from measure.correlation.criteria import SETTLED_PX, TUKEY
from measure.correlation.gauss_newton import (
    centre,
    compose,
    dot,
    keep,
    step_px,
)
from measure.correlation.spline import sample

_STEPS = 60
_SPREAD_STEPS = 2
"""Steps that may still change what counts as far off."""


@njit(cache=True, nogil=True)
def solve_robust(
    c: NDArray[np.float32],
    left: int,
    top: int,
    half: int,
    guess: NDArray[np.float64],
    descent: NDArray[np.float32],
    light: NDArray[np.float32],
    values: NDArray[np.float32],
    scale: float,
    kept: NDArray[np.int64],
    basis: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float, float, float, float, float, bool]:
    """Iterate with Tukey weights until a step moves no pixel by more than 0.002 px, 60 steps at most.

    Parameters
    ----------
    c, left, top, half, guess, values, kept
        As in `measure.correlation.gauss_newton.solve`.
    descent : (r, n) array
        Steepest-descent images along the determined directions.
    light : (m, n) array
        Orthonormal images of all that may change beside the warp.
    scale : float
        Least standard deviation of the noise, grey levels.
    basis : (k, r) array
        The determined directions, in parameters of the warp; the first two are the shifts.

    Returns
    -------
    warp : (6,) array
    gain, variance : float
        Of the light; of the residual under the weights.
    explained : float
        Share of the weighted variance that is explained.
    hidden : float
        Share of the pixels without weight.
    trace : float
        Of the inverse Hessian of the two shifts.
    settled : bool
    """
    warp, k, m, n = guess.copy(), len(descent), len(light), len(values)
    images = np.empty((k + m, n), np.float32)
    images[:k], images[k:] = descent, light
    r, w = np.empty(n, np.float32), np.empty(n, np.float32)
    square = np.empty((2 * half + 1) ** 2, np.float32)
    g = square if n == len(square) else np.empty(n, np.float32)
    even = values.copy()
    centre(even)
    strength = dot(even, even)
    shares, spread = np.empty(m), scale
    for step_number in range(_STEPS):
        if not sample(c, left, top, half, warp, square):
            break
        if n < len(square):
            keep(square, kept, g)
        if step_number == 0:
            _first_light(g, values, light, shares)
        _residual(g, light, shares, r)
        if step_number < _SPREAD_STEPS:
            spread = max(scale, 1.4826 * np.median(np.abs(r)))
        hidden = _tukey(r, spread, 2 * half + 1, kept, w)
        if w.sum() < 4 * (k + m):
            break
        normal, right = _weighted(images, w, r)
        solution = np.linalg.solve(normal, right)
        shares += solution[k:]
        gain = 0.0
        for j in range(m):
            gain += shares[j] * dot(light[j], even) / strength
        dp = basis @ (solution[:k] / gain)
        step = step_px(dp, half)
        warp = compose(warp, dp)
        if not (step < 4.0 and gain > 0.0):
            break
        if step < SETTLED_PX and step_number >= _SPREAD_STEPS:
            variance, explained = _explained(g, r, w)
            inverse = np.linalg.inv(normal)
            return warp, gain, variance, explained, hidden, inverse[0, 0] + inverse[1, 1], True
    return warp, np.nan, np.nan, np.nan, 1.0, 1.0, False


@njit(cache=True, fastmath=True, nogil=True)
def _residual(g: NDArray[np.float32], light: NDArray[np.float32], shares: NDArray[np.float64], r: NDArray[np.float32]) -> None:
    r[:] = g
    for j in range(len(light)):
        share = np.float32(shares[j])
        for i in range(len(g)):
            r[i] -= share * light[j, i]


@njit(cache=True, nogil=True)
def _tukey(r: NDArray[np.float32], spread: float, size: int, kept: NDArray[np.int64], w: NDArray[np.float32]) -> float:
    """Weights (1 - (r / c spread)^2)^2, none beyond c spreads and none beside such a pixel, which an edge in front half covers.

    kept : (n,) places of the pixels in the square of `size`. Returns the share of pixels beyond.
    """
    hidden, covered = 0, np.zeros(size * size, np.bool_)
    narrow = np.float32(1.0 / (TUKEY * spread))
    for i in range(len(r)):
        ratio = r[i] * narrow
        inside = np.float32(1.0) - ratio * ratio
        w[i] = max(inside, np.float32(0.0)) ** 2
        if inside <= 0.0:
            hidden += 1
            row, column = kept[i] // size, kept[i] % size
            for y in range(max(row - 1, 0), min(row + 2, size)):
                for x in range(max(column - 1, 0), min(column + 2, size)):
                    covered[y * size + x] = True
    for i in range(len(r)):
        if covered[kept[i]]:
            w[i] = 0.0
    return hidden / len(r)


@njit(cache=True, fastmath=True, nogil=True)
def _weighted(
    images: NDArray[np.float32], w: NDArray[np.float32], r: NDArray[np.float32]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normal equations of the slopes and the light together; a trace of the diagonal is added so that they can be solved."""
    size, n = images.shape
    normal, right, part = np.zeros((size, size)), np.zeros(size), np.empty(n, np.float32)
    for p in range(size):
        for i in range(n):
            part[i] = w[i] * images[p, i]
        right[p] = dot(part, r)
        for q in range(p + 1):
            normal[p, q] = dot(part, images[q])
            normal[q, p] = normal[p, q]
        normal[p, p] += 1e-9 * normal[p, p] + 1e-12
    return normal, right


@njit(cache=True, nogil=True)
def _explained(g: NDArray[np.float32], r: NDArray[np.float32], w: NDArray[np.float32]) -> tuple[float, float]:
    """Weighted mean square of the residual, and the share of the weighted variance that is explained."""
    total, first, second, square = 0.0, 0.0, 0.0, 0.0
    for i in range(len(g)):
        total += w[i]
        first += w[i] * g[i]
        second += w[i] * g[i] * g[i]
        square += w[i] * r[i] * r[i]
    return square / total, 1.0 - square / max(second - first * first / total, 1e-9)


@njit(cache=True, nogil=True)
def _first_light(g: NDArray[np.float32], values: NDArray[np.float32], light: NDArray[np.float32], shares: NDArray[np.float64]) -> None:
    """Shares of the light's images for the gain and offset that most pixels agree on."""
    level = values.mean()
    gain, offset = _robust_light(g, values, level)
    for j in range(len(light)):
        shares[j] = 0.0
        for i in range(len(values)):
            shares[j] += light[j, i] * (gain * (values[i] - level) + offset)


@njit(cache=True, nogil=True)
def _robust_light(g: NDArray[np.float32], values: NDArray[np.float32], level: float) -> tuple[float, float]:
    """Gain and offset that most pixels agree on: a few rounds of weighted straight-line fits."""
    gain, offset = 1.0, np.median(g)
    for _ in range(5):
        r = np.abs(g - offset - gain * (values - level))
        cut = 2.0 * 1.4826 * np.median(r) + 1e-6
        s, sf, sff, sg, sfg = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(len(g)):
            if r[i] <= cut:
                f = values[i] - level
                s += 1.0
                sf += f
                sff += f * f
                sg += g[i]
                sfg += f * g[i]
        det = s * sff - sf * sf
        if det <= 0.0:
            break
        gain, offset = (s * sfg - sf * sg) / det, (sff * sg - sf * sfg) / det
    return float(gain), float(offset)
