"""The iterations of inverse-compositional Gauss-Newton for one subset, compiled; all pixels count alike."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from measure.common.kernel_cache import discard_stale
from measure.correlation.criteria import MOST_BENT, SETTLED_PX
from measure.correlation.spline import sample, sample_shifted

discard_stale(Path(__file__).resolve().parents[1], "correlation")

_STEPS = 20


@njit(cache=True, nogil=True)
def compose(warp: NDArray[np.float64], dp: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compose a warp with the inverse of a small one, W o W(dp)^-1.

    Parameters
    ----------
    warp : (6,) array
        As in `measure.correlation.spline.sample`.
    dp : (2,), (3,) or (6,) array
        Shift; shift and angle; or shift and the four changes of an affine matrix.

    Returns
    -------
    (6,) array
    """
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
    """Upper bound of the motion that a step, (2,), (3,) or (6,), gives to the farthest pixel of the subset, px."""
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
    """Sum of products of two arrays (n,)."""
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@njit(cache=True, nogil=True)
def centre(g: NDArray[np.float32]) -> None:
    """Take the mean off an array (n,), in place."""
    total = 0.0
    for i in range(len(g)):
        total += g[i]
    g -= np.float32(total / len(g))


@njit(cache=True, nogil=True)
def keep(square: NDArray[np.float32], kept: NDArray[np.int64], g: NDArray[np.float32]) -> None:
    """Copy the pixels of the square that belong to the mark, kept (n,), into g (n,)."""
    for i in range(len(kept)):
        g[i] = square[kept[i]]


@njit(cache=True, nogil=True)
def solve(
    c: NDArray[np.float32],
    left: int,
    top: int,
    half: int,
    guess: NDArray[np.float64],
    projected: NDArray[np.float32],
    light: NDArray[np.float32],
    values: NDArray[np.float32],
    inverse_hessian: NDArray[np.float64],
    bending: NDArray[np.float32],
    uneven: NDArray[np.float32],
    least: float,
    kept: NDArray[np.int64],
) -> tuple[NDArray[np.float64], float, float, float, float, float, bool]:
    """Iterate until a step moves no pixel by more than 0.002 px, 20 steps at most.

    Parameters
    ----------
    c : (rows, columns) array
        Spline coefficients of the current image, the first at the pixel (left, top).
    left, top, half : int
        The subset is 2 half + 1 px wide.
    guess : (6,) array
        First guess of the warp.
    projected : (k, n) array
        Steepest-descent images, projected off light and bending.
    light, bending, uneven : (m, n), (b, n), (u, n) arrays
        Orthonormal images of the light, of a bent motion, and of light that changes across the mark.
    values : (n,) array
        Grey values of the reference image.
    inverse_hessian : (k, k) array
    least : float
        Variance of rounding to whole grey levels.
    kept : (n,) array of int
        Pixels of the square that belong to the mark.

    Returns
    -------
    warp : (6,) array
    gain, variance : float
        Of the light; of the residual.
    explained : float
        Share of the variance that is explained.
    hidden : float
        Zero; the robust iteration has a share here.
    taken : float
        Share of the residual variance that each of `uneven` explains.
    settled : bool
    """
    warp, k, n = guess.copy(), len(projected), len(values)
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
            slope[i] = dot(projected[i], g)
        dp = inverse_hessian @ slope / gain
        step = step_px(dp, half)
        warp = compose(warp, dp)
        if not step < 4.0:
            break
        if step < SETTLED_PX:
            variance, explained = _residual_variance(g, gain * np.dot(slope, dp), light, bending, k)
            taken = 0.0
            for j in range(len(uneven)):
                taken += dot(uneven[j], g) ** 2 / (max(variance, least) * len(uneven))
            return warp, gain, variance, explained, 0.0, taken, True
    return warp, np.nan, np.nan, np.nan, 0.0, 0.0, False


@njit(cache=True, nogil=True)
def _residual_variance(
    g: NDArray[np.float32], moved: float, light: NDArray[np.float32], bending: NDArray[np.float32], k: int
) -> tuple[float, float]:
    """Variance of what light, motion and bending leave of the centred image g, and the share of its square that they explain."""
    total = dot(g, g)
    remaining = total - moved
    for j in range(len(light)):
        remaining -= dot(light[j], g) ** 2
    bent = 0.0
    for j in range(len(bending)):
        bent += dot(bending[j], g) ** 2
    remaining -= bent if bent < MOST_BENT * total else 0.0
    return max(remaining, 1e-9) / (len(g) - k - len(light) - len(bending)), 1.0 - remaining / total
