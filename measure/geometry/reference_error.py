"""The error of the reference picture: one offset for each mark that all later pictures share, estimated with the poses of all frames.

Pixels with gaps between them, or an edge along a row of pixels, put a mark beside its place in the reference picture by up to
a sixth of a pixel. Every later sighting is off by that, as the body carries it, so that more frames do not average it out:

    seen_ti = projected_i(pose_t) + s_ti A_ti e_i + noise_ti,    e_i ~ N(0, sigma_0^2)

A is what the motion makes of a small shift on the mark. While a mark is still where it was, both pictures are off alike and s is
zero. sigma_0 comes from the film (empirical Bayes), and is zero where nothing speaks for such offsets. Offsets that look like
a pose stay unknown: their variance is part of the covariance.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LEFT_PX = 0.25
"""Motion, px, by which a mark has left the place at which its error was that of the reference picture: well below a pixel,
because the errors of pixels repeat with each of them."""

_SIGMAS_PX = np.geomspace(1e-4, 0.3, 60)
"""Standard deviations of the offsets that are tried; 0.3 px is that of an error evenly spread over a whole pixel."""

_BLOCKS, _LEAST_BLOCK = 10, 4
"""Stretches of the film, and frames in one at least, whose sums tell how much neighbouring frames err alike."""

_KNOWN = 1e-3
"""Share of the largest eigenvalue from which a direction of the offsets is known well enough to tell that."""


@dataclass(frozen=True)
class Linearised:
    """Sightings of n marks in t frames, linear about the poses that fit best; what was not used has no weight.

    Attributes
    ----------
    residual : (t, n, 2) array
        Observed minus projected, px.
    weight : (t, n, 2, 2) array
        Inverse covariance of the sightings, 1/px^2.
    slopes : (t, n, 2, k) array
        Derivatives of the positions by the pose, px per m or rad.
    carried : (t, n, 2, 2) array
        s A, what a mark's offset adds to its position.
    gone : (t,) array of bool
        Whether the marks have left their first places.
    """

    residual: Array
    weight: Array
    slopes: Array
    carried: Array
    gone: NDArray[np.bool_]

    @cached_property
    def covariance(self) -> Array:
        """(t, k, k): of the poses, by the weights alone."""
        return np.asarray(np.linalg.inv(np.einsum("tnik,tnij,tnjl->tkl", self.slopes, self.weight, self.slopes)), float)

    @cached_property
    def seen(self) -> Array:
        """(t, 2n, k): J' W s A, transposed."""
        by = np.einsum("tnji,tnjl,tnlk->tnik", self.carried, self.weight, self.slopes)
        return by.reshape(len(by), -1, by.shape[-1])

    def equations(self, part: slice) -> tuple[Array, Array]:
        """Normal equations of the offsets from some frames, with their poses eliminated: (2n, 2n) and (2n,)."""
        carried, weight, seen = self.carried[part], self.weight[part], self.seen[part]
        own = np.einsum("tnji,tnjl,tnlm->nim", carried, weight, carried)
        matrix = -np.einsum("tak,tkl,tbl->ab", seen, self.covariance[part], seen, optimize=True)
        for i, block in enumerate(own):
            matrix[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] += block
        return matrix, np.einsum("tnji,tnjl,tnl->ni", carried, weight, self.residual[part]).ravel()


@dataclass(frozen=True)
class Offsets:
    """The offsets of n marks. `px` : (n, 2) array. `covariance` : (2n, 2n) array, px^2, given the film."""

    px: Array
    covariance: Array

    @classmethod
    def none(cls, marks: int) -> Offsets:
        """No offsets, known for certain."""
        return cls(np.zeros((marks, 2)), np.zeros((2 * marks, 2 * marks)))

    def on_marks(self, frames: Linearised) -> tuple[Array, Array]:
        """What they add to the positions, (t, n, 2) px, and the covariance of that, (t, n, 2, 2)."""
        marks = len(self.px)
        own = np.einsum("ninj->nij", self.covariance.reshape(marks, 2, marks, 2))
        shift = np.einsum("tnij,nj->tni", frames.carried, self.px)
        return shift, np.einsum("tnij,njl,tnml->tnim", frames.carried, own, frames.carried)

    def on_poses(self, frames: Linearised) -> tuple[Array, Array]:
        """What they add to the poses, (t, k), and the covariance of that, (t, k, k)."""
        by = frames.covariance @ np.swapaxes(frames.seen, 1, 2)
        return by @ self.px.ravel(), by @ self.covariance @ np.swapaxes(by, 1, 2)


def share_left(moved_px: Array) -> Array:
    """How far marks are free of the error that they have at their first place, from zero to one.

    Parameters
    ----------
    moved_px : array
        Distance from the first place, px, NaN where it is not known.

    Returns
    -------
    array
        Zero where it is not known.
    """
    return np.nan_to_num(-np.expm1(-0.5 * (moved_px / _LEFT_PX) ** 2))


def estimate_offsets(frames: Linearised, variance: float) -> Offsets:
    """The offsets that all frames of a film share.

    Parameters
    ----------
    frames : Linearised
        At the poses that fit best without offsets.
    variance : float
        Times that the covariances of the sightings are too small, from the misfit.

    Returns
    -------
    Offsets
        None where the film does not speak for them.
    """
    count, marks = frames.residual.shape[:2]
    length = max(_LEAST_BLOCK, -(-count // _BLOCKS))
    groups = [frames.equations(slice(first, first + length)) for first in range(0, count, length)]
    groups = [(matrix / variance, vector / variance) for matrix, vector in groups]
    matrix, vector = np.sum([a for a, _ in groups], axis=0), np.sum([b for _, b in groups], axis=0)
    counted = _counted(matrix, vector, groups)
    values, vectors = np.linalg.eigh(counted * matrix)
    values = np.maximum(values, 0.0)
    prior = _prior_variance(values, vectors.T @ vector * counted)
    if prior == 0.0:
        return Offsets.none(marks)
    covariance = (vectors * (prior / (1.0 + prior * values))) @ vectors.T
    return Offsets((covariance @ vector * counted).reshape(marks, 2), covariance)


def _counted(matrix: Array, vector: Array, groups: list[tuple[Array, Array]]) -> float:
    """Share of the frames that count: sums over stretches scatter more than their weights say where neighbouring frames err alike."""
    values, vectors = np.linalg.eigh(matrix)
    known = values > _KNOWN * values[-1]
    if values[-1] <= 0.0 or len(groups) < 2:
        return 1.0
    white = vectors[:, known] / np.sqrt(values[known])
    offsets = white @ (white.T @ vector)
    scatter = sum(float(np.sum((white.T @ (b - a @ offsets)) ** 2)) for a, b in groups)
    return min(1.0, float(known.sum()) * (1.0 - 1.0 / len(groups)) / max(scatter, 1e-12))


def _prior_variance(values: Array, along: Array) -> float:
    """sigma_0^2, px^2: its mean over the likelihood, or zero where the likelihood is largest without offsets.

    log L = sum_k -1/2 log(1 + sigma_0^2 values_k) + 1/2 along_k^2 sigma_0^2 / (1 + sigma_0^2 values_k)
    """
    squares = _SIGMAS_PX[:, None] ** 2
    grown = 1.0 + squares * values
    likelihood = np.sum(-0.5 * np.log(grown) + 0.5 * along**2 * squares / grown, axis=1)
    if likelihood.max() <= 0.0:
        return 0.0
    weight = np.exp(likelihood - likelihood.max())
    return float(weight @ squares[:, 0] / weight.sum())
