"""What a film needs to know of the rig, read from its model file: how high the platform starts, and how wide it is."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from pathlib import Path
from typing import Any

from measure.common.errors import InputError
from measure.common.inputs import read_toml

_LINES = """\
[geometry]
stowed_height_m = 0.252               # of the platform frame's origin in the first frame
platform_joints_m = [[x, y, z], ...]  # six, m"""


@dataclass(frozen=True)
class RigAtStart:
    """The platform in the first frame: height of its origin, and radius of the circle of its joints, m.

    Marks on its rim lie on a cylinder of about that radius.
    """

    start_height_m: float
    radius_m: float


def read_rig_at_start(path: Path) -> RigAtStart:
    """Read the start from a model file.

    Parameters
    ----------
    path : model file; only its geometry and release are looked at.

    Raises
    ------
    InputError
        No such file, not TOML, or no geometry; the lines to add are in the message.
    """
    document = read_toml(path, what="a model file (TOML)", advice="Name a model file.")
    geometry = document.get("geometry")
    try:
        return _start(geometry, document.get("release", {}))
    except (TypeError, KeyError, ValueError, AttributeError):
        missing = "no [geometry] table" if geometry is None else "no usable stowed_height_m and platform_joints_m in [geometry]"
        raise InputError(
            f"{path}: {missing}, so nothing says how high the platform starts. Add\n{_LINES}\nor give --start-height-m H and no --model."
        ) from None


def _start(geometry: Any, release: Any) -> RigAtStart:
    joints = [(float(x), float(y)) for x, y, _ in geometry["platform_joints_m"]]
    moved = float(release.get("position_m", (0.0, 0.0, 0.0))[2])
    radius = max(hypot(x, y) for x, y in joints)
    if not radius > 0.0:
        raise ValueError
    return RigAtStart(float(geometry.get("stowed_height_m", 0.252)) + moved, radius)
