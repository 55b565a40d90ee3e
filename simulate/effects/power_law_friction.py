"""A force against the motion that grows with a power of its speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import Bounds, LegEffect, parameter
from simulate.model.measures import PROTOTYPE, Measures
from simulate.model.rig import Rig

BELOW, ABOVE = 0.8, 1.3


@dataclass(frozen=True)
class PowerLawFriction(LegEffect):
    """The loss grows slower or faster than the speed: a lubricated contact (exponent below 1), a fan-like hub (about 2).

        F = -k sgn(v) |v|^n,   written as -k v (v^2 + v_0^2)^((n - 1) / 2),  v_0 = 1 mm/s

    Without v_0 an exponent below 1 has an infinite slope at rest, which no explicit step survives. Between 0.8 and 1.3 it is
    hardly to be told from viscous friction.

    In a loop: the branches move apart with the power n of the frequency. In a deployment: it holds back as viscous friction does:
    late in the stroke, where the speed is high, for n above 1, from the start for n below 1.
    """

    name = "power-law-friction"
    coefficient: float = parameter(0.0, low=0.0, high=1e6, typical=0.05, doc="force at 1 m/s, k, in N s^n/m^n", units=("N",))
    exponent: float = parameter(
        2.0, low=0.3, high=3.0, typical=2.0, starts=(0.5, 1.5, 2.0, 2.8), doc="n; meant for 0.3 to 0.8 and 1.3 to 3"
    )

    def own_bounds(self, model: Rig | None = None, measures: Measures = PROTOTYPE) -> Bounds:
        """A search that starts below 0.8 or above 1.3 stays there: between, the law is viscous friction under another name."""
        found = type(self).bounds(model, measures)
        low, high = found["exponent"]
        if self.exponent <= BELOW:
            high = BELOW
        elif self.exponent >= ABOVE:
            low = ABOVE
        return {**found, "exponent": (low, high)}

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """Force along the leg, N."""
        return -p[0] * v * (v * v + 1e-6) ** (0.5 * (p[1] - 1.0))
