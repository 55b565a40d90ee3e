"""Whether a subset has texture enough to be found again, and how rich a warp it can carry."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.criteria import BLUR_PX, TEXTURE_OVER_NOISE, TEXTURE_SHARE
from measure.correlation.steepest_descent import AFFINE, EUCLIDEAN, TRANSLATION

_NOISE_SLOPE = 1.0 / (8.0 * math.pi * BLUR_PX**4)
"""Variance of a slope of blurred white noise of variance one."""


def pixel_noise(subset: NDArray) -> float:
    """Estimate the noise of a picture from second differences, which noise has and texture hardly has.

        L = [[1, -2, 1], [-2, 4, -2], [1, -2, 1]],    sigma = median abs(L * f) / (0.6745 * 6)

    Immerkaer, Computer Vision and Image Understanding 64 (1996) 300, with the median for the mean. Fine texture makes it
    too large, never too small.

    Parameters
    ----------
    subset : (rows, columns) array
        Grey values.

    Returns
    -------
    float
        Standard deviation of the noise, grey levels.
    """
    second = np.diff(np.diff(subset.astype(float), 2, axis=0), 2, axis=1)
    return float(np.median(np.abs(second)) / (0.6745 * 6.0)) + 0.3


def determined(hessian: NDArray, half: int, pixels: int, noise: float) -> NDArray[np.float64]:
    """The directions of the warp that the texture determines: the shifts, and what else it fixes with the shifts left free.

    A round dot fixes the stretches and not the rotation; two edges that cross fix the directions of both edges and not
    the stretches along them. With the shifts eliminated, H_s - H_st H_t^-1 H_ts is decomposed into its eigenvectors,
    and those are kept that stand out from the slopes of noise and from the steps of an edge from pixel to pixel.

    Parameters
    ----------
    hessian : (k, k) array
        Of the reference image, for k = 2 (shift), 3 (and rotation) or 6 (affine) parameters.
    half : int
        The subset is 2 half + 1 px wide.
    pixels : int
        Pixels of it that belong to the mark.
    noise : float
        Standard deviation of the noise, grey levels.

    Returns
    -------
    (k, r) array
        Columns of unit motion: the two shifts, and the directions kept, root mean square 1 px over the subset.
    """
    k = len(hessian)
    squares = float(np.mean(np.arange(-half, half + 1.0) ** 2))
    scale = 1.0 / np.sqrt({TRANSLATION: [], EUCLIDEAN: [2.0 * squares], AFFINE: [squares] * 4}[k])
    shape = hessian[2:, 2:] - hessian[2:, :2] @ np.linalg.solve(hessian[:2, :2], hessian[:2, 2:])
    strength, axes = np.linalg.eigh(shape * np.outer(scale, scale))
    by_noise = noise**2 * _NOISE_SLOPE * pixels
    least = max(TEXTURE_OVER_NOISE * by_noise, TEXTURE_SHARE * 0.5 * float(np.trace(hessian[:2, :2])))
    kept = scale[:, None] * axes[:, strength > least]
    basis = np.zeros((k, 2 + kept.shape[1]))
    basis[:2, :2], basis[2:, 2:] = np.eye(2), kept
    return basis


def require_texture(f: NDArray, fx: NDArray, fy: NDArray, dtype: np.dtype, x: float, y: float) -> None:
    """Refuse a subset whose poorer direction would not be known to 0.1 px.

    The noise is taken to be 1.5 grey levels of 8 bit, or one level of a deeper picture.

    Parameters
    ----------
    f, fx, fy : (n,) arrays
        Grey values and their slopes along x and y, per px.
    dtype : numpy dtype
        Of the picture.
    x, y : float
        The mark, px, for the message.

    Raises
    ------
    InputError
        The texture is too poor.
    """
    noise, contrast = 1.5 if dtype == np.uint8 else 1.0, float(f.std())
    weakest = float(np.linalg.eigvalsh(np.array([[fx @ fx, fx @ fy], [fx @ fy, fy @ fy]]))[0])
    if contrast < 2.0 * noise or weakest < 2.0 * (noise / 0.1) ** 2:
        raise InputError(
            f"mark at {x:g},{y:g}: too little texture in its subset (contrast {contrast:.1f} grey levels, "
            f"slopes in the poorer direction {np.sqrt(max(weakest, 0.0) / f.size):.2f} per px). "
            "Put the mark on a pattern with edges in two directions, or enlarge --subset."
        )
