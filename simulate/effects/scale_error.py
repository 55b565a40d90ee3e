"""The camera's millimetre is not a millimetre."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from simulate.model.effect import Array, MeasurementEffect, parameter


@dataclass(frozen=True)
class ScaleError(MeasurementEffect):
    """Every length on the film is too long by the same fraction; rotations do not change.

        x_seen = (1 + e) x          (y, z alike)

    The depth between rule and platform alone made 2 % in one real film. Where only displacements were scaled the start is
    off by e times the start height, which a run's release position takes up.

    A loop does not show it. In a deployment: every position is too large by the same share, stroke and start height alike;
    rotations and times are right.
    """

    name = "scale-error"
    fraction: float = parameter(0.0, low=-0.2, high=0.2, typical=0.002, doc="measured lengths are times 1 + e")

    def observe(self, time_s: Array, channels: Mapping[str, Array]) -> Mapping[str, Array]:
        """Lengths as the wrong scale shows them."""
        del time_s
        return {name: (1.0 + self.fraction) * values if name.endswith("_m") else values for name, values in channels.items()}
