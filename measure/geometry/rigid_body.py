"""From marks to the platform: the pose of one rigid body that explains all marks, and its standard deviations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from measure.correlation.marks import LOST, MISSING, OK, Marks
from measure.geometry.body import Body
from measure.geometry.camera import Camera
from measure.geometry.frame_pose import FramePose, fit_frame, weights_of
from measure.geometry.reference_error import Linearised, Offsets, estimate_offsets, share_left
from measure.geometry.roughness import roughness
from measure.tables.trajectory import CHANNELS, Trajectory

Array = NDArray[np.float64]

ONE_MARK = ("x_m", "z_m")
PLANE = ("x_m", "z_m", "theta_y_rad")
CYLINDER = ("x_m", "z_m", "theta_y_rad", "theta_z_rad")
PERSPECTIVE = CHANNELS
"""What can be fitted: with one mark, with several, on a cylinder, and on a cylinder under perspective."""

PARTIAL = "partial"
"""Status of a frame whose pose does not rest on all marks."""

_NOT_RIGID = 10.0
"""Misfit of the marks to the fitted body, in their own standard deviations, from which the geometry is wrong and not the noise."""

_ASTRAY_PX, _ASTRAY_SIGMAS = 0.3, 5.0
"""Distance from the body at which a sighting that was left out of its fit is not of the mark: in px, and in standard deviations."""

_NEAR = 8
"""Frames to each side over which the misfit is taken: what compression and the steps of pixels add comes and goes with the motion."""

_ROUNDS = 3
"""Times that the misfit and the offsets of the reference picture are estimated, each from the other."""


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
        Observed minus fitted positions, px, without the offsets of the reference picture.
    used : (frames, marks) array of bool
        Whether the mark took part in the fit of that frame.
    widened : float
        Factor by which the standard deviations were widened because the marks fit the rigid body less well than their
        own standard deviations say; the median of all frames.
    rough : (k,) array
        Factors by which those of the free channels were widened further because the pose scatters more than they say.
    offset_px : (frames, marks, 2) array
        What the error of the reference picture adds to the observed positions, px; zero where there is no pose.
    mark_covariance_px2 : (frames, marks, 2, 2) array
        Of the observed positions without these offsets, px^2: widened, and with what the marks share.
    """

    free: Sequence[str]
    pose: Array
    covariance: Array
    residual_px: Array
    used: NDArray[np.bool_]
    widened: float
    rough: Array
    offset_px: Array
    mark_covariance_px2: Array

    def __repr__(self) -> str:
        posed = int(self.has_pose.sum())
        return f"Fit({', '.join(self.free)}; a pose in {posed} of {len(self.pose)} frames, sigmas widened {self.widened:.3g}x)"

    @property
    def astray(self) -> NDArray[np.bool_]:
        """(frames, marks): sightings that were left out of the fit and lie clearly beside the body: of something else than the mark."""
        sigma = np.sqrt(0.5 * np.trace(self.mark_covariance_px2, axis1=2, axis2=3))
        beside = np.hypot(self.residual_px[..., 0], self.residual_px[..., 1]) > np.maximum(_ASTRAY_PX, _ASTRAY_SIGMAS * sigma)
        return np.asarray(beside & ~self.used & self.has_pose[:, None])

    @property
    def has_pose(self) -> NDArray[np.bool_]:
        """(frames,): whether the frame has a pose."""
        return np.isfinite(self.covariance[:, 0, 0])

    @property
    def is_rigid(self) -> bool:
        """Whether the misfit of the marks can be their noise; otherwise the geometry is wrong."""
        return self.widened <= _NOT_RIGID

    @property
    def mark_residual_px(self) -> Array:
        """(marks,): root mean square distance of each mark from the fitted body, px; NaN for a mark that took part in no frame."""
        squares = np.where(self.used, (self.residual_px**2).sum(axis=-1), 0.0).sum(axis=0)
        counts = self.used.sum(axis=0)
        return np.sqrt(np.where(counts > 0, squares / np.maximum(counts, 1), np.nan))


def fit_platform(marks: Marks, camera: Camera, points: Array, free: Sequence[str]) -> Fit:
    """Fit the pose of a rigid body to the marks of every frame, by least squares weighted with their covariances.

    A mark that alone makes the others disagree is left out of that frame. What the error of the reference picture adds to
    all later sightings is estimated with the poses.

    Parameters
    ----------
    marks : Marks
    camera : Camera
    points : (marks, 9, 3) array
        On the body, m, from `body_points`.
    free : sequence of str
        The channels to fit.

    Returns
    -------
    Fit
        A frame with too few marks has no pose.
    """
    body = Body(camera, points, marks.response)
    at = [CHANNELS.index(channel) for channel in free]
    found = _fit_frames(body, at, marks)
    posed = np.array([t for t, one in enumerate(found) if one is not None], int)
    fits = [one for one in found if one is not None]
    if not fits:
        return _no_pose(marks, free)
    frames = _linearised(body, marks, posed, fits)
    freedom = np.where(posed > 0, [one.freedom for one in fits], 0)
    offsets, misfit = _offsets_and_misfit(frames, freedom)
    return _put_together(marks, free, posed, fits, frames, offsets, misfit)


def _fit_frames(body: Body, at: list[int], marks: Marks) -> list[FramePose | None]:
    """Every frame by itself, started at the pose of the one before."""
    picture, weights, last = np.stack([marks.x_px, marks.y_px], axis=-1), weights_of(marks), np.zeros(6)
    found: list[FramePose | None] = []
    for t in range(len(picture)):
        one = fit_frame(body, at, picture[t], weights[t], marks.observed[t].copy(), last)
        last = last if one is None else one.pose
        found.append(one)
    return found


def _linearised(body: Body, marks: Marks, posed: NDArray[np.intp], fits: list[FramePose]) -> Linearised:
    """The frames with a pose, about it. A mark that was left out has no weight; one that is not observed is nowhere."""
    used = np.array([one.used for one in fits])
    residual = np.where(marks.observed[posed][..., None], np.array([one.residual for one in fits]), 0.0)
    picture = np.stack([marks.x_px[posed], marks.y_px[posed]], axis=-1)
    left = share_left(np.hypot(*np.moveaxis(picture - marks.reference_px, -1, 0)))
    gone = left.sum(axis=1) > 0.5 * marks.observed[posed].sum(axis=1)
    carried = body.carried(np.array([one.pose for one in fits])) * left[..., None, None]
    weight = weights_of(marks)[posed] * used[..., None, None]
    return Linearised(residual, weight, np.array([one.slopes for one in fits]), carried, gone)


def _offsets_and_misfit(frames: Linearised, freedom: NDArray[np.int64]) -> tuple[Offsets, Array]:
    """The offsets of the reference picture, and chi-square per degree of freedom of each frame without them; NaN where there is none."""
    offsets = Offsets.none(frames.residual.shape[1])
    misfit = _misfit(frames, offsets, freedom)
    for _ in range(_ROUNDS):
        offsets = estimate_offsets(frames, _variance(misfit[frames.gone]))
        misfit = _misfit(frames, offsets, freedom)
    return offsets, misfit


def _misfit(frames: Linearised, offsets: Offsets, freedom: NDArray[np.int64]) -> Array:
    left = _left(frames, offsets)
    square = np.einsum("tni,tnij,tnj->t", left, frames.weight, left)
    return np.where(freedom > 0, square / np.maximum(freedom, 1), np.nan) / _median_of_misfit(np.maximum(freedom, 1))


def _left(frames: Linearised, offsets: Offsets) -> Array:
    """Residuals, (t, n, 2) px, when the offsets are taken off the positions and the poses have followed."""
    followed = np.einsum("tnik,tk->tni", frames.slopes, offsets.on_poses(frames)[0])
    return np.asarray(frames.residual - offsets.on_marks(frames)[0] + followed, float)


def _median_of_misfit(freedom: NDArray[np.int64]) -> Array:
    """Median of chi-square per degree of freedom, by the cube of Wilson and Hilferty (PNAS 17 (1931) 684)."""
    return np.asarray((1.0 - 2.0 / (9.0 * freedom)) ** 3, np.float64)


def _variance(misfit: Array) -> float:
    """Times that the variances of the marks are too small, one at least; misfit : chi-squares, NaN where there is none."""
    known = misfit[np.isfinite(misfit)]
    return max(1.0, float(np.median(known))) if len(known) else 1.0


def _variances(misfit: Array, gone: NDArray[np.bool_]) -> Array:
    """The same for each frame: geometric mean of the factor near it and that of the film, apart for frames at rest and in motion.

    At rest the pictures err alike, so that marks fit each other too well to say anything about later frames.
    """
    variance = np.ones(len(misfit))
    for of in (np.flatnonzero(gone), np.flatnonzero(~gone)):
        among = misfit[of]
        near = [_variance(among[max(0, i - _NEAR) : i + _NEAR + 1]) for i in range(len(of))]
        variance[of] = np.sqrt(np.array(near) * _variance(among))
    return variance


def _put_together(
    marks: Marks,
    free: Sequence[str],
    posed: NDArray[np.intp],
    fits: list[FramePose],
    frames: Linearised,
    offsets: Offsets,
    misfit: Array,
) -> Fit:
    """Poses without the offsets, and all that is uncertain about them."""
    at = [CHANNELS.index(channel) for channel in free]
    fit = _no_pose(marks, free)
    change, unknown = offsets.on_poses(frames)
    fit.pose[posed] = [one.pose for one in fits]
    fit.pose[posed[:, None], at] -= change
    variance = _variances(misfit, frames.gone)
    own = np.full_like(fit.covariance, np.nan)
    own[posed] = frames.covariance * variance[:, None, None]
    sigma = np.sqrt(np.diagonal(own, axis1=1, axis2=2))
    rough = np.array([roughness(fit.pose[:, channel], sigma[:, k]) for k, channel in enumerate(at)])
    pose_covariance = own[posed] + unknown
    fit.covariance[posed] = pose_covariance * np.outer(rough, rough)
    fit.used[posed] = [one.used for one in fits]
    fit.residual_px[posed] = np.where(marks.observed[posed][..., None], _left(frames, offsets), np.nan)
    shift, spread = offsets.on_marks(frames)
    more = np.sqrt(rough**2 - 1.0)
    shared = np.einsum("tnik,tkl,tnjl->tnij", frames.slopes * more, pose_covariance, frames.slopes * more)
    fit.offset_px[posed] = shift
    fit.mark_covariance_px2[:] *= np.median(variance)
    fit.mark_covariance_px2[posed] = marks.covariance_px2[posed] * variance[:, None, None, None] + spread + shared
    return replace(fit, widened=float(np.sqrt(np.median(variance))), rough=rough)


def _no_pose(marks: Marks, free: Sequence[str]) -> Fit:
    """No frame has a pose."""
    frames, count = marks.x_px.shape
    k = len(free)
    return Fit(
        free,
        pose=np.full((frames, 6), np.nan),
        covariance=np.full((frames, k, k), np.nan),
        residual_px=np.full((frames, count, 2), np.nan),
        used=np.zeros((frames, count), bool),
        widened=1.0,
        rough=np.ones(k),
        offset_px=np.zeros((frames, count, 2)),
        mark_covariance_px2=marks.covariance_px2.copy(),
    )


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
