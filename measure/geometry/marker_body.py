"""From markers in space to the platform: the pose of the one rigid body that carries them, frame by frame, and its standard deviations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from measure.geometry.camera import angles

Array = NDArray[np.float64]

FEWEST_MARKERS = 3
_MOST_PASSES = 50
_SETTLED = 1e-9  # of the body's size, from pass to pass
_ON_A_LINE = 1e-3  # width of the body as a part of its length, below which it is a line
_TURN_RAD = 1e-5  # step of the central differences
_AT_ONCE = 10_000  # frames


@dataclass(frozen=True)
class BodyMotion:
    """The motion of a rigid body against the first frame in which it has a pose.

    pose : (frames, 6) x, y, z of the markers' centroid and theta_x, theta_y, theta_z, m and rad; NaN in a frame with fewer than three
        markers. sigma : (frames, 6) one standard deviation; NaN where three markers in one frame are all there is.
    used : (frames, markers) whether a marker took part. residual_m : (markers,) root mean square distance from the body, m.
    noise_m : the same for all markers, of what changes from frame to frame alone: a body that is none is off by much more.
    size_m : root mean square distance of the markers from their centroid, m.
    """

    pose: Array
    sigma: Array
    used: NDArray[np.bool_]
    residual_m: Array
    noise_m: float
    size_m: float

    @property
    def has_pose(self) -> NDArray[np.bool_]:
        """(frames,): whether the frame has a pose."""
        return np.isfinite(self.pose[:, 0])


def width_to_length(points: Array) -> float:
    """How far points (markers, 3) are from lying on one line: the second extent over the first, zero on a line."""
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(extents[1] / extents[0]) if extents[0] > 0.0 else 0.0


def body_motion(points: Array) -> BodyMotion | None:
    """Fit one rigid body to markers by least squares: its shape from all frames, its pose in each.

        minimise sum over frames k and markers i seen there of |p_ik - R_k s_i - t_k|^2

    Parameters
    ----------
    points : (frames, markers, 3) array
        Positions with z up, m; NaN where a marker was not seen.

    Returns
    -------
    BodyMotion, or None
        None where no frame shows three markers that are not on one line. Source: S. Umeyama, Least-squares estimation of
        transformation parameters between two point patterns, IEEE Trans. PAMI 13 (1991) 376, for each frame.
    """
    seen = np.all(np.isfinite(points), axis=2)
    place = np.where(seen[..., None], points, 0.0)
    shape, used = _shape(place, seen)
    posed = np.any(used, axis=1)
    if not posed.any():
        return None
    shape, turns, shifts = _against_first(shape, *_poses(place, used, shape), int(np.argmax(posed)))
    known = np.nan_to_num(shape)
    residual = np.where(used[..., None], place - np.einsum("kij,mj->kmi", turns, known) - shifts[:, None], 0.0)
    noise = _noise(residual, used)
    pose, sigma = np.full((2, len(points), 6), np.nan)
    pose[posed] = np.hstack([shifts[posed] - shifts[posed][0], angles(turns[posed])])
    pose[posed, 5] = np.unwrap(pose[posed, 5])
    sigma[posed] = noise * np.concatenate(list(_spreads(turns[posed], used[posed], known)))
    squares = np.sum(residual**2, axis=(0, 2)) / np.maximum(used.sum(axis=0), 1)
    size = float(np.sqrt(np.nanmean(np.nansum(shape**2, axis=1))))
    return BodyMotion(pose, sigma, used, np.sqrt(squares), _from_frame_to_frame(residual, used), size)


def _against_first(shape: Array, turns: Array, shifts: Array, first: int) -> tuple[Array, Array, Array]:
    """Shape about its centroid and turned as in the first frame, with the rotations and shifts that belong to it."""
    centre = np.nanmean(shape, axis=0)
    return (shape - centre) @ turns[first].T, turns @ turns[first].T, shifts + turns @ centre


def _noise(residual: Array, used: NDArray[np.bool_]) -> float:
    """Standard deviation of a coordinate of a marker, m; NaN where shape and poses take up all that was measured."""
    of_shape, of_poses = 3 * np.any(used, axis=0).sum() - 6, 6 * np.any(used, axis=1).sum()
    freedom = 3 * used.sum() - of_poses - of_shape
    return float(np.sqrt(np.sum(residual**2) / freedom)) if freedom > 0 else np.nan


def _from_frame_to_frame(residual: Array, used: NDArray[np.bool_]) -> float:
    """Root mean square length of the change of the residuals between neighbouring frames, over the square root of two."""
    both = used[1:] & used[:-1]
    changes = np.diff(residual, axis=0)[both]
    return float(np.sqrt(np.mean(np.sum(changes**2, axis=1)) / 2.0)) if len(changes) else np.inf


def _shape(place: Array, seen: NDArray[np.bool_]) -> tuple[Array, NDArray[np.bool_]]:
    """The body's shape (markers, 3), NaN for a marker that is never seen beside three others, and what of each frame is used."""
    shape = np.full(place.shape[1:], np.nan)
    fullest = int(np.argmax(np.where(_spanning(place, seen), np.sum(seen, axis=1), -1)))
    shape[seen[fullest]] = place[fullest, seen[fullest]]
    used = np.zeros_like(seen)
    for _ in range(_MOST_PASSES):
        known = np.isfinite(shape[:, 0])
        used = seen & known
        used &= _spanning(place, used)[:, None]
        posed = np.any(used, axis=1)
        if not posed.any():
            break
        turns, shifts = _poses(place, used, shape)
        back = np.einsum("kji,kmj->kmi", turns, place - shifts[:, None])
        counted = seen & posed[:, None]
        total = np.where(counted[..., None], back, 0.0).sum(axis=0)
        better = np.where(counted.any(axis=0)[:, None], total / np.maximum(counted.sum(axis=0), 1)[:, None], np.nan)
        moved = np.nanmax(np.abs(better - shape)) if np.isfinite(better).all(axis=1).sum() == known.sum() else np.inf
        shape = better
        if moved <= _SETTLED * np.nanmax(np.abs(shape)):
            break
    return shape, used


def _spanning(place: Array, used: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(frames,): whether the markers that are used there are three or more, and not on one line."""
    offsets = np.where(used[..., None], place - _mean(place, used)[:, None], 0.0)
    extents = np.linalg.svd(offsets, compute_uv=False) if place.shape[1] > 1 else np.zeros((len(place), 2))
    return (used.sum(axis=1) >= FEWEST_MARKERS) & (extents[:, 1] > _ON_A_LINE * extents[:, 0])


def _mean(place: Array, used: NDArray[np.bool_]) -> Array:
    return np.where(used[..., None], place, 0.0).sum(axis=1) / np.maximum(used.sum(axis=1), 1)[:, None]


def _poses(place: Array, used: NDArray[np.bool_], shape: Array) -> tuple[Array, Array]:
    """Rotations (frames, 3, 3) and shifts (frames, 3) that bring the shape nearest to the markers that are used."""
    body = np.broadcast_to(np.nan_to_num(shape), place.shape)
    here, there = _mean(body, used), _mean(place, used)
    products = np.einsum("km,kmi,kmj->kij", used.astype(float), body - here[:, None], place - there[:, None])
    u, _, vt = np.linalg.svd(products)
    turned = np.linalg.det(np.einsum("kij,kjl->kil", u, vt))
    v = np.swapaxes(vt, 1, 2) * np.stack([np.ones_like(turned), np.ones_like(turned), turned], axis=1)[:, None]
    turns = v @ np.swapaxes(u, 1, 2)
    return turns, there - np.einsum("kij,kj->ki", turns, here)


def _spreads(turns: Array, used: NDArray[np.bool_], shape: Array) -> Iterator[Array]:
    """Standard deviations (frames, 6) of the poses for markers with one of one metre, some frames at a time.

    The normal matrix of shift and rotation vector d, p = R s + t + d x R s, goes on to the angles with their derivatives to d.
    """
    for first in range(0, len(turns), _AT_ONCE):
        turn, part = turns[first : first + _AT_ONCE], used[first : first + _AT_ONCE]
        arms = np.einsum("kij,mj->kmi", turn, shape)
        slopes = np.zeros((*arms.shape, 6))
        slopes[..., :3] = np.eye(3)
        slopes[..., 3:] = -_cross(arms)
        normal = np.einsum("km,kmia,kmib->kab", part.astype(float), slopes, slopes)
        covariance = np.linalg.inv(normal)
        to_angles = _angle_slopes(turn)
        of_angles = np.einsum("kab,kbc,kdc->kad", to_angles, covariance[:, 3:, 3:], to_angles)
        yield np.sqrt(np.concatenate([np.diagonal(c, axis1=1, axis2=2) for c in (covariance[:, :3, :3], of_angles)], axis=1))


def _cross(vectors: Array) -> Array:
    """(..., 3, 3) matrices that take a vector to its cross product with these (..., 3)."""
    made = np.zeros((*vectors.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        made[..., i, j], made[..., j, i] = -vectors[..., k], vectors[..., k]
    return made


def _angle_slopes(turns: Array) -> Array:
    """(frames, 3, 3) derivatives of the angles to a small rotation about the world's axes."""
    from scipy.spatial.transform import Rotation

    columns = []
    for axis in np.eye(3):
        ahead, behind = (angles(Rotation.from_rotvec(sign * _TURN_RAD * axis).as_matrix() @ turns) for sign in (1.0, -1.0))
        step = ahead - behind
        step[:, 2] -= 2.0 * np.pi * np.round(step[:, 2] / (2.0 * np.pi))
        columns.append(step / (2.0 * _TURN_RAD))
    return np.stack(columns, axis=-1)
