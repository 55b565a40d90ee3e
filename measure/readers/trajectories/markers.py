"""Markers in space as motion capture writes them, and the platform's trajectory out of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, OptionsMissing, clipped, nearest
from measure.geometry.marker_body import FEWEST_MARKERS, BodyMotion, body_motion, width_to_length
from measure.readers.column_mapping import ColumnMapping
from measure.tables.checks import listed
from measure.tables.trajectory import CHANNELS, Trajectory
from measure.tables.units import unit_of

_OK, _PARTIAL, _LOST = "ok", "partial", "lost"
_NOT_RIGID = 0.02  # root mean square misfit as a part of the body's size from which the markers are not on one body,
_NOT_NOISE = 5.0  # where it is also so many times what changes from frame to frame
_FINEST = 1e-9  # m or rad; below, there is no noise, and so no sigma
_ACROSS = {"x": "y", "y": "x", "z": "x"}  # what becomes x_m where nobody says, by the axis that points up


@dataclass(frozen=True)
class Markers:
    """What a file of markers holds.

    time_s : (frames,). names : of the markers. position : (frames, markers, 3) in the file's unit and axes, NaN where not seen.
    unit : of the positions as the file has it, or empty. up, across : the axes that the file names for these directions, or None.
    """

    path: Path
    time_s: Array
    names: tuple[str, ...]
    position: Array
    unit: str = ""
    up: str | None = None
    across: str | None = None


def trajectory_of_markers(markers: Markers, wanted: ColumnMapping) -> Trajectory:
    """The platform's motion against the first frame in which it is seen: of one marker its positions, of three or more the body's pose.

    Raises
    ------
    InputError
        Unknown markers, two of them, markers on one line or not on one body, nothing that says which axis is up or what the unit is.
    """
    position = _chosen(markers, wanted.markers) * _factor(markers, wanted) @ _axes(markers, wanted).T
    names = tuple(wanted.markers) or markers.names
    if len(names) == 1:
        return _of_one(markers, position[:, 0])
    motion = body_motion(position)
    if motion is None:
        raise InputError(_no_body(markers.path, names, position))
    _require_rigid(markers.path, names, motion)
    status = np.where(motion.has_pose, np.where(motion.used.all(axis=1), _OK, _PARTIAL), _LOST)
    return _made(markers, motion.pose, CHANNELS, status, motion.sigma)


def _chosen(markers: Markers, wanted: Sequence[str]) -> Array:
    """Positions of the markers that were named, or of all."""
    unknown = [name for name in wanted if name not in markers.names]
    if unknown:
        raise InputError(
            "\n".join(f'{markers.path}: no marker "{clipped(name)}"; {nearest(name, markers.names)}' for name in unknown)
            + f" It holds {listed(markers.names)}."
        )
    count = len(wanted or markers.names)
    if count == 2:
        raise InputError(
            f"{markers.path}: two markers fix no rotation. Name one with --markers for its positions alone, or {FEWEST_MARKERS} or more "
            f"for the pose of the platform; it holds {listed(markers.names)}."
        )
    places = [markers.names.index(name) for name in wanted] if wanted else slice(None)
    return markers.position[:, places]


def _factor(markers: Markers, wanted: ColumnMapping) -> float:
    text = str(wanted.units.get("position", "")) or markers.unit
    if not text:
        raise OptionsMissing(
            f"{markers.path}: does not say in what unit its markers are. Add --unit position=mm, or what it is.", "--unit position=UNIT"
        )
    try:
        return unit_of("position", text).factor
    except InputError as error:
        raise InputError(f"{markers.path}: {error}") from None


def _axes(markers: Markers, wanted: ColumnMapping) -> Array:
    """(3, 3): x across the view, y away from the viewer and z up, each in the axes of the file."""
    up = wanted.up or markers.up
    if up is None:
        raise OptionsMissing(
            f"{markers.path}: does not say which of its axes points up. Add --up z or --up y; --up=-z where it points down.", "--up AXIS"
        )
    across = wanted.across or markers.across
    if across is None or (wanted.across is None and across[-1] == up[-1]):
        across = _ACROSS[up[-1]]
    if across[-1] == up[-1]:
        raise InputError(f"--across {across} and --up {up} are one axis. Give two that stand at right angles.")
    x, z = _direction(across), _direction(up)
    return np.stack([x, np.cross(z, x), z])


def _direction(axis: str) -> Array:
    return np.eye(3)["xyz".index(axis[-1])] * (-1.0 if axis[0] == "-" else 1.0)


def _of_one(markers: Markers, position: Array) -> Trajectory:
    seen = np.all(np.isfinite(position), axis=1)
    if not seen.any():
        raise InputError(f"{markers.path}: the marker is seen in no frame. Name another one with --markers.")
    moved = np.where(seen[:, None], position - position[np.argmax(seen)], np.nan)
    return _made(markers, moved, CHANNELS[:3], np.where(seen, _OK, _LOST))


def _made(markers: Markers, values: Array, channels: Sequence[str], status: Array, sigma: Array | None = None) -> Trajectory:
    """The table from the first frame on in which the platform is seen; what is missing later are rows without values."""
    rows = slice(int(np.argmax(np.isfinite(values[:, 0]))), None)
    known = {} if sigma is None or not np.isfinite(sigma[rows]).any() else dict(zip(channels, sigma[rows].T, strict=True))
    spread = {name: column for name, column in known.items() if np.nanmax(column) > _FINEST}
    seen = dict(zip(channels, values[rows].T, strict=True))
    return Trajectory(markers.time_s[rows], seen, spread, status[rows].tolist(), name=str(markers.path))


def _no_body(path: Path, names: Sequence[str], position: Array) -> str:
    seen = np.isfinite(position).all(axis=2)
    most = int(seen.sum(axis=1).max(initial=0))
    if most < FEWEST_MARKERS:
        return f"{path}: at most {most} of {listed(names)} are seen in one frame, and a pose needs {FEWEST_MARKERS}. Name others."
    fullest = position[np.argmax(seen.sum(axis=1))]
    thin = width_to_length(fullest[np.isfinite(fullest).all(axis=1)])
    return (
        f"{path}: {listed(names)} lie on one line (its width is {thin:.1g} of its length), so that a rotation about it is not seen. "
        "Name a marker beside it, or one marker for its positions alone."
    )


def _require_rigid(path: Path, names: Sequence[str], motion: BodyMotion) -> None:
    misfit = float(np.sqrt(np.mean(motion.residual_m[motion.used.any(axis=0)] ** 2)))
    if misfit > _NOT_RIGID * motion.size_m and misfit > _NOT_NOISE * motion.noise_m:
        worst = int(np.argmax(motion.residual_m))
        raise InputError(
            f"{path}: {listed(names)} do not move as one body: they miss it by {1e3 * misfit:.3g} mm, {clipped(names[worst], 40)} by "
            f"{1e3 * motion.residual_m[worst]:.3g} mm. Name those that are on the platform with --markers A,B,C."
        )
