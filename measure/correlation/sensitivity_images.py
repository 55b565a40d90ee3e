"""Images that a small change adds to a mark, and what noise makes of them: slopes, light, sharpness, bending."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d

from measure.correlation.spline import BLUR

TRANSLATION, EUCLIDEAN, AFFINE = 2, 3, 6
"""Warps by their number of parameters."""

_FAINT = 1e-8


def curvatures(fx: NDArray, fy: NDArray) -> tuple[NDArray, ...]:
    """Second derivatives of the grey values; a mark that is compressed, or out of focus, is blurred along some direction."""
    size = math.isqrt(fx.size)
    across, down = fx.reshape(size, size), fy.reshape(size, size)
    return tuple(np.asarray(np.gradient(slope, axis=axis)).ravel() for slope, axis in ((across, 1), (across, 0), (down, 0)))


def without(images: NDArray, rows: NDArray) -> NDArray:
    """What is left of images beside orthonormal rows."""
    return images - (images @ rows.T) @ rows


def directions(images: NDArray) -> NDArray:
    """Orthonormal images that span the same, without those that are hardly there."""
    strength, axes = np.linalg.eigh(images @ images.T)
    kept = strength > _FAINT * strength.max(initial=0.0)
    return (axes[:, kept].T @ images) / np.sqrt(strength[kept])[:, None]


def orthonormal(rows: list[NDArray]) -> NDArray:
    """Gram and Schmidt, by the Cholesky factor of the products; twice, so that rounding does not show."""
    made = np.stack([row / np.sqrt(row @ row) for row in rows])
    for _ in range(2):
        made = np.linalg.solve(np.linalg.cholesky(made @ made.T), made)
    return made


def descent_images(fx: NDArray, fy: NDArray, x: NDArray, y: NDArray, warp: int) -> NDArray:
    """Slopes of the reference image along the parameters: shift x, shift y; rotation; or the four of an affine warp."""
    images = {TRANSLATION: (fx, fy), EUCLIDEAN: (fx, fy, fy * x - fx * y), AFFINE: (fx, fy, fx * x, fx * y, fy * x, fy * y)}
    return np.stack(images[warp])


def covariance_of_unit_noise(free: NDArray, subset: int, kept: NDArray) -> tuple[NDArray, NDArray]:
    """Covariance of the parameters for white noise of variance one, and the inverse Hessian.

    The blur correlates the noise of neighbouring pixels: with B the blur, cov = H^-1 (S B B' S') H^-1, H = S S'.
    """
    square = np.zeros((len(free), subset * subset))
    square[:, kept] = free
    wide = np.pad(square.reshape(-1, subset, subset), ((0, 0), (6, 6), (6, 6)))
    taps = BLUR[len(BLUR) // 2 - 6 : len(BLUR) // 2 + 7]
    spread = convolve1d(convolve1d(wide, taps, axis=1), taps, axis=2).reshape(len(free), -1)
    inverse = np.linalg.pinv(free @ free.T)
    return inverse @ (spread @ spread.T) @ inverse, inverse
