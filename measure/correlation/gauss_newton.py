"""The iterations behind the refinement of a mark, compiled."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from measure.common.kernel_cache import discard_stale
from measure.correlation.spline import sample, sample_shifted

discard_stale(Path(__file__).resolve().parents[1], "correlation")

SETTLED_PX = 2e-3
_STEPS = 20
_MOST_CHANGED = 0.05
"""Share of the variance beyond which a changed look is no longer that of the same mark, moved as its warp says."""


@njit(cache=True, nogil=True)
def compose(warp: NDArray[np.float64], dp: NDArray[np.float64]) -> NDArray[np.float64]:
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
def step_px(dp: NDArray[np.float64], half: int) -> float:
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
def dot(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    """Sum of products."""
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@njit(cache=True, nogil=True)
def centre(g: NDArray[np.float32]) -> None:
    """Take the mean away, in place."""
    total = 0.0
    for i in range(len(g)):
        total += g[i]
    g -= np.float32(total / len(g))


@njit(cache=True, nogil=True)
def keep(square: NDArray[np.float32], kept: NDArray[np.int64], g: NDArray[np.float32]) -> None:
    """The pixels of the square that belong to the mark, into g."""
    for i in range(len(kept)):
        g[i] = square[kept[i]]


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
    look: NDArray[np.float32],
    uneven: NDArray[np.float32],
    least: float,
    kept: NDArray[np.int64],
) -> tuple[NDArray[np.float64], float, float, float, float, float, bool]:
    """Iterate with all pixels alike. Returns warp, gain, residual variance, share explained, 0, share of the residual
    variance that the images `uneven` (u, n) take up beyond the light's, per image, settled.

    least : variance of whole grey levels. kept : (n,) pixels of the square that belong to the mark.
    """
    warp, k, m, n = guess.copy(), len(free), len(light), len(values)
    shift_only = k == 2 and warp[0] == 1.0 and warp[4] == 1.0 and warp[1] == 0.0 and warp[3] == 0.0
    square = np.empty((2 * half + 1) ** 2, np.float32)
    g = square if n == len(square) else np.empty(n, np.float32)
    slope, even = np.empty(k), values.copy()
    centre(even)
    strength = dot(even, even)
    for _ in range(_STEPS):
        if not _take(c, left, top, half, warp, shift_only, square):
            break
        if n < len(square):
            keep(square, kept, g)
        centre(g)
        gain = dot(even, g) / strength
        for i in range(k):
            slope[i] = dot(free[i], g)
        dp = inverse_hessian @ slope / gain
        step = step_px(dp, half)
        warp = compose(warp, dp)
        if not step < 4.0:
            break
        if step < SETTLED_PX:
            total = dot(g, g)
            left_over = total - gain * np.dot(slope, dp)
            for j in range(m):
                left_over -= dot(light[j], g) ** 2
            changed = 0.0
            for j in range(len(look)):
                changed += dot(look[j], g) ** 2
            left_over -= changed if changed < _MOST_CHANGED * total else 0.0
            variance = max(left_over, 1e-9) / (n - k - m - len(look))
            taken = 0.0
            for j in range(len(uneven)):
                taken += dot(uneven[j], g) ** 2 / (max(variance, least) * len(uneven))
            return warp, gain, variance, 1.0 - left_over / total, 0.0, taken, True
    return warp, np.nan, np.nan, np.nan, 0.0, 0.0, False
