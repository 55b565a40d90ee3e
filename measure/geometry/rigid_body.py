"""From marks to the platform: one rigid body that explains all of them, and how surely."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.curved_marks import Response
from measure.correlation.marks import LOST, MISSING, OK, Marks
from measure.geometry.camera import Camera, on_cylinder, rotation
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
_STEP = 1e-5
_DISAGREE = 10.0
_CULPRIT = 0.2
_OUTLIER_PX = 0.1


@dataclass(frozen=True)
class Fit:
    """The pose of every frame.

    free : the channels that were fitted. pose : (frames, 6) in the order of `CHANNELS`, what is not free is zero.
    covariance : (frames, k, k) of the free ones. residual_px : (frames, marks, 2), seen minus fitted. used : (frames, marks).
    widened : factor by which the standard deviations were widened because the marks fit the rigid body less well than
    their own sigmas promise.
    """

    free: Sequence[str]
    pose: Array
    covariance: Array
    residual_px: Array
    used: NDArray[np.bool_]
    widened: float

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(frames,): whether the frame has a pose."""
        return np.isfinite(self.covariance[:, 0, 0])


def body_points(marks: Marks, camera: Camera, radius_m: float | None) -> Array:
    """Where the nodes of the marks sit on the platform, relative to its origin in the first frame; (marks, 9, 3), m.

    On a cylinder of known radius about the vertical through the origin, or else all at the origin's depth.

    Raises
    ------
    InputError
        A mark beside the cylinder.
    """
    picture = marks.response.nodes_px
    if radius_m is None:
        return camera.place(picture, np.zeros(picture.shape[:2]))
    points = on_cylinder(camera, picture, radius_m)
    beside = np.isnan(points[..., 0]).any(axis=1)
    if beside.any():
        which = int(np.argmax(beside))
        raise InputError(
            f"mark {marks.names[which]} at {marks.reference_px[which, 0]:g},{marks.reference_px[which, 1]:g}: its subset reaches beside "
            f"the cylinder of {1000 * radius_m:g} mm radius about {camera.origin_px[0]:g},{camera.origin_px[1]:g}. "
            "Check radius_m, origin_px, the scale and the subset."
        )
    return points


@dataclass(frozen=True)
class Body:
    """The platform as the camera sees it. points : (marks, 9, 3), m, from `body_points`."""

    camera: Camera
    points: Array
    response: Response

    def seen(self, poses: Array) -> Array:
        """Places of the marks in the picture under poses (..., 6). Returns (..., marks, 2), px."""
        world = np.einsum("...ij,nqj->...nqi", rotation(poses[..., 3:]), self.points) + poses[..., None, None, :3]
        return self.response.apparent(self.camera.project(world))

    def slopes(self, pose: Array, at: list[int]) -> tuple[Array, Array]:
        """Places under a pose (6,), and their slopes along the channels `at`: (marks, 2), (marks, 2, k)."""
        steps = _STEP * np.eye(6)[at]
        places = self.seen(np.concatenate([pose[None], pose + steps, pose - steps]))
        ahead, behind = places[1 : 1 + len(at)], places[1 + len(at) :]
        return places[0], np.moveaxis((ahead - behind) / (2 * _STEP), 0, -1)


def fit_platform(marks: Marks, camera: Camera, points: Array, free: Sequence[str]) -> Fit:
    """Fit the pose of a rigid body to the marks of every frame, weighted by their covariances, outliers left out.

    points : (marks, 9, 3) on the body, from `body_points`. free : the channels to fit. A frame with
    too few marks has no pose.
    """
    body = Body(camera, points, marks.response)
    frames, count = marks.x_px.shape
    at = [CHANNELS.index(channel) for channel in free]
    picture = np.stack([marks.x_px, marks.y_px], axis=-1)
    pose, covariance = np.zeros((frames, 6)), np.full((frames, len(at), len(at)), np.nan)
    residual, used = np.full((frames, count, 2), np.nan), np.zeros((frames, count), bool)
    misfit, last = [], np.zeros(6)
    weights = _weights(marks)
    for t in range(frames):
        kept = marks.seen[t].copy()
        found = _fit_frame(body, at, picture[t], weights[t], kept, last)
        if found is None:
            pose[t] = np.nan
            continue
        last, covariance[t], residual[t], used[t], ratio = found
        pose[t] = last
        if t > 0 and np.isfinite(ratio):
            misfit.append(ratio)
    widened = float(np.sqrt(max(1.0, np.median(misfit)))) if misfit else 1.0
    return Fit(free, pose, covariance * widened**2, residual, used, widened)


def _weights(marks: Marks) -> Array:
    """Inverse covariances of the marks, (frames, marks, 2, 2); zero where there is no position."""
    covariance = np.where(marks.seen[..., None, None], marks.covariance_px2, np.eye(2)) + _MODEL_ERROR_PX**2 * np.eye(2)
    return np.asarray(np.linalg.inv(covariance) * marks.seen[..., None, None], float)


def _fit_frame(body: Body, at: list[int], picture: Array, weights: Array, kept: NDArray[np.bool_], start: Array):
    """One frame. While the marks disagree and one of them alone explains it, that mark is left out.

    Returns pose, covariance, residuals, marks used, misfit (chi-square per degree of freedom); None without a pose.
    """

    def solve(kept: NDArray[np.bool_]):
        freedom = 2 * int(kept.sum()) - len(at)
        solved = _solve(body, at, picture, weights, kept, start) if freedom >= 0 and kept.sum() >= (2 if len(at) > 2 else 1) else None
        if solved is None:
            return None
        misfit = np.einsum("ni,nij,nj->", solved[2][kept], weights[kept], solved[2][kept]) / freedom if freedom else np.nan
        return *solved, kept, misfit

    found = solve(kept)
    while found is not None and found[4] > _DISAGREE and np.abs(found[2][kept]).max() > _OUTLIER_PX and 2 * kept.sum() - len(at) >= 3:
        without = [solve(kept & (np.arange(len(kept)) != i)) for i in np.flatnonzero(kept)]
        best = min((other for other in without if other is not None), key=lambda other: other[4], default=None)
        if best is None or not best[4] < _CULPRIT * found[4]:
            break
        found, kept = best, best[3]
    return found


def _solve(body: Body, at: list[int], picture: Array, weights: Array, kept: NDArray[np.bool_], start: Array):
    """Gauss-Newton on the pose: minimise sum r' C^-1 r, r = seen - projected. Returns pose, covariance, residuals."""
    pose = start.copy()
    for _ in range(30):
        projected, slopes = body.slopes(pose, at)
        residual = picture - projected
        j, r, w = slopes[kept], residual[kept], weights[kept]
        normal = np.einsum("nik,nij,njl->kl", j, w, j)
        if not np.isfinite(normal).all() or np.linalg.cond(normal) > 1e16:
            return None
        covariance = np.linalg.inv(normal)
        step = covariance @ np.einsum("nik,nij,nj->k", j, w, r)
        pose[at] += step
        if (np.abs(step) < 1e-4 * np.sqrt(np.diag(covariance))).all():
            return pose, covariance, picture - body.seen(pose)
    return None


def trajectory(marks: Marks, fit: Fit, start_height_m: float, name: str = "trajectory") -> Trajectory:
    """The platform's motion as a table; a frame without a pose is empty.

    start_height_m : height of the platform's origin in the first frame, in the world of the model.
    """
    channels, sigma = {}, {}
    for k, channel in enumerate(fit.free):
        offset = start_height_m if channel == "z_m" else 0.0
        channels[channel] = np.where(fit.seen, fit.pose[:, CHANNELS.index(channel)] + offset, np.nan)
        sigma[channel] = np.sqrt(fit.covariance[:, k, k])
    return Trajectory(marks.time_s, channels, sigma, _status(marks, fit), name=name)


def _status(marks: Marks, fit: Fit) -> list[str]:
    missing, full = np.all(marks.status == MISSING, axis=1), np.all(fit.used, axis=1)
    return [MISSING if missing[t] else LOST if not fit.seen[t] else OK if full[t] else PARTIAL for t in range(len(fit.seen))]
