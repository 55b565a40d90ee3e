"""Between leg and strip there is play: a loose pin, a hook, a joint that is worn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class SeriesPlay(LegEffect):
    """The strip follows the leg only beyond a play; within it the force stays as it was.

        F = R(w),   w' = 0 where |u - w| < g / 2,   w' = u' at either end of the play

    w is the elongation of the strip, by which the force law goes; at the release, or at the first sample, w = u. After a reversal of the
    leg the strip waits for a way g. With backlash the force is gone within the gap; here it stays. The formula describes strokes well
    above g: about that of the play the leg would give back more energy than it took.

    In a loop: each branch begins with a flat piece of length g, alike at every frequency, and the loop is smaller. In a deployment:
    hardly anything changes up to the first reversal; then the rebound from the stops meets the old force for a while.
    """

    name = "series-play"
    gap_m: float = parameter(0.0, low=0.0, high=0.05, typical=5e-4, doc="elongation after a reversal that the strip does not follow, g")

    @staticmethod
    def strip_elongation(u: float, before: float, p: Any) -> float:
        """Elongation of the strip, m: of those that the play allows the nearest to the one before."""
        return min(max(before, u - 0.5 * p[0]), u + 0.5 * p[0])
