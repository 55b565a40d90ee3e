"""The suspension cable draws the platform back under its pulley."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import PlatformEffect, parameter


@dataclass(frozen=True)
class CablePendulum(PlatformEffect):
    """A lateral stiffness: the tension of the cable over its free length.

    F_x = -k x          F_y = -k y          k = tension / free length, at the centre of mass

    A loop does not show it. In a deployment: lateral deviations are drawn back and swing about the middle; the elevation hardly
    changes.
    """

    name = "cable-pendulum"
    stiffness_N_per_m: float = parameter(0.0, low=0.0, high=500.0, typical=4.0, doc="tension over free length of the cable, k")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the lateral force to the wrench, N."""
        wrench[0] -= p[0] * pose[0]
        wrench[1] -= p[0] * pose[1]
