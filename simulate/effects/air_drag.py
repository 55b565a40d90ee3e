"""The air holds the platform back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simulate.model.effect import PlatformEffect, parameter


@dataclass(frozen=True)
class AirDrag(PlatformEffect):
    """Drag with the square of the speed, against it, at the centre of mass.

    F = -k |V| V          k = rho c_d A / 2, some 0.05 kg/m for a plate of 0.3 m

    A loop does not show it. In a deployment: the elevation falls behind late in the stroke, where the platform is fast, with the
    square of the speed.
    """

    name = "air-drag"
    coefficient_kg_per_m: float = parameter(0.0, low=0.0, high=10.0, typical=0.05, doc="drag at 1 m/s, k")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the drag to the wrench, N."""
        speed = math.sqrt(twist[0] * twist[0] + twist[1] * twist[1] + twist[2] * twist[2])
        for k in range(3):
            wrench[k] -= p[0] * speed * twist[k]
