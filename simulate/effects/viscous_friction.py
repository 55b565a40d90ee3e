"""A force against the motion that grows with its speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class ViscousFriction(LegEffect):
    """Grease, air in the housing or an eddy-current brake holds the strip back in proportion to its speed.

        F = -c v

    In a loop it adds `pi c omega A^2` to the area, so the loop's height grows with the frequency (Aridon 2009, section 3.4
    tests for it by the effective stiffness).

    In a loop: at mid-stroke the branches are farther apart by 2 c v, in proportion to the frequency; near the reversals nothing
    changes. In a deployment: full height is reached later, by most where the motion is fast; swing and rebound die out sooner.
    """

    name = "viscous-friction"
    damping_N_s_per_m: float = parameter(
        0.0, low=0.0, high=1.0e4, typical=0.02, doc="force per speed of elongation", source="Aridon 2009, section 3.4, eq. (5)"
    )

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """Force along the leg, N."""
        return -p[0] * v
