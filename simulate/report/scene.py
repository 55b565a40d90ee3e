"""Deployments as data of the scene that plays them in space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from measure.tables.trajectory import CHANNELS, Trajectory
from simulate.deployment.result import Deployment
from simulate.kernel.layout import SAMPLE_POSE
from simulate.kernel.model_rows import quaternion_of
from simulate.model.rig import LEGS, geometry_of

Frames = NDArray[np.intp]
_DIGITS = 6


def scene_of(
    runs: Mapping[str, Deployment],
    colours: Sequence[str],
    measured: Trajectory | None = None,
    *,
    frames: int = 200,
    link: str = "",
    begin_s: float = 0.0,
    legs: bool = False,
) -> dict[str, Any]:
    """What the scene's script reads.

    Parameters
    ----------
    runs : deployments of one rig over the same times, by what they are called; the last is shown first.
    colours : of the stylesheet, `--effect`, one a run.
    measured : on the clock of the deployments; laid over them.
    link, begin_s : figures whose cursor moves the scene, and what their clock shows at the release.
    legs : whether lengths and forces stand below.
    """
    first = next(iter(runs.values()))
    kept = kept_frames(first, frames)
    g = geometry_of(first.model)
    return {
        "time": plain(first.time_s[kept]),
        "models": [
            {"name": name, "colour": colour, **_moves(run, kept)} for (name, run), colour in zip(runs.items(), colours, strict=True)
        ],
        "lengths": plain(lengths_of(first)[kept]) if legs else None,
        "base": [list(p) for p in g.base_joints_m],
        "joints": [list(p) for p in g.platform_joints_m],
        "stowed": g.stowed_height_m,
        "middle": g.deployed_height_m / 2,
        "size": float(max(np.max(np.abs(g.base_joints_m)), g.deployed_height_m / 2)),
        "measured": None if measured is None else seen(first, kept, measured),
        "link": link,
        "begin": begin_s,
        "shown": float(first.time_s[len(first.time_s) // 2]),
    }


def kept_frames(run: Deployment, most: int) -> Frames:
    """Places of at most so many frames, evenly over a deployment."""
    return np.unique(np.linspace(0, len(run.time_s) - 1, min(most, len(run.time_s))).astype(np.intp))


def _moves(run: Deployment, kept: Frames) -> dict[str, Any]:
    pose = run.samples[kept, SAMPLE_POSE : SAMPLE_POSE + 7]
    return {"place": plain(pose[:, :3]), "quaternion": plain(pose[:, 3:]), "force": plain(run.leg_force_N[kept])}


def lengths_of(run: Deployment) -> Array:
    """Length of each leg, m, (n, 6)."""
    return np.column_stack([run.leg_columns[f"length_{leg + 1}_m"] for leg in range(LEGS)])


def seen(run: Deployment, kept: Frames, measured: Trajectory) -> dict[str, Any]:
    """Measured poses at these frames, null outside the measurement; channels that were not measured are as modelled."""
    time = run.time_s[kept]
    columns = []
    for name in CHANNELS:
        values = measured.channels.get(name, np.full(len(measured.time_s), np.nan))
        good = np.isfinite(values)
        columns.append(np.interp(time, measured.time_s[good], values[good]) if good.any() else run.channels[name][kept])
    pose = np.column_stack(columns)
    outside = (time < measured.time_s[0]) | (time > measured.time_s[-1]) | ~np.isfinite(pose).all(axis=1)
    places = [None if gone else row for gone, row in zip(outside, plain(pose[:, :3]), strict=True)]
    return {"place": places, "quaternion": plain(np.array([_turned(*row) for row in pose[:, 3:]]))}


def _turned(theta_x: float, theta_y: float, theta_z: float) -> Array:
    """Quaternion of swing and twist: first the rotation about the vertical, then the tilt."""
    w, x, y, _ = quaternion_of(np.array([theta_x, theta_y, 0.0]))
    c, s = np.cos(theta_z / 2), np.sin(theta_z / 2)
    return np.array([w * c, x * c + y * s, y * c - x * s, w * s])


def plain(values: Array) -> Sequence[Any]:
    """Lists of numbers of a few digits; what is not finite is null."""
    return [plain(row) for row in values] if values.ndim > 1 else [float(f"{v:.{_DIGITS}g}") if np.isfinite(v) else None for v in values]
