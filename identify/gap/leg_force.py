"""A force in every leg that has no name: a table along its elongation, or along its speed.

A ripple of the spool, a drive in the middle of the stroke, a brake of an unknown law: what six legs do alike is no force on the
platform. The table has no physics and is never a name; that it suits the measurements says what the missing force goes with.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from measure.common.arrays import Array
from simulate.model.effect import LegEffect, parameter
from simulate.model.rig import Rig

PLACES = 24
_AS_WELL = 3.0  # times the median standard deviation


@dataclass(frozen=True)
class LegTable(LegEffect):
    """A force in every leg at evenly spaced places, linear between, steady beyond; the abscissa by its code, 0 elongation, 1 speed."""

    name = "missing-leg-force"
    code: ClassVar[float]
    unit: ClassVar[str]
    words: ClassVar[str]
    constants = 1
    force_N: tuple[float, ...] = parameter((0.0,) * PLACES, low=-1e3, high=1e3, typical=0.01, doc="at the places")
    first: float = parameter(0.0, low=-1e3, high=1e3, typical=1.0, doc="first place")
    spacing: float = parameter(0.01, low=1e-9, high=1e3, typical=1.0, doc="from place to place")

    def constants_of(self, model: Rig) -> tuple[float, ...]:
        """The code of the abscissa."""
        del model
        return (self.code,)

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """The force at this elongation or speed, N."""
        at = u if p[26] < 0.5 else v
        place = min(max((at - p[24]) / p[25], 0.0), 22.999999)
        left = int(place)
        return p[left] + (place - left) * (p[left + 1] - p[left])

    @classmethod
    def over(cls, first: float, last: float) -> Self:
        """Places from one end to the other."""
        return cls(first=first, spacing=max(last - first, 1e-9) / (PLACES - 1))

    @property
    def places(self) -> Array:
        """The places of the table, (PLACES,), m or m/s."""
        return self.first + self.spacing * np.arange(PLACES)


@dataclass(frozen=True)
class ForceAlongElongation(LegTable):
    """From the smallest to the largest elongation of a leg in any run."""

    name = "missing-force-along-elongation"
    code, unit, words = 0.0, "mm", "elongation"


@dataclass(frozen=True)
class ForceAlongLegSpeed(LegTable):
    """From the fastest coiling to the fastest uncoiling of a leg in any run."""

    name = "missing-force-along-leg-speed"
    code, unit, words = 1.0, "mm/s", "speed"


LEG_TABLES: tuple[type[LegTable], ...] = (ForceAlongElongation, ForceAlongLegSpeed)


@dataclass(frozen=True)
class LegForce:
    """What such a force would have to be: force_N, sigma_N (PLACES,) at the places of its table."""

    table: LegTable
    force_N: Array
    sigma_N: Array

    @property
    def sentence(self) -> str:
        """Where it is strongest to either side, among the places that are known as well as most."""
        known = np.flatnonzero(self.sigma_N <= _AS_WELL * np.median(self.sigma_N))
        ends = [known[np.argmax(self.force_N[known])], known[np.argmin(self.force_N[known])]]
        parts = [
            f"{self.force_N[i]:+.2g} N (sigma {self.sigma_N[i]:.1g}) at {1e3 * self.table.places[i]:.0f} {self.table.unit}" for i in ends
        ]
        return f"A force in every leg that goes with its {self.table.words}: {' and '.join(parts)}."
