"""A strip that is unrolled faster pushes with another force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter

_PAPER = "Fig. 12"
_SLOPE = "added to the slope, times |v| and v^2 (N s/m^2, N s^2/m^3)"
_LEVEL = "added to the level, times |v| and v^2 (N s/m, N s^2/m^2)"
_OFF = (0.0, 0.0)
_SLOPES, _LEVELS = ("N_s_per_m2", "N_s2_per_m3"), ("N_s_per_m", "N_s2_per_m2")


@dataclass(frozen=True)
class RateDependentAsymptotes(LegEffect):
    """Slope and level of both asymptotes follow the speed of the elongation, as second-order polynomials without constant.

        a(v) = a + a1 |v| + a2 v^2          b(v) = b + b1 |v| + b2 v^2

    Aridon 2009, Fig. 12, gives them against the frequency of a sinusoidal test; a deployment has a speed instead, and the
    two meet at mid-stroke, v = 2 pi f A. The constants are the actuator's own. In [actuator.rate] the same polynomials are
    written with their constants.

    The bounds keep out no polynomial that was measured: slow loops may give 100 N s^2/m^3.

    In a loop: level and slope of each branch change from one frequency to the next. In a deployment: the force is the quasi-static
    one at the release and departs from it as the speed builds up.
    """

    name = "rate-dependent-asymptotes"
    a_l: tuple[float, ...] = parameter(_OFF, low=-1e6, high=1e6, typical=0.05, doc=_SLOPE + ", uncoiling", source=_PAPER, units=_SLOPES)
    b_l: tuple[float, ...] = parameter(_OFF, low=-1e6, high=1e6, typical=0.02, doc=_LEVEL + ", uncoiling", source=_PAPER, units=_LEVELS)
    a_u: tuple[float, ...] = parameter(_OFF, low=-1e6, high=1e6, typical=0.05, doc=_SLOPE + ", coiling", source=_PAPER, units=_SLOPES)
    b_u: tuple[float, ...] = parameter(_OFF, low=-1e6, high=1e6, typical=0.02, doc=_LEVEL + ", coiling", source=_PAPER, units=_LEVELS)

    @staticmethod
    def leg_asymptotes(u: float, v: float, t: float, p: Any, h: Any) -> None:
        """Moves both asymptotes, N."""
        s = abs(v)
        h[0] += (p[0] * u + p[2]) * s + (p[1] * u + p[3]) * s * s
        h[1] += (p[4] * u + p[6]) * s + (p[5] * u + p[7]) * s * s
