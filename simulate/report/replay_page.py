"""A page that plays a deployment in three dimensions with its curves in step: one HTML file, no outside address."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from measure.tables.trajectory import Trajectory
from simulate.deployment.result import Deployment
from simulate.kernel.layout import SAMPLE_POSE
from simulate.model.rig import LEGS, geometry_of
from simulate.report.scene import Frames, kept_frames, lengths_of, plain, seen

_PAGE = Path(__file__).with_name("replay.html.j2")
_MOST_FRAMES = 400
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
    kept = kept_frames(run, _MOST_FRAMES)
    g = geometry_of(run.model)
    pose = run.samples[kept, SAMPLE_POSE : SAMPLE_POSE + 7]
    return {
        "time": plain(run.time_s[kept]),
        "place": plain(pose[:, :3]),
        "quaternion": plain(pose[:, 3:]),
        "force": plain(run.leg_force_N[kept]),
        "length": plain(lengths_of(run)[kept]),
        "base": [list(p) for p in g.base_joints_m],
        "joints": [list(p) for p in g.platform_joints_m],
        "stowed": g.stowed_height_m,
        "middle": g.deployed_height_m / 2,
        "size": float(max(np.max(np.abs(g.base_joints_m)), g.deployed_height_m / 2)),
        "panels": [*(_panel(run, kept, name, measured) for name in _PANELS), _forces(run, kept)],
        "measured": None if measured is None else seen(run, kept, measured),
    }


def _panel(run: Deployment, kept: Frames, unit: str, measured: Trajectory | None) -> dict[str, Any]:
    names, factor, least = _PANELS[unit]
    return {"unit": unit, "least": least, "lines": [_line(run, kept, name, factor, measured) for name in names]}


def _line(run: Deployment, kept: Frames, name: str, factor: float, measured: Trajectory | None) -> dict[str, Any]:
    line = {"name": name.rsplit("_", 1)[0], "values": plain(factor * run.channels[name][kept])}
    if measured is not None and name in measured.channels:
        within = measured.time_s <= run.time_s[-1]
        line["measured"] = {"time": plain(measured.time_s[within]), "values": plain(factor * measured.channels[name][within])}
    return line


def _forces(run: Deployment, kept: Frames) -> dict[str, Any]:
    lines = [{"name": f"leg {leg + 1}", "values": plain(run.leg_force_N[kept, leg])} for leg in range(LEGS)]
    return {"unit": "force, N", "least": 0.1, "lines": lines}
