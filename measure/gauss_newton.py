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
def solve(
    c: NDArray[np.float32],
    left: int,
    top: int,
    half: int,
    guess: NDArray[np.float64],
    free: NDArray[np.float32],
    basis: NDArray[np.float32],
    values: NDArray[np.float32],
    inverse_hessian: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float, float, float, float, float, bool]:
    """Iterate with all pixels alike. Returns warp, gain, residual variance, share explained, 0, 0, settled."""
    warp, k, n = guess.copy(), len(free), len(values)
    shift_only = k == 2 and warp[0] == 1.0 and warp[4] == 1.0 and warp[1] == 0.0 and warp[3] == 0.0
    g, slope = np.empty(n, np.float32), np.empty(k)
    value_along = _dot(basis[1], values)
    for _ in range(_STEPS):
        if not _take(c, left, top, half, warp, shift_only, g):
            break
        level = 0.0
        for i in range(n):
            level += g[i]
        g -= np.float32(level / n)
        gain = _dot(basis[1], g) / value_along
        for i in range(k):
            slope[i] = _dot(free[i], g)
        dp = inverse_hessian @ slope / gain
        step = _step_px(dp, half)
        warp = _compose(warp, dp)
        if not step < 4.0:
            break
        if step < _SETTLED_PX:
            total = _dot(g, g)
            left_over = total - (gain * value_along) ** 2 - gain * np.dot(slope, dp)
            return warp, gain, max(left_over, 1e-9) / (n - k - 2), 1.0 - left_over / total, 0.0, 0.0, True
    return warp, np.nan, np.nan, np.nan, 0.0, 0.0, False


@njit(cache=True, nogil=True)
def solve_robust(
    c: NDArray[np.float32],
    left: int,
    top: int,
    half: int,
    guess: NDArray[np.float64],
    descent: NDArray[np.float32],
    values: NDArray[np.float32],
    scale: float,
) -> tuple[NDArray[np.float64], float, float, float, float, float, bool]:
    """Iterate with Tukey weights. Returns warp, gain, residual variance, share explained, hidden share,
    trace of the inverse Hessian of the two shifts, settled."""
    warp, k, n = guess.copy(), len(descent), len(values)
    g, w, r = np.empty(n, np.float32), np.ones(n), np.empty(n)
    m = k + 2
    level_f = values.mean()
    gain, offset, ready = 1.0, 0.0, False
    for _ in range(3 * _STEPS):
        if not sample(c, left, top, half, warp, g):
            break
        if not ready:
            gain, offset = _robust_light(g, values, level_f)
            ready = True
        for i in range(n):
            r[i] = g[i] - offset - gain * (values[i] - level_f)
        spread = max(scale, 1.4826 * np.median(np.abs(r)))
        normal, right, row = np.zeros((m, m)), np.zeros(m), np.empty(m)
        total, weighted_square, weighted_g, weighted_gg = 0.0, 0.0, 0.0, 0.0
        hidden = 0
        for i in range(n):
            ratio = r[i] / (_TUKEY * spread)
            if abs(ratio) >= 1.0:
                hidden += 1
                w[i] = 0.0
                continue
            w[i] = (1.0 - ratio * ratio) ** 2
            for j in range(k):
                row[j] = descent[j, i]
            row[k], row[k + 1] = values[i] - level_f, 1.0
            for p in range(m):
                right[p] += w[i] * row[p] * r[i]
                for q in range(p + 1):
                    normal[p, q] += w[i] * row[p] * row[q]
            total += w[i]
            weighted_square += w[i] * r[i] * r[i]
            weighted_g += w[i] * g[i]
            weighted_gg += w[i] * g[i] * g[i]
        if total < 4 * m:
            break
        for p in range(m):
            for q in range(p):
                normal[q, p] = normal[p, q]
            normal[p, p] += 1e-9 * normal[p, p] + 1e-12
        solution = np.linalg.solve(normal, right)
        dp = (solution[:k] / gain).astype(np.float64)
        step = _step_px(dp, half)
        warp = _compose(warp, dp)
        gain += solution[k]
        offset += solution[k + 1]
        if not (step < 4.0 and gain > 0.0):
            break
        if step < _SETTLED_PX:
            variance = weighted_gg - weighted_g * weighted_g / total
            share = 1.0 - weighted_square / max(variance, 1e-9)
            full = np.linalg.inv(normal)
            return warp, gain, weighted_square / total, share, hidden / n, np.trace(full[:2, :2]), True
    return warp, np.nan, np.nan, np.nan, 1.0, 1.0, False


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
