"""The lens bends what is away from its axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from simulate.model.effect import Array, MeasurementEffect, parameter


@dataclass(frozen=True)
class LensDistortion(MeasurementEffect):
    """Radial distortion of second order: a length is stretched by the square of its distance from the optical axis.

        x_seen = x (1 + k r^2)          z_seen = z_0 + (z - z_0) (1 + k r^2)          r^2 = x^2 + (z - z_0)^2

    The axis meets the plane of the platform at x = 0 and at the height z_0. k > 0 is a pincushion, k < 0 a barrel; Brown's first
    coefficient is k times the squared distance of the camera. Of a channel that is not there r takes nothing. What a lens does to the
    rotation is smaller by the size of the platform over its way, and left out.

    A loop does not show it. In a deployment: the elevation is wrong at both ends of the stroke and right in between, by the cube of
    the distance; the lateral channel is wrong in proportion to itself.
    """

    name = "lens-distortion"
    per_m2: float = parameter(0.0, low=-5.0, high=5.0, typical=0.02, doc="stretch over squared distance, k", source="Brown 1966")
    centre_m: float = parameter(
        0.4, low=-10.0, high=10.0, typical=0.1, starts=(0.2, 0.35, 0.5, 0.7), doc="height at which the optical axis meets the rig, z_0"
    )

    def observe(self, time_s: Array, channels: Mapping[str, Array]) -> Mapping[str, Array]:
        """Positions in the distorted picture."""
        del time_s
        away = {name: channels[name] - zero for name, zero in (("x_m", 0.0), ("z_m", self.centre_m)) if name in channels}
        if not away:
            return channels
        stretch = self.per_m2 * sum(values * values for values in away.values())
        return {**channels, **{name: channels[name] + values * stretch for name, values in away.items()}}
