"""The two circles of a rig's joints as values of a model: a radius scales all joints of its ring about the vertical."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from measure.common.arrays import Array
from simulate.model.rig import Geometry

RADII = {"geometry.base_radius_m": "base_joints_m", "geometry.platform_radius_m": "platform_joints_m"}
"""Names of the radii, and the joints that each moves."""


def radius_of(geometry: Geometry, joints: str) -> float:
    """Mean distance of the joints from the vertical through the origin of their frame, m."""
    return float(np.mean(np.hypot(*_points(geometry, joints)[:, :2].T)))


def with_radius(geometry: Geometry, joints: str, radius_m: float) -> Geometry:
    """The joints nearer or farther by a common factor, at their height, so that their mean distance is the radius.

    Raises
    ------
    ValueError
        The joints stand on the vertical, or the radius is none.
    """
    now = radius_of(geometry, joints)
    if not (radius_m > 0.0 and now > 0.0):
        raise ValueError(f"{joints}: the radius must be above zero")
    points = _points(geometry, joints) * [radius_m / now, radius_m / now, 1.0]
    return replace(geometry, **{joints: tuple(tuple(point) for point in points.tolist())})


def _points(geometry: Geometry, joints: str) -> Array:
    return np.asarray(getattr(geometry, joints), dtype=float)
