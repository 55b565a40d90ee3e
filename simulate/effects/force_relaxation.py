"""A strip that has been stowed for long pushes less and less while it works."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class ForceRelaxation(LegEffect):
    """The stored force relaxes from its first value towards a share of it, by the clock and not by the elongation.

    F = R (1 - r (1 - exp(-t / tau)))          time counts from the release

    In a loop: the mean force sinks from cycle to cycle and settles; loops that begin later lie lower. In a deployment: the legs
    push less and less, so the elevation falls behind more and more.
    """

    name = "force-relaxation"
    fraction: float = parameter(0.0, low=0.0, high=0.9, typical=0.05, doc="share of the force that is lost in the end, r")
    time_s: float = parameter(0.5, low=0.01, high=1e4, typical=0.3, starts=(0.03, 0.1, 0.3, 1.0, 5.0), doc="time constant, tau")

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """What is missing of the hysteretic force, N."""
        return -R * p[0] * (1.0 - math.exp(-t / p[1]))
