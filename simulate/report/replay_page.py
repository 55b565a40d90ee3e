"""A page that plays a deployment in three dimensions with its curves in step: one HTML file, no outside address."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from measure.tables.trajectory import CHANNELS, Trajectory
from simulate.deployment.result import Deployment
from simulate.kernel.layout import SAMPLE_POSE
from simulate.kernel.model_rows import quaternion_of
from simulate.model.rig import LEGS, geometry_of

_PAGE = Path(__file__).with_name("replay.html.j2")
_MOST_FRAMES = 400
Frames = NDArray[np.intp]
_PANELS = {
    "elevation, mm": (("z_m",), 1e3, 1.0),
    "lateral, mm": (("x_m", "y_m"), 1e3, 1.0),
    "rotation, deg": (("theta_x_rad", "theta_y_rad", "theta_z_rad"), 180.0 / np.pi, 1.0),
}


def playing_html(run: Deployment, measured: Trajectory | None = None, *, orange: str = "", above: str = "") -> str:
    """The whole page; a measured trajectory is laid over the modelled one, in the curves and in space.

    Parameters
    ----------
    orange : what that trajectory is, where it was not measured. above : HTML that stands above, escaped already.
    """
    from jinja2 import Environment

    data = json.dumps(_data(run, measured), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    page = Environment(autoescape=True).from_string(_PAGE.read_text(encoding="utf-8"))
    return page.render(title=f"{run.model.name}, {run.time_s[-1]:.2f} s", data=data, orange=orange or _measured(measured), above=above)


def _measured(measured: Trajectory | None) -> str:
    return f"measured ({measured.name}); what was not measured is drawn as modelled" if measured else ""


def _data(run: Deployment, measured: Trajectory | None) -> dict[str, Any]:
    kept = np.unique(np.linspace(0, len(run.time_s) - 1, min(_MOST_FRAMES, len(run.time_s))).astype(np.intp))
    g = geometry_of(run.model)
    pose = run.samples[kept, SAMPLE_POSE : SAMPLE_POSE + 7]
    lengths = np.column_stack([run.leg_columns[f"length_{leg + 1}_m"] for leg in range(LEGS)])[kept]
    return {
        "time": _plain(run.time_s[kept]),
        "place": _plain(pose[:, :3]),
        "quaternion": _plain(pose[:, 3:]),
        "force": _plain(run.leg_force_N[kept]),
        "length": _plain(lengths),
        "base": [list(p) for p in g.base_joints_m],
        "joints": [list(p) for p in g.platform_joints_m],
        "stowed": g.stowed_height_m,
        "middle": g.deployed_height_m / 2,
        "size": float(max(np.max(np.abs(g.base_joints_m)), g.deployed_height_m / 2)),
        "panels": [*(_panel(run, kept, name, measured) for name in _PANELS), _forces(run, kept)],
        "measured": None if measured is None else _seen(run, kept, measured),
    }


def _panel(run: Deployment, kept: Frames, unit: str, measured: Trajectory | None) -> dict[str, Any]:
    names, factor, least = _PANELS[unit]
    return {"unit": unit, "least": least, "lines": [_line(run, kept, name, factor, measured) for name in names]}


def _line(run: Deployment, kept: Frames, name: str, factor: float, measured: Trajectory | None) -> dict[str, Any]:
    line = {"name": name.rsplit("_", 1)[0], "values": _plain(factor * run.channels[name][kept])}
    if measured is not None and name in measured.channels:
        within = measured.time_s <= run.time_s[-1]
        line["measured"] = {"time": _plain(measured.time_s[within]), "values": _plain(factor * measured.channels[name][within])}
    return line


def _forces(run: Deployment, kept: Frames) -> dict[str, Any]:
    lines = [{"name": f"leg {leg + 1}", "values": _plain(run.leg_force_N[kept, leg])} for leg in range(LEGS)]
    return {"unit": "force, N", "least": 0.1, "lines": lines}


def _seen(run: Deployment, kept: Frames, measured: Trajectory) -> dict[str, Any]:
    """Measured poses at the frames of the page, null outside the measurement; channels that were not measured are as modelled."""
    time = run.time_s[kept]
    columns = []
    for name in CHANNELS:
        values = measured.channels.get(name, np.full(len(measured.time_s), np.nan))
        good = np.isfinite(values)
        columns.append(np.interp(time, measured.time_s[good], values[good]) if good.any() else run.channels[name][kept])
    pose = np.column_stack(columns)
    outside = (time < measured.time_s[0]) | (time > measured.time_s[-1]) | ~np.isfinite(pose).all(axis=1)
    places = [None if gone else row for gone, row in zip(outside, _plain(pose[:, :3]), strict=True)]
    return {"place": places, "quaternion": _plain(np.array([_turned(*row) for row in pose[:, 3:]]))}


def _turned(theta_x: float, theta_y: float, theta_z: float) -> Array:
    """Quaternion of swing and twist: first the rotation about the vertical, then the tilt."""
    w, x, y, _ = quaternion_of(np.array([theta_x, theta_y, 0.0]))
    c, s = np.cos(theta_z / 2), np.sin(theta_z / 2)
    return np.array([w * c, x * c + y * s, y * c - x * s, w * s])


def _plain(values: Array) -> Sequence[Any]:
    """Lists of numbers of six digits; what is not finite is null."""
    return [_plain(row) for row in values] if values.ndim > 1 else [float(f"{v:.6g}") if np.isfinite(v) else None for v in values]
