"""Whether a subset has texture enough to be found again, and how rich a warp it can carry."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.criteria import BLUR_PX, TEXTURE_OVER_NOISE
from measure.correlation.steepest_descent import AFFINE, EUCLIDEAN

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


def carries(warp: int, inverse_hessian: NDArray, half: int, pixels: int, noise: float) -> bool:
    """Whether rotation and stretch are determined by the texture, and not by noise whose slopes look like texture.

    Parameters
    ----------
    warp : int
        Number of parameters: 3 (shift and rotation) or 6 (affine).
    inverse_hessian : (warp, warp) array
        Of the reference image.
    half : int
        The subset is 2 half + 1 px wide.
    pixels : int
        Pixels of it that belong to the mark.
    noise : float
        Standard deviation of the noise, grey levels.

    Returns
    -------
    bool
    """
    across = np.arange(-half, half + 1.0)
    squares = float(np.mean(across**2))
    lever = {EUCLIDEAN: [2 * squares], AFFINE: [squares] * 4}[warp]
    by_noise = noise**2 * _NOISE_SLOPE * pixels * np.array([1.0, 1.0, *lever])
    scaled = np.linalg.inv(inverse_hessian) / np.sqrt(np.outer(by_noise, by_noise))
    return bool(np.linalg.eigvalsh(scaled)[0] > TEXTURE_OVER_NOISE)


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
