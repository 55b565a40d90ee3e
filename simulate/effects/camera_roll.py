"""The camera does not stand upright."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from simulate.model.effect import Array, MeasurementEffect, parameter


@dataclass(frozen=True)
class CameraRoll(MeasurementEffect):
    """The picture's axes are turned about the line of sight, which is y: what is vertical shows as lateral, too.

        x_seen = x cos a + z sin a          z_seen = z cos a - x sin a

    The rotation of the platform is read against the first picture and does not change. Where only one of both is there
    nothing can be turned.

    A loop does not show it. In a deployment: a small copy of the elevation lies over the lateral channel.
    """

    name = "camera-roll"
    angle_rad: float = parameter(0.0, low=-0.5, high=0.5, typical=0.01, doc="roll of the camera, a")

    def observe(self, time_s: Array, channels: Mapping[str, Array]) -> Mapping[str, Array]:
        """Positions in the turned picture."""
        del time_s
        if "x_m" not in channels or "z_m" not in channels:
            return channels
        c, s = math.cos(self.angle_rad), math.sin(self.angle_rad)
        x, z = channels["x_m"], channels["z_m"]
        return {**channels, "x_m": c * x + s * z, "z_m": c * z - s * x}
