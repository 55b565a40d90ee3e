"""The pose of one frame: the rigid motion that fits the positions of its marks best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from measure.correlation.marks import Marks
from measure.geometry.body import Body

Array = NDArray[np.float64]

_MODEL_ERROR_PX = 0.0005
_DISAGREE = 10.0
"""Chi-square per degree of freedom from which the marks of a frame disagree."""

_CULPRIT = 0.2
"""Share of that chi-square that remains when the mark that caused it is left out."""

_OUTLIER_PX = 0.1
_STEPS = 30
_SINGULAR = 1e16


@dataclass(frozen=True)
class FramePose:
    """One frame: pose (6,), slopes (marks, 2, k), residuals (marks, 2), marks used, degrees of freedom, chi-square for each of them."""

    pose: Array
    slopes: Array
    residual: Array
    used: NDArray[np.bool_]
    freedom: int
    misfit: float


def weights_of(marks: Marks) -> Array:
    """Inverse covariances of the marks, (frames, marks, 2, 2), 1/px^2; zero where there is no position."""
    covariance = np.where(marks.observed[..., None, None], marks.covariance_px2, np.eye(2)) + _MODEL_ERROR_PX**2 * np.eye(2)
    return np.asarray(np.linalg.inv(covariance) * marks.observed[..., None, None], float)


def fit_frame(body: Body, at: list[int], picture: Array, weights: Array, kept: NDArray[np.bool_], start: Array) -> FramePose | None:
    """Fit one frame. While the marks disagree and one of them alone explains it, that mark is left out.

    Parameters
    ----------
    body : Body
    at : list of k int
        Indices of the free channels into `CHANNELS`.
    picture : (marks, 2) array
        Observed positions, px.
    weights : (marks, 2, 2) array
        Their inverse covariances.
    kept : (marks,) array of bool
        Marks that are observed.
    start : (6,) array
        Pose to start from.

    Returns
    -------
    FramePose or None
        None where the marks are too few.
    """

    def solve(kept: NDArray[np.bool_]) -> FramePose | None:
        freedom = 2 * int(kept.sum()) - len(at)
        if freedom < 0 or kept.sum() < (2 if len(at) > 2 else 1):
            return None
        return _solve(body, at, picture, weights, kept, start, freedom)

    found = solve(kept)
    while found is not None and _disagree(found, len(at)):
        without = [solve(found.used & (np.arange(len(kept)) != i)) for i in np.flatnonzero(found.used)]
        best = min((other for other in without if other is not None), key=lambda other: other.misfit, default=None)
        if best is None or not best.misfit < _CULPRIT * found.misfit:
            break
        found = best
    return found


def _disagree(found: FramePose, channels: int) -> bool:
    """Whether the marks of a frame contradict each other, and one of them can be spared."""
    spare = 2 * found.used.sum() - channels >= 3
    return bool(found.misfit > _DISAGREE and np.abs(found.residual[found.used]).max() > _OUTLIER_PX and spare)


def _solve(
    body: Body, at: list[int], picture: Array, weights: Array, kept: NDArray[np.bool_], start: Array, freedom: int
) -> FramePose | None:
    """Gauss-Newton on the pose: minimise sum r' C^-1 r, r = observed - projected."""
    pose = start.copy()
    for _ in range(_STEPS):
        projected, slopes = body.slopes(pose, at)
        residual = picture - projected
        j, r, w = slopes[kept], residual[kept], weights[kept]
        normal = np.einsum("nik,nij,njl->kl", j, w, j)
        if not np.isfinite(normal).all() or np.linalg.cond(normal) > _SINGULAR:
            return None
        covariance = np.linalg.inv(normal)
        step = covariance @ np.einsum("nik,nij,nj->k", j, w, r)
        pose[at] += step
        if (np.abs(step) < 1e-4 * np.sqrt(np.diag(covariance))).all():
            residual = picture - body.project(pose)
            square = float(np.einsum("ni,nij,nj->", residual[kept], weights[kept], residual[kept]))
            return FramePose(pose, slopes, residual, kept, freedom, square / freedom if freedom else np.nan)
    return None
