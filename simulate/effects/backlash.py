"""After a reversal the drive has to cross its play before it pushes again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class Backlash(LegEffect):
    """No force is transmitted within a gap of elongation after a reversal.

        F = 0 where |travel| < 0.9 g,   R from |travel| = g on, eased in between

    At the release there is no play: a stowed leg is in contact, so the gap opens at the first reversal.

    In a loop: after each reversal the force is missing over the gap: a notch at both ends of the loop. In a deployment: nothing
    changes up to the first reversal; behind the stops the rebound begins without force.
    """

    name = "backlash"
    gap_m: float = parameter(0.0, low=0.0, high=0.05, typical=1e-3, linear=False, doc="elongation after a reversal without force, g")

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """Takes the hysteretic force away within the gap, N."""
        open_ = min(max(10.0 * (p[0] - abs(travel)) / max(p[0], 1e-300), 0.0), 1.0)
        return -R * open_ * open_ * (3.0 - 2.0 * open_)
