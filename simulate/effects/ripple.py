"""Something in the leg comes round again and again: teeth, holes of a spool, magnets that cog."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from measure.common.arrays import Array
from simulate.model.effect import LegEffect, parameter
from simulate.model.rig import LEGS, Rig
from simulate.model.wave import Wave

_PERIODS_M = tuple(1.0 / k for k in (*range(4, 61, 4), *range(72, 300, 14)))  # no wider apart than a full stroke, or a loop, can tell


@dataclass(frozen=True)
class Ripple(Wave, LegEffect):
    """The force of each leg ripples with its elongation, whatever the speed and direction; it gives back what it takes.

        F = A sin(2 pi u / p + phi)

    -A is A half a period on. The elongation counts from the stowed leg, and in a loop as its file has it.

    In a loop: both branches carry the same wave, at the same elongations at every frequency. In a deployment: over the
    first wave the platform gains or loses a little speed and is early or late from then on; those behind pass too quickly to show.
    """

    name = "ripple"
    summed = ("phase_rad",)
    force_N: float = parameter(0.0, low=-10.0, high=10.0, typical=0.01, doc="amplitude of the wave, A")
    period_m: float = parameter(0.05, low=5e-4, high=0.3, typical=0.02, starts=_PERIODS_M, doc="elongation from one wave to the next, p")
    phase_rad: float = parameter(0.0, low=-7.0, high=7.0, typical=0.5, starts=(0.0, 1.57), doc="phase of the stowed leg, phi")

    def sum_of(self, shapes: Array, amounts: Array) -> Ripple:
        """One wave for several of the same period."""
        of_sine, of_cosine = float(amounts @ np.cos(shapes[:, 2])), float(amounts @ np.sin(shapes[:, 2]))
        return replace(self, force_N=math.hypot(of_sine, of_cosine), phase_rad=math.atan2(of_cosine, of_sine))

    def stiffness(self, model: Rig) -> tuple[float, float]:
        """The steepest slope of the wave, of all legs together."""
        del model
        return LEGS * abs(self.force_N) * 2.0 * math.pi / self.period_m, 0.0

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """Force along the leg, N."""
        return p[0] * math.sin(2.0 * math.pi * u / p[1] + p[2])
