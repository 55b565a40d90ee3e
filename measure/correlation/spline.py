"""Interpolation between the pixels: a quintic B-spline through a lightly blurred picture.

The picture is blurred by a Gaussian of `BLUR_PX`. The blur removes what the pixels cannot resolve anyway, and with it the
bias of sub-pixel positions that aliasing causes (Sutton, Orteu and Schreier, Image Correlation for Shape, Motion and
Deformation Measurements, 2009, chapter 5). Both steps are linear and shift-invariant, so they are one separable filter.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from measure.correlation.criteria import BLUR_PX

REACH = 10
"""Half-length in px of the filter; what is cut off is half a per cent of its sum, alike in all pictures."""

_SAMPLED_QUINTIC = (66.0 / 120.0, 26.0 / 120.0, 1.0 / 120.0)


def _filter_taps(blur_px: float) -> NDArray[np.float32]:
    """Taps of Gaussian blur followed by the inverse of the sampled quintic B-spline.

        taps = F^-1 [ exp(-w^2 s^2 / 2) / ((66 + 52 cos w + 2 cos 2w) / 120) ]

    Shape (2 REACH + 1,), sum one. Source: Unser, Splines, IEEE Signal Processing Magazine 16 (1999), table 1.
    """
    w = 2.0 * np.pi * np.fft.fftfreq(512)
    b0, b1, b2 = _SAMPLED_QUINTIC
    response = np.exp(-0.5 * (w * blur_px) ** 2) / (b0 + 2.0 * b1 * np.cos(w) + 2.0 * b2 * np.cos(2.0 * w))
    taps = np.roll(np.fft.ifft(response).real, REACH)[: 2 * REACH + 1]
    return (taps / taps.sum()).astype(np.float32)


def _blur_taps(blur_px: float) -> NDArray[np.float64]:
    w = 2.0 * np.pi * np.fft.fftfreq(512)
    taps = np.roll(np.fft.ifft(np.exp(-0.5 * (w * blur_px) ** 2)).real, REACH)[: 2 * REACH + 1]
    return taps / taps.sum()


FILTER = _filter_taps(BLUR_PX)
BLUR = _blur_taps(BLUR_PX)
NOISE_LEFT = float((BLUR**2).sum() ** 2)
"""Variance that white noise of variance one keeps through the blur."""


@njit(cache=True, fastmath=True, nogil=True)
def coefficients(picture: NDArray, left: int, top: int, width: int, height: int, taps: NDArray) -> NDArray[np.float32]:
    """B-spline coefficients of a window of a picture; beyond its border the picture is continued by its edge.

    Parameters
    ----------
    picture : (rows, columns) array of any number type
    left, top, width, height : int
        The window, px; it may reach outside.
    taps : (2 r + 1,) array
        The filter, `FILTER`.

    Returns
    -------
    (height, width) array of float32
    """
    reach = (len(taps) - 1) // 2
    rows, columns = picture.shape
    wide = np.empty((height + 2 * reach, width + 2 * reach), np.float32)
    inside = left >= reach and left + width + reach <= columns
    for i in range(height + 2 * reach):
        row = min(max(top - reach + i, 0), rows - 1)
        if inside:
            for j in range(width + 2 * reach):
                wide[i, j] = picture[row, left - reach + j]
        else:
            for j in range(width + 2 * reach):
                wide[i, j] = picture[row, min(max(left - reach + j, 0), columns - 1)]
    return _filtered(wide, width, height, taps)


@njit(cache=True, fastmath=True, nogil=True)
def _filtered(wide: NDArray[np.float32], width: int, height: int, taps: NDArray[np.float32]) -> NDArray[np.float32]:
    reach = (len(taps) - 1) // 2
    across = np.empty((height, wide.shape[1]), np.float32)
    for i in range(height):
        line = np.zeros(wide.shape[1], np.float32)
        for t in range(2 * reach + 1):
            for j in range(wide.shape[1]):
                line[j] += taps[t] * wide[i + t, j]
        across[i, :] = line
    made = np.empty((height, width), np.float32)
    for i in range(height):
        line = np.zeros(width, np.float32)
        for t in range(2 * reach + 1):
            for j in range(width):
                line[j] += taps[t] * across[i, j + t]
        made[i, :] = line
    return made


@njit(cache=True, fastmath=True, nogil=True, inline="always")
def weights(t: float, w: NDArray[np.float32]) -> None:
    """Six weights of the quintic B-spline, into w (6,), at a distance t in [0, 1) behind the third of six samples."""
    s = 1.0 - t
    t2, s2 = t * t, s * s
    w[0] = s2 * s2 * s / 120.0
    w[5] = t2 * t2 * t / 120.0
    w[1] = (26.0 + t * (-50.0 + t * (20.0 + t * (20.0 + t * (-20.0 + 5.0 * t))))) / 120.0
    w[4] = (26.0 + s * (-50.0 + s * (20.0 + s * (20.0 + s * (-20.0 + 5.0 * s))))) / 120.0
    w[2] = (66.0 + t2 * (-60.0 + t2 * (30.0 - 10.0 * t))) / 120.0
    w[3] = (66.0 + s2 * (-60.0 + s2 * (30.0 - 10.0 * s))) / 120.0


@njit(cache=True, fastmath=True, nogil=True)
def sample(c: NDArray[np.float32], left: float, top: float, half: int, warp: NDArray[np.float64], out: NDArray[np.float32]) -> bool:
    """Grey values of the surface where a warp puts the pixels of a square subset.

        x' = warp[0] dx + warp[1] dy + warp[2],    y' = warp[3] dx + warp[4] dy + warp[5],    dx, dy = -half .. half

    Parameters
    ----------
    c : (rows, columns) array
        Spline coefficients of a window.
    left, top : float
        First pixel of the window.
    half : int
    warp : (6,) array
    out : ((2 half + 1)^2,) array
        Receives the grey values, row by row.

    Returns
    -------
    bool
        False, with `out` unfinished, where the warp leaves the window.
    """
    wx, wy = np.empty(6, np.float32), np.empty(6, np.float32)
    rows, columns = c.shape
    n = 0
    for dy in range(-half, half + 1):
        for dx in range(-half, half + 1):
            x = warp[0] * dx + warp[1] * dy + warp[2] - left
            y = warp[3] * dx + warp[4] * dy + warp[5] - top
            j, i = math.floor(x), math.floor(y)
            if j < 2 or i < 2 or j + 4 > columns or i + 4 > rows:
                return False
            weights(x - j, wx)
            weights(y - i, wy)
            value = np.float32(0.0)
            for k in range(6):
                line = np.float32(0.0)
                for m in range(6):
                    line += wx[m] * c[i - 2 + k, j - 2 + m]
                value += wy[k] * line
            out[n] = value
            n += 1
    return True


@njit(cache=True, fastmath=True, nogil=True)
def sample_shifted(c: NDArray[np.float32], left: float, top: float, half: int, x: float, y: float, out: NDArray[np.float32]) -> bool:
    """The same as `sample` for a warp that only shifts the centre to (x, y): one set of weights serves all pixels.

    Parameters
    ----------
    c, left, top, half, out
        As in `sample`.
    x, y : float
        Where the centre of the subset is, px.

    Returns
    -------
    bool
        False where the subset leaves the window.
    """
    wx, wy = np.empty(6, np.float32), np.empty(6, np.float32)
    j, i = math.floor(x - left) - half, math.floor(y - top) - half
    size = 2 * half + 1
    if j < 2 or i < 2 or j + size + 3 > c.shape[1] or i + size + 3 > c.shape[0]:
        return False
    weights(x - left - math.floor(x - left), wx)
    weights(y - top - math.floor(y - top), wy)
    column = np.empty(size + 5, np.float32)
    for row in range(size):
        for m in range(size + 5):
            value = np.float32(0.0)
            for k in range(6):
                value += wy[k] * c[i - 2 + row + k, j - 2 + m]
            column[m] = value
        for m in range(size):
            value = np.float32(0.0)
            for k in range(6):
                value += wx[k] * column[m + k]
            out[row * size + m] = value
    return True
