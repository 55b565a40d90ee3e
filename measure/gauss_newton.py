"""The iterations behind the refinement of a mark, compiled."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .kernel_cache import discard_stale
from .spline import sample, sample_shifted

discard_stale(Path(__file__).parent)

_TUKEY = 4.685
_SETTLED_PX = 2e-3
_STEPS = 20
_SPREAD_STEPS = 2
"""Robust steps that may still change what counts as far off."""


@njit(cache=True, nogil=True)
def _compose(warp: NDArray[np.float64], dp: NDArray[np.float64]) -> NDArray[np.float64]:
    """W o W(dp)^-1, both as six numbers."""
    m00, m01, m10, m11 = 1.0, 0.0, 0.0, 1.0
    if len(dp) == 3:
        m00, m01, m10, m11 = np.cos(dp[2]), -np.sin(dp[2]), np.sin(dp[2]), np.cos(dp[2])
    elif len(dp) == 6:
        m00, m01, m10, m11 = 1.0 + dp[2], dp[3], dp[4], 1.0 + dp[5]
    det = m00 * m11 - m01 * m10
    i00, i01, i10, i11 = m11 / det, -m01 / det, -m10 / det, m00 / det
    tx, ty = -(i00 * dp[0] + i01 * dp[1]), -(i10 * dp[0] + i11 * dp[1])
    made = np.empty(6)
    for r in range(2):
        a, b = warp[3 * r], warp[3 * r + 1]
        made[3 * r], made[3 * r + 1] = a * i00 + b * i10, a * i01 + b * i11
        made[3 * r + 2] = a * tx + b * ty + warp[3 * r + 2]
    return made


@njit(cache=True, nogil=True)
def _step_px(dp: NDArray[np.float64], half: int) -> float:
    """How far a step moves the farthest pixel of the subset, px, roughly."""
    step = np.hypot(dp[0], dp[1])
    for k in range(2, len(dp)):
        step = max(step, abs(dp[k]) * half)
    return step


@njit(cache=True, nogil=True)
def _take(
    c: NDArray[np.float32], left: int, top: int, half: int, warp: NDArray[np.float64], shift_only: bool, g: NDArray[np.float32]
) -> bool:
    if shift_only:
        return sample_shifted(c, left, top, half, warp[2], warp[5], g)
    return sample(c, left, top, half, warp, g)


@njit(cache=True, fastmath=True, nogil=True)
def _dot(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@njit(cache=True, nogil=True)
def _level(g: NDArray[np.float32]) -> None:
    """Take the mean away, in place."""
    total = 0.0
    for i in range(len(g)):
        total += g[i]
    g -= np.float32(total / len(g))


@njit(cache=True, nogil=True)
def solve(
    c: NDArray[np.float32],
    left: int,
    top: int,
    half: int,
    guess: NDArray[np.float64],
    free: NDArray[np.float32],
    light: NDArray[np.float32],
    values: NDArray[np.float32],
    inverse_hessian: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float, float, float, float, float, bool]:
    """Iterate with all pixels alike. Returns warp, gain, residual variance, share explained, 0, 0, settled."""
    warp, k, m, n = guess.copy(), len(free), len(light), len(values)
    shift_only = k == 2 and warp[0] == 1.0 and warp[4] == 1.0 and warp[1] == 0.0 and warp[3] == 0.0
    g, slope, even = np.empty(n, np.float32), np.empty(k), values.copy()
    _level(even)
    strength = _dot(even, even)
    for _ in range(_STEPS):
        if not _take(c, left, top, half, warp, shift_only, g):
            break
        _level(g)
        gain = _dot(even, g) / strength
        for i in range(k):
            slope[i] = _dot(free[i], g)
        dp = inverse_hessian @ slope / gain
        step = _step_px(dp, half)
        warp = _compose(warp, dp)
        if not step < 4.0:
            break
        if step < _SETTLED_PX:
            total = _dot(g, g)
            left_over = total - gain * np.dot(slope, dp)
            for j in range(m):
                left_over -= _dot(light[j], g) ** 2
            return warp, gain, max(left_over, 1e-9) / (n - k - m), 1.0 - left_over / total, 0.0, 0.0, True
    return warp, np.nan, np.nan, np.nan, 0.0, 0.0, False


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
) -> tuple[NDArray[np.float64], float, float, float, float, float, bool]:
    """Iterate with Tukey weights. Returns warp, gain, residual variance, share explained, hidden share,
    trace of the inverse Hessian of the two shifts, settled."""
    warp, k, m, n = guess.copy(), len(descent), len(light), len(values)
    images = np.empty((k + m, n), np.float32)
    images[:k], images[k:] = descent, light
    g, r, w = np.empty(n, np.float32), np.empty(n, np.float32), np.empty(n, np.float32)
    even = values.copy()
    _level(even)
    strength = _dot(even, even)
    shares, spread = np.empty(m), scale
    for step_number in range(3 * _STEPS):
        if not sample(c, left, top, half, warp, g):
            break
        if step_number == 0:
            _first_light(g, values, light, shares)
        _residual(g, light, shares, r)
        if step_number < _SPREAD_STEPS:
            spread = max(scale, 1.4826 * np.median(np.abs(r)))
        hidden = _tukey(r, spread, 2 * half + 1, w)
        if w.sum() < 4 * (k + m):
            break
        normal, right = _weighted(images, w, r)
        solution = np.linalg.solve(normal, right)
        shares += solution[k:]
        gain = 0.0
        for j in range(m):
            gain += shares[j] * _dot(light[j], even) / strength
        dp = (solution[:k] / gain).astype(np.float64)
        step = _step_px(dp, half)
        warp = _compose(warp, dp)
        if not (step < 4.0 and gain > 0.0):
            break
        if step < _SETTLED_PX and step_number >= _SPREAD_STEPS:
            square, share = _explained(g, r, w)
            inverse = np.linalg.inv(normal)
            return warp, gain, square, share, hidden, inverse[0, 0] + inverse[1, 1], True
    return warp, np.nan, np.nan, np.nan, 1.0, 1.0, False


@njit(cache=True, fastmath=True, nogil=True)
def _residual(g: NDArray[np.float32], light: NDArray[np.float32], shares: NDArray[np.float64], r: NDArray[np.float32]) -> None:
    r[:] = g
    for j in range(len(light)):
        share = np.float32(shares[j])
        for i in range(len(g)):
            r[i] -= share * light[j, i]


@njit(cache=True, nogil=True)
def _tukey(r: NDArray[np.float32], spread: float, size: int, w: NDArray[np.float32]) -> float:
    """Weights (1 - (r / c spread)^2)^2, none beyond c spreads and none beside such a pixel, which an edge in front half covers.

    Returns the share of pixels beyond.
    """
    hidden = 0
    narrow = np.float32(1.0 / (_TUKEY * spread))
    for i in range(len(r)):
        ratio = r[i] * narrow
        kept = np.float32(1.0) - ratio * ratio
        w[i] = kept * kept if kept > 0.0 else np.float32(-1.0)
    for i in range(len(r)):
        if w[i] == -1.0:
            hidden += 1
            row, column = i // size, i % size
            for y in range(max(row - 1, 0), min(row + 2, size)):
                for x in range(max(column - 1, 0), min(column + 2, size)):
                    if w[y * size + x] > 0.0:
                        w[y * size + x] = 0.0
    for i in range(len(r)):
        w[i] = max(w[i], np.float32(0.0))
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
        right[p] = _dot(part, r)
        for q in range(p + 1):
            normal[p, q] = _dot(part, images[q])
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
