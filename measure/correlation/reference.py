"""A mark prepared for Gauss-Newton: grey values, steepest-descent images, and what noise does to its position."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from measure.correlation.steepest_descent import AFFINE, EUCLIDEAN, TRANSLATION

_MOSTLY = 0.9
"""Share of a rotation that must be determined for the mark to be searched for turned, and of a stretch that must not be to be open."""


@dataclass(frozen=True)
class Subset:
    """The pixels of a mark in the reference image.

    Attributes
    ----------
    column, row : int
        Centre pixel of the square.
    half : int
        The square is 2 half + 1 px wide.
    offset : (2,) array
        From the centre pixel to the reference point, px.
    surface : (rows, columns) array of float32
        Spline coefficients of the reference image around it.
    kept : (n,) array of int
        Pixels of the square that belong to the mark, counted row by row.
    """

    column: int
    row: int
    half: int
    offset: NDArray[np.float64]
    surface: NDArray[np.float32]
    kept: NDArray[np.int64]


@dataclass(frozen=True)
class Reference:
    """A mark prepared for Gauss-Newton.

    Attributes
    ----------
    subset : Subset
    values : (n,) array of float32
        Blurred grey values f.
    light : (m, n) array of float32
        Orthonormal images that a change of light can add: 1 and f; where the light may change across the mark, also
        their products with x and y, and changes of sharpness.
    bending : (b, n) array of float32
        Orthonormal images that a motion bending across the mark adds; they shift nothing and are no noise.
    descent : (k, n) array of float32
        Steepest-descent images along the warp's parameters.
    projected : (k, n) array of float32
        The same, projected off light and bending.
    inverse_hessian : (k, k) array
        Of `projected`, along the determined directions.
    noise : (k, k) array
        Covariance of the parameters for pixel noise of variance one.
    basis : (k, r) array
        Directions of the warp that the texture determines; the warp moves along no other.
    uneven_light : Reference or None
        The same mark with light and sharpness that may change across it, where that can be distinguished from motion.
    """

    subset: Subset
    values: NDArray[np.float32]
    light: NDArray[np.float32]
    bending: NDArray[np.float32]
    descent: NDArray[np.float32]
    projected: NDArray[np.float32]
    inverse_hessian: NDArray[np.float64]
    noise: NDArray[np.float64]
    basis: NDArray[np.float64]
    uneven_light: Reference | None = None

    @property
    def half(self) -> int:
        """The subset is 2 half + 1 px wide."""
        return self.subset.half

    @property
    def warp(self) -> int:
        """Number of parameters of the warp."""
        return len(self.descent)

    @cached_property
    def shape(self) -> NDArray[np.bool_] | None:
        """(size, size): which pixels of the square belong to the mark; None where all do."""
        size, kept = 2 * self.half + 1, self.subset.kept
        if len(kept) == size**2:
            return None
        belongs = np.zeros(size**2, dtype=bool)
        belongs[kept] = True
        return belongs.reshape(size, size)

    @cached_property
    def uneven(self) -> NDArray[np.float32]:
        """(u, n): orthonormal images that light changing across the mark adds; none where that cannot be distinguished from motion."""
        return self.light[:0] if self.uneven_light is None else self.uneven_light.light[2:]

    @cached_property
    def determined(self) -> NDArray[np.float32]:
        """(r, n): steepest-descent images along the determined directions."""
        return np.ascontiguousarray(self.basis.T @ self.descent, np.float32)

    @property
    def turns(self) -> bool:
        """Whether the texture shows a rotation of the mark in the picture."""
        rotation = np.array([0.0, -1.0, 1.0, 0.0]) / np.sqrt(2.0)
        return self.warp == EUCLIDEAN or (self.warp == AFFINE and bool(np.linalg.norm(self.followed @ rotation) > _MOSTLY))

    @cached_property
    def loose(self) -> tuple[NDArray[np.float64], ...]:
        """Stretches along x and along y, (2, 2) each, that the texture does not fix; only of an affine warp."""
        if self.warp != AFFINE:
            return ()
        along = np.eye(4)[[0, 3]] @ (np.eye(4) - self.followed)
        return tuple(one.reshape(2, 2) for one in along if np.linalg.norm(one) > _MOSTLY)

    @property
    def followed(self) -> NDArray[np.float64]:
        """(4, 4): what the warp takes of a change of its matrix, row by row; only for an affine warp."""
        if self.warp != AFFINE:
            return np.eye(4)
        axes = np.linalg.qr(self.basis[2:, 2:])[0]
        return axes @ axes.T

    @cached_property
    def added(self) -> NDArray[np.float32]:
        """(m + b, n): all that may change beside the warp."""
        return np.concatenate([self.light, self.bending])

    @property
    def allows_uneven_light(self) -> bool:
        """Whether the light may change across the mark."""
        return len(self.light) > 2

    @cached_property
    def contrast(self) -> float:
        """Standard deviation of the grey values."""
        return float(self.values.std())

    @property
    def start(self) -> NDArray[np.float64]:
        """(6,): the warp that leaves the mark where the reference image has it."""
        return np.array([1.0, 0.0, self.subset.column, 0.0, 1.0, self.subset.row])

    @property
    def point_px(self) -> NDArray[np.float64]:
        """(2,): the reference point in the reference image, px."""
        return np.array([self.subset.column, self.subset.row], float) + self.subset.offset

    @cached_property
    def point_noise(self) -> NDArray[np.float64]:
        """(2, 2): covariance of the reference point for pixel noise of variance one, px^2."""
        return self.point_slopes @ self.noise @ self.point_slopes.T

    @cached_property
    def point_slopes(self) -> NDArray[np.float64]:
        """(2, k): motion of the reference point with each parameter of the warp."""
        x, y = self.subset.offset
        slopes = {
            TRANSLATION: [[1, 0], [0, 1]],
            EUCLIDEAN: [[1, 0, -y], [0, 1, x]],
            AFFINE: [[1, 0, x, y, 0, 0], [0, 1, 0, 0, x, y]],
        }
        return np.array(slopes[self.warp], float)

    @property
    def answer(self) -> NDArray[np.float64]:
        """(2, n): shift of the reference point for one grey level more in each pixel, px."""
        return self.point_slopes @ self.inverse_hessian @ self.projected.astype(float)

    def point(self, warp: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where a warp, (6,), puts the reference point; (2,), px."""
        return warp[[2, 5]] + warp.reshape(2, 3)[:, :2] @ self.subset.offset
