"""Prepare marks from the reference image, so that they can be found again in other pictures."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.criteria import LONGEST_BLUR_PX
from measure.correlation.reference import Reference, Subset
from measure.correlation.spline import FILTER, coefficients, sample_shifted
from measure.correlation.steepest_descent import (
    AFFINE,
    TRANSLATION,
    covariance_of_unit_noise,
    curvatures,
    descent_images,
    orthonormal_basis,
    orthonormal_in_order,
    project_off,
)
from measure.correlation.texture import determined, pixel_noise, require_texture

_MARGIN = 16
_SLOPE_STEP_PX = 0.02
_FEWEST_PIXELS = 60
_MANY_PIXELS = 400
"""A smaller subset is too easily explained by changes of light and sharpness: each of their 15 images needs some pixels."""


def reference(picture: NDArray, x: float, y: float, subset: int, warp: int = AFFINE, mask: NDArray[np.bool_] | None = None) -> Reference:
    """Prepare the mark at (x, y) of a reference image.

    Parameters
    ----------
    picture : (rows, columns) array
        The reference image.
    x, y : float
        Reference point, px.
    subset : int
        Side of the subset, odd, px.
    warp : int
        The richest warp allowed: 2, 3 or 6 parameters. Of these the mark moves along those directions only that its
        texture determines (a round dot has no rotation).
    mask : (rows, columns) array of bool, optional
        Pixels that belong to marks; all without it.

    Returns
    -------
    Reference

    Raises
    ------
    InputError
        The subset reaches over the border, or has too little texture to be found again.
    """
    half, column, row = subset // 2, round(x), round(y)
    _require_inside(picture, x, y, half)
    reach = half + _MARGIN
    surface = coefficients(picture, column - reach, row - reach, 2 * reach + 1, 2 * reach + 1, FILTER)
    images = _images(surface, half, (0.0, 0.0))
    square = (slice(row - half, row + half + 1), slice(column - half, column + half + 1))
    kept = _kept(mask, square, subset, x, y)
    f, fx, fy = (image[kept] for image in images)
    require_texture(f, fx, fy, picture.dtype, x, y)
    noise = pixel_noise(picture[square])
    pixels = Subset(column, row, half, np.array([x - column, y - row]), surface, kept)
    return _prepared(pixels, images, warp, noise)


def blurred(mark: Reference, motion_px: NDArray[np.float64]) -> Reference:
    """Prepare a mark as it looks when it moves during the exposure: its grey values averaged along the way.

    Parameters
    ----------
    mark : Reference
    motion_px : (2,) array
        Motion during the exposure, px; 24 px at most are taken.

    Returns
    -------
    Reference
    """
    length = float(np.hypot(*motion_px))
    motion = motion_px * min(1.0, LONGEST_BLUR_PX / max(length, 1e-9))
    images = _images(mark.subset.surface, mark.half, (float(motion[0]), float(motion[1])))
    return _prepared(mark.subset, images, mark.warp, basis=mark.basis)


def _kept(mask: NDArray[np.bool_] | None, square: tuple[slice, slice], subset: int, x: float, y: float) -> NDArray[np.int64]:
    """Pixels of the subset that the mask leaves, counted row by row."""
    kept = np.arange(subset**2) if mask is None else np.flatnonzero(mask[square])
    if len(kept) < _FEWEST_PIXELS:
        raise InputError(
            f"mark at {x:g},{y:g}: the mask leaves {len(kept)} pixels of its subset, {_FEWEST_PIXELS} are needed. "
            "Paint the mark white in the mask, or enlarge --subset."
        )
    return kept


def _images(surface: NDArray, half: int, motion: tuple[float, float]) -> tuple[NDArray, NDArray, NDArray]:
    """Grey values and their slopes along x and y at the subset's pixels, averaged over a motion; (n,) each."""
    count = max(1, math.ceil(1.5 * math.hypot(*motion)))
    parts = (np.arange(count) + 0.5) / count - 0.5
    middle, h = half + _MARGIN, _SLOPE_STEP_PX
    f, fx, fy = (np.zeros((2 * half + 1) ** 2) for _ in range(3))
    for part in parts:
        x, y = middle + part * motion[0], middle + part * motion[1]
        f += _at(surface, half, x, y) / count
        fx += (_at(surface, half, x + h, y) - _at(surface, half, x - h, y)) / (2 * h * count)
        fy += (_at(surface, half, x, y + h) - _at(surface, half, x, y - h)) / (2 * h * count)
    return f, fx, fy


def _at(surface: NDArray, half: int, x: float, y: float) -> NDArray[np.float64]:
    values = np.empty((2 * half + 1) ** 2, np.float32)
    sample_shifted(surface, 0, 0, half, x, y, values)
    return values.astype(np.float64)


def _prepared(
    subset: Subset, images: tuple[NDArray, NDArray, NDArray], warp: int, noise: float = 0.0, basis: NDArray | None = None
) -> Reference:
    """With even light, and with light and sharpness that change across the mark where the texture distinguishes them from motion."""
    half, kept = subset.half, subset.kept
    f, fx, fy = (image[kept] for image in images)
    across = np.arange(-half, half + 1) / half
    x, y = (image.ravel()[kept] for image in np.meshgrid(across, across))
    even = f - f.mean()
    descent = descent_images(fx, fy, half * x, half * y, warp)
    many = f.size > _MANY_PIXELS
    light = orthonormal_in_order([np.ones(f.size), even])
    bends = np.stack([slope * part for slope in (fx, fy) for part in (x * x, x * y, y * y)])
    moves = orthonormal_basis(project_off(descent, light))
    bending = orthonormal_basis(project_off(project_off(bends, light), moves))[: None if many else 0]
    if basis is None:
        projected = project_off(project_off(descent, light), bending)
        basis = determined(projected @ projected.T, half, f.size, noise)
        if basis.shape[1] == TRANSLATION < warp:
            return _prepared(subset, images, TRANSLATION)
    plain = _projected(subset, f, light, descent, bending, basis)
    sharpness = [image[kept] for image in curvatures(*images[1:])] if many else []
    gradients = [side * image for side in (x, y) for image in (np.ones(f.size), even, *sharpness)]
    # With the same `bending` both answer alike to a motion that bends.
    uneven = _projected(subset, f, orthonormal_in_order([np.ones(f.size), even, *sharpness, *gradients]), descent, bending, basis)
    distinct = np.trace(uneven.noise[:2, :2]) < 4.0 * np.trace(plain.noise[:2, :2])
    return replace(plain, uneven_light=uneven if distinct else None)


def _projected(subset: Subset, f: NDArray, light: NDArray, descent: NDArray, bending: NDArray, basis: NDArray) -> Reference:
    bending = orthonormal_basis(project_off(bending, light))
    projected = project_off(project_off(descent, light), bending)
    along = covariance_of_unit_noise(basis.T @ projected, 2 * subset.half + 1, subset.kept)
    noise, inverse_hessian = (basis @ part @ basis.T for part in along)
    f32, l32, b32, d32, p32 = (np.ascontiguousarray(image, np.float32) for image in (f, light, bending, descent, projected))
    return Reference(subset, f32, l32, b32, d32, p32, inverse_hessian, noise, basis)


def _require_inside(picture: NDArray, x: float, y: float, half: int) -> None:
    rows, columns = picture.shape
    if not (half <= round(x) < columns - half and half <= round(y) < rows - half):
        raise InputError(
            f"mark at {x:g},{y:g}: its subset of {2 * half + 1} px reaches over the border of the picture of {columns} x {rows} px. "
            "Move the mark inwards or take a smaller --subset."
        )
