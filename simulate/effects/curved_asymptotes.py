"""The strip's force does not follow a straight line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class CurvedAsymptotes(LegEffect):
    """Both asymptotes bend alike, as a coil whose radius changes with every turn makes them.

    h = a u + b + c2 u^2 + c3 u^3

    In a loop: both branches bend alike, the same at every frequency. In a deployment: the force over the height changes its course:
    the elevation departs smoothly, and more on long strokes than on short ones.
    """

    name = "curved-asymptotes"
    quadratic_N_per_m2: float = parameter(0.0, low=-1.0e4, high=1.0e4, typical=1.0, doc="c2, added to both asymptotes times u^2")
    cubic_N_per_m3: float = parameter(0.0, low=-1.0e5, high=1.0e5, typical=2.0, doc="c3, added to both asymptotes times u^3")

    @staticmethod
    def leg_asymptotes(u: float, v: float, t: float, p: Any, h: Any) -> None:
        """Moves both asymptotes, N."""
        bend = (p[0] + p[1] * u) * u * u
        h[0] += bend
        h[1] += bend
