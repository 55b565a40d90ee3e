"""A dry force that is there at low speed and lets go at high speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class StribeckFriction(LegEffect):
    """What sticks at low speed slides more easily at high speed (Stribeck 1902; Armstrong-Helouvry 1994).

        F = -dF sgn(v) exp(-(v / v_s)^2),   the sign eased in as tanh(v / 2 mm/s)

    dF is what the sticking adds to the sliding friction, which is the hysteresis of the law itself.

    In a loop: slow loops are taller than fast ones, and near the reversals each branch has a bump. In a deployment: the platform is
    held back at the release and wherever it turns back, and hardly in between.
    """

    name = "stribeck-friction"
    force_N: float = parameter(
        0.0, low=0.0, high=2.0, typical=0.05, doc="additional force at low speed, dF", source="Stribeck 1902; Armstrong-Helouvry 1994"
    )
    speed_m_per_s: float = parameter(
        0.05, low=1e-3, high=2.0, typical=0.1, starts=(0.01, 0.03, 0.1, 0.3, 1.0), doc="speed at which it has fallen to 37 %, v_s"
    )

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """Force along the leg, N."""
        return -p[0] * math.tanh(v / 2e-3) * math.exp(-((v / p[1]) ** 2))
