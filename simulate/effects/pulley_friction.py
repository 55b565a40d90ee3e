"""The pulley of the counterweight rubs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simulate.model.effect import PlatformEffect, parameter


@dataclass(frozen=True)
class PulleyFriction(PlatformEffect):
    """A dry force against the vertical motion.

    F_z = -f sgn(z'),   the sign eased in as tanh(z' / 2 mm/s)

    A loop does not show it. In a deployment: a constant retardation while the platform rises, which changes its sign in the
    rebound.
    """

    name = "pulley-friction"
    force_N: float = parameter(0.0, low=0.0, high=5.0, typical=0.1, doc="dry force of the pulley, f")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the force to the wrench, N."""
        wrench[2] -= p[0] * math.tanh(twist[2] / 2e-3)
