"""The platform touches the handrails that keep it from falling off the rig."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simulate.model.effect import PlatformEffect, parameter
from simulate.model.rig import Rig


@dataclass(frozen=True)
class HandrailContact(PlatformEffect):
    """Beyond a radial clearance a spring pushes the centre of mass back, and friction holds it.

        N = k (rho - c) where rho > c          F = -N e_rho - mu N V / sqrt(V^2 + V_0^2)

    mu = 0.2 (plastic on metal, an assumption) and V_0 = 5 mm/s; the friction acts along and across the rails alike.

    A loop does not show it. In a deployment: lateral deviations are cut off at the clearance and thrown back, and the elevation
    slows down while the rails are touched.
    """

    name = "handrail-contact"
    clearance_m: float = parameter(
        0.02, low=0.0, high=0.5, typical=0.002, starts=(0.0, 0.0005, 0.001, 0.002, 0.004, 0.008, 0.016), doc="free way to every side, c"
    )
    stiffness_N_per_m: float = parameter(0.0, low=0.0, high=1e5, typical=500.0, doc="of the rails, k")

    def stiffness(self, model: Rig) -> tuple[float, float]:
        """The rails, and their friction under the push of an impact at 1 m/s."""
        mass = model.moving_mass_kg
        return self.stiffness_N_per_m, 0.2 * math.sqrt(self.stiffness_N_per_m * mass) / 5e-3

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds contact and friction to the wrench, N."""
        radius = math.sqrt(pose[0] * pose[0] + pose[1] * pose[1])
        normal = p[1] * max(radius - p[0], 0.0)
        speed = math.sqrt(twist[0] * twist[0] + twist[1] * twist[1] + twist[2] * twist[2] + 2.5e-5)
        drag, outwards = 0.2 * normal / speed, normal / max(radius, 1e-300)
        for k in range(3):
            wrench[k] -= drag * twist[k]
        wrench[0] -= outwards * pose[0]
        wrench[1] -= outwards * pose[1]
