"""Images that a small change adds to the reference image (shift, rotation, stretch, light, sharpness), and what noise does.

The images that a small change of a warp parameter adds are the steepest-descent images of Baker and Matthews,
International Journal of Computer Vision 56 (2004) 221, section 3.2.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d

from measure.correlation.spline import BLUR

TRANSLATION, EUCLIDEAN, AFFINE = 2, 3, 6
"""Warps by their number of parameters: shift; shift and rotation; affine."""

WARP_NAMES = {TRANSLATION: "translation", EUCLIDEAN: "euclidean", AFFINE: "affine"}

_NEGLIGIBLE = 1e-8


def descent_images(fx: NDArray, fy: NDArray, x: NDArray, y: NDArray, warp: int) -> NDArray:
    """Steepest-descent images: the change of the reference image along each parameter of the warp.

    Parameters
    ----------
    fx, fy : (n,) arrays
        Slopes of the reference image along x and y, grey levels per px.
    x, y : (n,) arrays
        Pixels, px from the centre of the subset.
    warp : int
        2 (shift x, shift y), 3 (and rotation) or 6 (and the four of an affine warp).

    Returns
    -------
    (warp, n) array
    """
    images = {TRANSLATION: (fx, fy), EUCLIDEAN: (fx, fy, fy * x - fx * y), AFFINE: (fx, fy, fx * x, fx * y, fy * x, fy * y)}
    return np.stack(images[warp])


def curvatures(fx: NDArray, fy: NDArray) -> tuple[NDArray, ...]:
    """Second derivatives of the grey values, which a change of sharpness adds: compression or defocus blurs along some direction.

    Parameters
    ----------
    fx, fy : (n,) arrays
        Slopes over a whole square subset, row by row.

    Returns
    -------
    three (n,) arrays
        f_xx, f_xy, f_yy.
    """
    size = math.isqrt(fx.size)
    across, down = fx.reshape(size, size), fy.reshape(size, size)
    return tuple(np.asarray(np.gradient(slope, axis=axis)).ravel() for slope, axis in ((across, 1), (across, 0), (down, 0)))


def project_off(images: NDArray, rows: NDArray) -> NDArray:
    """Images (k, n) without their part along orthonormal rows (m, n)."""
    return images - (images @ rows.T) @ rows


def orthonormal_basis(images: NDArray) -> NDArray:
    """Orthonormal images (r, n) that span the same as images (k, n); directions of negligible strength are left out."""
    strength, axes = np.linalg.eigh(images @ images.T)
    kept = strength > _NEGLIGIBLE * strength.max(initial=0.0)
    return (axes[:, kept].T @ images) / np.sqrt(strength[kept])[:, None]


def orthonormal_in_order(rows: list[NDArray]) -> NDArray:
    """Orthonormal images (k, n), each from the given ones up to it (Gram and Schmidt).

    By the Cholesky factor of the products; done twice, so that rounding does not show.
    """
    made = np.stack([row / np.sqrt(row @ row) for row in rows])
    for _ in range(2):
        made = np.linalg.solve(np.linalg.cholesky(made @ made.T), made)
    return made


def covariance_of_unit_noise(projected: NDArray, subset: int, kept: NDArray) -> tuple[NDArray, NDArray]:
    """Covariance of the warp parameters for white pixel noise of variance one, and the inverse Hessian.

        cov = H^-1 (S B B' S') H^-1,    H = S S'

    with S the steepest-descent images and B the blur, which correlates the noise of neighbouring pixels.

    Parameters
    ----------
    projected : (k, n) array
        Steepest-descent images, projected off what else may change.
    subset : int
        Side of the square, px.
    kept : (n,) array of int
        Pixels of the square that belong to the mark.

    Returns
    -------
    covariance, inverse_hessian : (k, k) arrays
    """
    square = np.zeros((len(projected), subset * subset))
    square[:, kept] = projected
    wide = np.pad(square.reshape(-1, subset, subset), ((0, 0), (6, 6), (6, 6)))
    taps = BLUR[len(BLUR) // 2 - 6 : len(BLUR) // 2 + 7]
    spread = convolve1d(convolve1d(wide, taps, axis=1), taps, axis=2).reshape(len(projected), -1)
    inverse = np.linalg.pinv(projected @ projected.T)
    return inverse @ (spread @ spread.T) @ inverse, inverse
