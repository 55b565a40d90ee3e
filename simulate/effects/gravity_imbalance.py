"""The counterweight does not carry the whole weight, or carries too much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import PlatformEffect, parameter


@dataclass(frozen=True)
class GravityImbalance(PlatformEffect):
    """A constant vertical force is left over at the centre of mass, up positive.

    F_z = f

    A loop does not show it. In a deployment: the elevation departs with the square of the time from the release on, upwards or
    downwards, and nothing else does.
    """

    name = "gravity-imbalance"
    force_N: float = parameter(0.0, low=-50.0, high=50.0, typical=0.05, doc="what weight and counterweight leave over, up positive")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the force to the wrench, N."""
        wrench[2] += p[0]
