"""From marks to the platform: the pose of one rigid body that explains all marks, and its standard deviations."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from measure.correlation.marks import LOST, MISSING, OK, Marks
from measure.geometry.body import Body
from measure.geometry.camera import Camera
from measure.geometry.widening import roughness, widening
from measure.tables.trajectory import CHANNELS, Trajectory

Array = NDArray[np.float64]

ONE_MARK = ("x_m", "z_m")
PLANE = ("x_m", "z_m", "theta_y_rad")
CYLINDER = ("x_m", "z_m", "theta_y_rad", "theta_z_rad")
PERSPECTIVE = CHANNELS
"""What can be fitted: with one mark, with several, on a cylinder, and on a cylinder under perspective."""

PARTIAL = "partial"
"""Status of a frame whose pose does not rest on all marks."""

_MODEL_ERROR_PX = 0.0005
_DISAGREE = 10.0
"""Chi-square per degree of freedom from which the marks of a frame disagree."""

_CULPRIT = 0.2
"""Share of that chi-square that remains when the mark that caused it is left out."""

_OUTLIER_PX = 0.1
_WRONG_PIXEL_PX = 0.5
"""Distance from which a sighting is not even at the right pixel."""

_NOT_RIGID = 10.0
"""Misfit of the marks to the fitted body, in their own standard deviations, from which the geometry is wrong and not the noise."""

_STEPS = 30
_SINGULAR = 1e16


@dataclass(frozen=True)
class Fit:
    """The pose of every frame.

    Attributes
    ----------
    free : sequence of str
        The k channels that were fitted.
    pose : (frames, 6) array
        In the order of `CHANNELS`, m and rad; what is not free is zero, NaN in a frame without a pose.
    covariance : (frames, k, k) array
        Of the free channels.
    residual_px : (frames, marks, 2) array
        Observed minus fitted positions, px.
    slopes : (frames, marks, 2, k) array
        Of the positions with each free channel, px per m or rad.
    used : (frames, marks) array of bool
        Whether the mark took part in the fit of that frame.
    misfit : float
        Distance of the marks from the rigid body in their own standard deviations, the median of the frames; NaN where
        there is nothing to tell it by.
    widened : (frames,) array
        Factors by which the standard deviations were widened because the marks fit the rigid body less well than their
        own standard deviations say, and so that 1.96 of them hold 95 %.
    rough : (k,) array
        Factors by which those of the free channels were widened further because the pose scatters more than they say.
    """

    free: Sequence[str]
    pose: Array
    covariance: Array
    residual_px: Array
    slopes: Array
    used: NDArray[np.bool_]
    misfit: float
    widened: Array
    rough: Array

    def __repr__(self) -> str:
        posed = int(self.has_pose.sum())
        return f"Fit({', '.join(self.free)}; a pose in {posed} of {len(self.pose)} frames, sigmas widened {np.median(self.widened):.3g}x)"

    @property
    def has_pose(self) -> NDArray[np.bool_]:
        """(frames,): whether the frame has a pose."""
        return np.isfinite(self.covariance[:, 0, 0])

    @property
    def is_rigid(self) -> bool:
        """Whether the misfit of the marks can be their noise; otherwise the geometry is wrong."""
        return not self.misfit > _NOT_RIGID

    @property
    def mark_residual_px(self) -> Array:
        """(marks,): root mean square distance of each mark from the fitted body, px; NaN for a mark that took part in no frame."""
        squares = np.where(self.used, (self.residual_px**2).sum(axis=-1), 0.0).sum(axis=0)
        counts = self.used.sum(axis=0)
        return np.sqrt(np.where(counts > 0, squares / np.maximum(counts, 1), np.nan))


@dataclass(frozen=True)
class _FramePose:
    """One frame: pose (6,), covariance (k, k), residuals (marks, 2), slopes, marks used, chi-square per degree of freedom."""

    pose: Array
    covariance: Array
    residual: Array
    slopes: Array
    used: NDArray[np.bool_]
    misfit: float


def fit_platform(marks: Marks, camera: Camera, points: Array, free: Sequence[str], start: Array | None = None) -> Fit:
    """Fit the pose of a rigid body to the marks of every frame, by least squares weighted with their covariances.

    A mark that alone makes the others disagree is left out of that frame.

    Parameters
    ----------
    marks : Marks
    camera : Camera
    points : (marks, 9, 3) array
        On the body, m, from `body_points`.
    free : sequence of str
        The channels to fit.
    start : (frames, 6) array, optional
        Poses to begin with, NaN where there is none; without them each frame begins with the one before.

    Returns
    -------
    Fit
        A frame with too few marks has no pose.
    """
    at = [CHANNELS.index(channel) for channel in free]
    frames, count = marks.x_px.shape
    pose, own = np.full((frames, 6), np.nan), np.full((frames, len(at), len(at)), np.nan)
    residual, used, misfit = np.full((frames, count, 2), np.nan), np.zeros((frames, count), bool), np.full(frames, np.nan)
    slopes, weights = np.full((frames, count, 2, len(at)), np.nan), weights_of(marks)
    begin = np.full((frames, 6), np.nan) if start is None else start
    for t, found in _frame_poses(Body(camera, points, marks.response), at, marks, weights, begin):
        pose[t], own[t], residual[t], used[t], misfit[t] = found.pose, found.covariance, found.residual, found.used, found.misfit
        slopes[t] = found.slopes
    misfit[0] = np.nan  # the first frame is its own reference
    told = np.isfinite(misfit)
    deviation, widened = widening(_whitened(residual, weights, used), np.where(told, 2 * used.sum(axis=1) - len(at), 0))
    sigma = deviation[:, None] * np.sqrt(np.diagonal(own, axis1=1, axis2=2))
    rough = np.array([roughness(pose[:, channel], sigma[:, k]) for k, channel in enumerate(at)])
    covariance = own * widened[:, None, None] ** 2 * np.outer(rough, rough)
    typical = float(np.sqrt(np.median(misfit[told]))) if told.any() else np.nan
    return Fit(free, pose, covariance, residual, slopes, used, typical, widened, rough)


def _frame_poses(body: Body, at: list[int], marks: Marks, weights: Array, start: Array) -> Iterator[tuple[int, _FramePose]]:
    """Every frame that has a pose, started at `start`, or where that is NaN at the pose of the one before."""
    picture, last = np.stack([marks.x_px, marks.y_px], axis=-1), np.zeros(6)
    for t in range(len(picture)):
        begin = start[t] if np.isfinite(start[t]).all() else last
        found = _fit_frame(body, at, picture[t], weights[t], marks.observed[t].copy(), begin)
        if found is not None:
            last = found.pose
            yield t, found


def _whitened(residual: Array, weights: Array, used: NDArray[np.bool_]) -> Array:
    """Residuals of the marks that were used in their standard deviations, (frames, 2 marks), zero for the others."""
    root = np.linalg.cholesky(np.where(used[..., None, None], weights, np.eye(2)))
    return np.einsum("tnij,tni->tnj", root, np.where(used[..., None], residual, 0.0)).reshape(len(residual), -1)


def weights_of(marks: Marks) -> Array:
    """Inverse covariances of the marks, (frames, marks, 2, 2); zero where there is no position."""
    covariance = np.where(marks.observed[..., None, None], marks.covariance_px2, np.eye(2)) + _MODEL_ERROR_PX**2 * np.eye(2)
    return np.asarray(np.linalg.inv(covariance) * marks.observed[..., None, None], float)


def _fit_frame(body: Body, at: list[int], picture: Array, weights: Array, kept: NDArray[np.bool_], start: Array) -> _FramePose | None:
    """One frame. While the marks disagree and one of them alone explains it, that mark is left out."""

    def solve(kept: NDArray[np.bool_]) -> _FramePose | None:
        freedom = 2 * int(kept.sum()) - len(at)
        if freedom < 0 or kept.sum() < (2 if len(at) > 2 else 1):
            return None
        return _solve(body, at, picture, weights, kept, start, freedom)

    found = solve(kept)
    while found is not None and _disagree(found):
        without = [solve(found.used & (np.arange(len(kept)) != i)) for i in np.flatnonzero(found.used)]
        best = min((other for other in without if other is not None), key=lambda other: other.misfit, default=None)
        if best is None or not best.misfit < _CULPRIT * found.misfit:
            break
        found = best
    return found


def _disagree(found: _FramePose) -> bool:
    """Whether the marks of a frame contradict each other."""
    return bool(found.misfit > _DISAGREE and np.abs(found.residual[found.used]).max() > _OUTLIER_PX)


def _solve(
    body: Body, at: list[int], picture: Array, weights: Array, kept: NDArray[np.bool_], start: Array, freedom: int
) -> _FramePose | None:
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
            return _FramePose(pose, covariance, residual, slopes, kept, square / freedom if freedom else np.nan)
    return None


def contradicted(marks: Marks, camera: Camera, points: Array, fit: Fit) -> NDArray[np.bool_]:
    """Sightings that were left out of the fit and are wrong by it: at another pixel, and far outside of their standard deviations.

    Parameters
    ----------
    marks, camera, points
        As in `fit_platform`.
    fit : Fit
        Of the body to these marks.

    Returns
    -------
    (frames, marks) array of bool
    """
    body, at = Body(camera, points, marks.response), [CHANNELS.index(channel) for channel in fit.free]
    far = np.hypot(*np.moveaxis(fit.residual_px, -1, 0)) > _WRONG_PIXEL_PX
    wrong = marks.observed & ~fit.used & fit.has_pose[:, None] & far
    for t, i in np.argwhere(wrong):
        slopes, residual = body.slopes(fit.pose[t], at)[1][i], fit.residual_px[t, i]
        covariance = fit.widened[t] ** 2 * marks.covariance_px2[t, i] + slopes @ fit.covariance[t] @ slopes.T
        wrong[t, i] = residual @ np.linalg.solve(covariance, residual) > 2.0 * _DISAGREE
    return wrong


def trajectory(marks: Marks, fit: Fit, start_height_m: float, name: str = "trajectory") -> Trajectory:
    """The platform's motion as a table.

    Parameters
    ----------
    marks : Marks
    fit : Fit
    start_height_m : float
        Height of the platform's origin in the first frame, m.
    name : str

    Returns
    -------
    Trajectory
        A frame without a pose is empty.
    """
    channels, sigma = {}, {}
    for k, channel in enumerate(fit.free):
        offset = start_height_m if channel == "z_m" else 0.0
        channels[channel] = np.where(fit.has_pose, fit.pose[:, CHANNELS.index(channel)] + offset, np.nan)
        sigma[channel] = np.sqrt(fit.covariance[:, k, k])
    return Trajectory(marks.time_s, channels, sigma, _status(marks, fit), name=name)


def _status(marks: Marks, fit: Fit) -> list[str]:
    missing, full = np.all(marks.status == MISSING, axis=1), np.all(fit.used, axis=1)
    return [MISSING if missing[t] else LOST if not fit.has_pose[t] else OK if full[t] else PARTIAL for t in range(len(fit.has_pose))]
