"""What a mark looks like, prepared so that it can be found again: slopes, the light's freedom, and what noise does to them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.sensitivity_images import (
    AFFINE,
    EUCLIDEAN,
    TRANSLATION,
    covariance_of_unit_noise,
    curvatures,
    descent_images,
    directions,
    orthonormal,
    without,
)
from measure.correlation.spline import BLUR_PX, FILTER, coefficients, sample_shifted

WARP_NAMES = {TRANSLATION: "translation", EUCLIDEAN: "euclidean", AFFINE: "affine"}

LONGEST_BLUR_PX = 24.0
_MARGIN = 16
_SLOPE_STEP_PX = 0.02
_NOISE_SLOPE = 1.0 / (8.0 * math.pi * BLUR_PX**4)
"""Variance of a slope of blurred white noise of variance one."""

_TEXTURE_OVER_NOISE = 2.0
_FEWEST_PIXELS = 60
_MANY_PIXELS = 400
"""A smaller subset is too easily explained by light and sharpness that change: each of their 15 images needs some pixels."""


Place = tuple[int, int, int, NDArray[np.float64], NDArray[np.float32], NDArray[np.int64]]
"""The first six fields of a reference."""


@dataclass(frozen=True)
class Reference:
    """A mark as the reference image shows it, ready to be found again.

    column, row : the subset's centre pixel. offset : (2,) from it to the reference point, px. surface : spline
    coefficients around it. kept : (n,) pixels of the square subset that belong to the mark. values : (n,) blurred grey values
    f. light : (m, n) orthonormal images that light can add: 1 and f, or these and their products with x and y. look : (b, n)
    orthonormal images of what else may change: motion that bends across the mark; it moves nothing, and is no noise.
    descent : (k, n) slopes along the warp's parameters; free : the same, projected off the light. inverse_hessian : (k, k)
    of `free`. noise : (k, k), covariance of the parameters for pixel noise of variance one. altered : the same mark when
    light and sharpness may change across it, where that can be told from motion.
    """

    column: int
    row: int
    half: int
    offset: NDArray[np.float64]
    surface: NDArray[np.float32]
    kept: NDArray[np.int64]
    values: NDArray[np.float32]
    light: NDArray[np.float32]
    look: NDArray[np.float32]
    descent: NDArray[np.float32]
    free: NDArray[np.float32]
    inverse_hessian: NDArray[np.float64]
    noise: NDArray[np.float64]
    altered: Reference | None = None

    @property
    def warp(self) -> int:
        """The number of parameters of the warp."""
        return len(self.descent)

    @cached_property
    def shape(self) -> NDArray[np.bool_] | None:
        """(size, size): which pixels of the square belong to the mark; None where all do."""
        size = 2 * self.half + 1
        if len(self.kept) == size**2:
            return None
        belongs = np.zeros(size**2, dtype=bool)
        belongs[self.kept] = True
        return belongs.reshape(size, size)

    @cached_property
    def uneven(self) -> NDArray[np.float32]:
        """(4 or 0, n): orthonormal images that light changing across the mark adds, where that can be told from motion."""
        return self.light[:0] if self.altered is None else self.altered.light[2:]

    @cached_property
    def added(self) -> NDArray[np.float32]:
        """(m + b, n): all that comes on top of the warp."""
        return np.concatenate([self.light, self.look])

    @property
    def is_altered(self) -> bool:
        """Whether the light may change across the mark."""
        return len(self.light) > 2

    @cached_property
    def contrast(self) -> float:
        """Standard deviation of the grey values."""
        return float(self.values.std())

    @property
    def start(self) -> NDArray[np.float64]:
        """The warp that leaves the mark where the reference image has it."""
        return np.array([1.0, 0.0, self.column, 0.0, 1.0, self.row])

    @cached_property
    def point_noise(self) -> NDArray[np.float64]:
        """(2, 2), covariance of the reference point for pixel noise of variance one, px^2."""
        slopes = self.point_slopes
        return slopes @ self.noise @ slopes.T

    @cached_property
    def point_slopes(self) -> NDArray[np.float64]:
        """(2, k): how the reference point moves with the parameters."""
        x, y = self.offset
        slopes = {
            TRANSLATION: [[1, 0], [0, 1]],
            EUCLIDEAN: [[1, 0, -y], [0, 1, x]],
            AFFINE: [[1, 0, x, y, 0, 0], [0, 1, 0, 0, x, y]],
        }
        return np.array(slopes[self.warp], float)

    def point(self, warp: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where a warp puts the reference point, px."""
        return warp[[2, 5]] + warp.reshape(2, 3)[:, :2] @ self.offset


def reference(picture: NDArray, x: float, y: float, subset: int, warp: int = AFFINE, mask: NDArray[np.bool_] | None = None) -> Reference:
    """Prepare the mark at (x, y) of a reference image.

    picture : (rows, columns). subset : odd, px. warp : the richest allowed; a poorer one is taken where the texture
    cannot tell more (a dot has no rotation). mask : (rows, columns), which pixels belong to marks; all without it.

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
    _require_texture(f, fx, fy, picture.dtype, x, y)
    noise = _pixel_noise(picture[square])
    place = (column, row, half, np.array([x - column, y - row]), surface, kept)
    made = (_prepared(place, images, k) for k in (AFFINE, EUCLIDEAN, TRANSLATION) if k <= warp)
    return next(mark for mark in made if mark.warp == TRANSLATION or _tells(mark, noise))


def _kept(mask: NDArray[np.bool_] | None, square: tuple[slice, slice], subset: int, x: float, y: float) -> NDArray[np.int64]:
    """Pixels of the subset that the mask leaves, counted row by row."""
    kept = np.arange(subset**2) if mask is None else np.flatnonzero(mask[square])
    if len(kept) < _FEWEST_PIXELS:
        raise InputError(
            f"mark at {x:g},{y:g}: the mask leaves {len(kept)} pixels of its subset, {_FEWEST_PIXELS} are needed. "
            "Paint the mark white in the mask, or enlarge --subset."
        )
    return kept


def blurred(mark: Reference, motion_px: NDArray[np.float64]) -> Reference:
    """The mark as it looks when it moves by `motion_px` (2,) during the exposure: its grey values averaged along the way."""
    length = float(np.hypot(*motion_px))
    motion = motion_px * min(1.0, LONGEST_BLUR_PX / max(length, 1e-9))
    place = (mark.column, mark.row, mark.half, mark.offset, mark.surface, mark.kept)
    return _prepared(place, _images(mark.surface, mark.half, (float(motion[0]), float(motion[1]))), mark.warp)


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


def _prepared(place: Place, images: tuple[NDArray, NDArray, NDArray], warp: int) -> Reference:
    """Project the slopes off what light can do, and keep what each iteration needs."""
    half, kept = place[2], place[5]
    f, fx, fy = (image[kept] for image in images)
    across = np.arange(-half, half + 1) / half
    x, y = (image.ravel()[kept] for image in np.meshgrid(across, across))
    even = f - f.mean()
    descent = descent_images(fx, fy, half * x, half * y, warp)
    many = f.size > _MANY_PIXELS
    sharpness = [image[kept] for image in curvatures(*images[1:])] if many else []
    light = orthonormal([np.ones(f.size), even])
    bends = np.stack([slope * part for slope in (fx, fy) for part in (x * x, x * y, y * y)])
    look = directions(without(without(bends, light), directions(without(descent, light))))[: None if many else 0]
    plain = _under(place, f, light, descent, look)
    across_too = [side * image for side in (x, y) for image in (np.ones(f.size), even, *sharpness)]
    # The same `look` keeps both answers to a motion that bends the same, whatever else is allowed for.
    altered = _under(place, f, orthonormal([np.ones(f.size), even, *sharpness, *across_too]), descent, look)
    told = np.trace(altered.noise[:2, :2]) < 4.0 * np.trace(plain.noise[:2, :2])
    return replace(plain, altered=altered if told else None)


def _under(place: Place, f: NDArray, light: NDArray, descent: NDArray, look: NDArray) -> Reference:
    look = directions(without(look, light))
    free = without(without(descent, light), look)
    noise, inverse_hessian = covariance_of_unit_noise(free, 2 * place[2] + 1, place[5])
    f32, l32, k32, d32, p32 = (np.ascontiguousarray(a, np.float32) for a in (f, light, look, descent, free))
    return Reference(*place, f32, l32, k32, d32, p32, inverse_hessian, noise)


def _pixel_noise(subset: NDArray) -> float:
    """Standard deviation of the noise, from second differences, which texture hardly has and noise has.

    L = [[1, -2, 1], [-2, 4, -2], [1, -2, 1]],  sigma = median abs(L) / (0.6745 * 6). Immerkaer, Computer Vision and
    Image Understanding 64 (1996) 300, with the median for the mean. Fine texture makes it too large, never too small.
    """
    across = np.diff(np.diff(subset.astype(float), 2, axis=0), 2, axis=1)
    return float(np.median(np.abs(across)) / (0.6745 * 6.0)) + 0.3


def _tells(mark: Reference, noise: float) -> bool:
    """Whether turn and stretch are told by the texture, and not by noise whose slopes look like texture."""
    across = np.arange(-mark.half, mark.half + 1.0)
    squares = float(np.mean(across**2))
    lever = {EUCLIDEAN: [2 * squares], AFFINE: [squares] * 4}[mark.warp]
    by_noise = noise**2 * _NOISE_SLOPE * mark.values.size * np.array([1.0, 1.0, *lever])
    scaled = np.linalg.inv(mark.inverse_hessian) / np.sqrt(np.outer(by_noise, by_noise))
    return bool(np.linalg.eigvalsh(scaled)[0] > _TEXTURE_OVER_NOISE)


def _require_inside(picture: NDArray, x: float, y: float, half: int) -> None:
    rows, columns = picture.shape
    if not (half <= round(x) < columns - half and half <= round(y) < rows - half):
        raise InputError(
            f"mark at {x:g},{y:g}: its subset of {2 * half + 1} px reaches over the border of the picture of {columns} x {rows} px. "
            "Move the mark inwards or take a smaller --subset."
        )


def _require_texture(f: NDArray, fx: NDArray, fy: NDArray, dtype: np.dtype, x: float, y: float) -> None:
    """Refuse a subset whose poorer direction would not be known to 0.1 px at noise of 1.5 steps of 8 bit, or of one step."""
    noise, contrast = 1.5 if dtype == np.uint8 else 1.0, float(f.std())
    weakest = float(np.linalg.eigvalsh(np.array([[fx @ fx, fx @ fy], [fx @ fy, fy @ fy]]))[0])
    if contrast < 2.0 * noise or weakest < 2.0 * (noise / 0.1) ** 2:
        raise InputError(
            f"mark at {x:g},{y:g}: too little texture in its subset (contrast {contrast:.1f} grey levels, "
            f"slopes in the poorer direction {np.sqrt(max(weakest, 0.0) / f.size):.2f} per px). "
            "Put the mark on a pattern with edges in two directions, or enlarge --subset."
        )
