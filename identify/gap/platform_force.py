"""The force that is missing on the platform, with its band: along time, along the height or along the speed.

The force is unknown input to the six-leg model: a table of what a film in the plane x, z can see, two forces and a moment, at
fixed places of an abscissa, straight lines between. It is an effect like any other, so it is estimated together with base and
releases and is the same in every run; but it has no physics and is never a name. Which abscissa suits all runs best says what
the force goes with.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from identify.criteria import CLEAR_LEAD
from measure.common.arrays import Array
from simulate.model.effect import PlatformEffect, parameter
from simulate.model.rig import Rig

KNOTS = 24
MOVES = ("z_m", "x_m", "theta_y_rad")  # what vertical force, lateral force and moment move
AXES = len(MOVES)
_BAND = 3.0


def _table(typical: float, doc: str) -> Any:
    return parameter((0.0,) * KNOTS, low=-1e3, high=1e3, typical=typical, doc=doc)


@dataclass(frozen=True)
class ForceTable(PlatformEffect):
    """A force on the platform along an abscissa: F_z, F_x and M_y at evenly spaced places, linear between, steady beyond.

    The abscissa is time since the release, height, or upward speed, by its code 0, 1, 2.
    """

    name = "missing-force"
    code: ClassVar[float]
    words: ClassVar[str]
    constants = 1
    vertical_N: tuple[float, ...] = _table(0.02, "F_z at the places")
    lateral_N: tuple[float, ...] = _table(0.02, "F_x at the places")
    moment_N_m: tuple[float, ...] = _table(0.001, "M_y at the places")
    first: float = parameter(0.0, low=-1e3, high=1e3, typical=1.0, doc="first place, in the unit of the abscissa")
    spacing: float = parameter(0.05, low=1e-9, high=1e3, typical=1.0, doc="from place to place")

    def constants_of(self, model: Rig) -> tuple[float, ...]:
        """The code of the abscissa."""
        del model
        return (self.code,)

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the force of this instant, height or speed, N and N m."""
        at = t if p[74] < 0.5 else (pose[2] if p[74] < 1.5 else twist[2])
        place = min(max((at - p[72]) / p[73], 0.0), 22.999999)
        left = int(place)
        share = place - left
        wrench[2] += p[left] + share * (p[left + 1] - p[left])
        wrench[0] += p[24 + left] + share * (p[25 + left] - p[24 + left])
        wrench[4] += p[48 + left] + share * (p[49 + left] - p[48 + left])

    @classmethod
    def over(cls, first: float, last: float) -> Self:
        """Places from one end to the other."""
        return cls(first=first, spacing=(last - first) / (KNOTS - 1))

    @property
    def places(self) -> Array:
        """The places of the table, (KNOTS,), in the unit of the abscissa."""
        return self.first + self.spacing * np.arange(KNOTS)


@dataclass(frozen=True)
class ForceAlongTime(ForceTable):
    """From the release to the last frame of any film."""

    name = "missing-force-along-time"
    words = "time"
    code = 0.0


@dataclass(frozen=True)
class ForceAlongHeight(ForceTable):
    """From the lowest start to full height."""

    name = "missing-force-along-height"
    words = "height"
    code = 1.0


@dataclass(frozen=True)
class ForceAlongSpeed(ForceTable):
    """From rest to the largest upward speed that was seen."""

    name = "missing-force-along-speed"
    words = "speed"
    code = 2.0


Along = type[ForceTable]
_WORDS: dict[Along, tuple[str, str, str]] = {
    ForceAlongTime: ("time_s", "s after the release", "time"),
    ForceAlongHeight: ("height_m", "m of height", "height"),
    ForceAlongSpeed: ("speed_m_per_s", "m/s of upward speed", "speed"),
}
ALONGS: tuple[Along, ...] = tuple(_WORDS)
_DOES = (
    ("acts upwards on the platform", "acts downwards on the platform", "N"),
    ("acts to the right on the platform", "acts to the left on the platform", "N"),
    ("turns the platform about +y", "turns the platform about -y", "N m"),
)


@dataclass(frozen=True)
class MissingForce:
    """The estimated force: places (n,) of its abscissa, force and one standard deviation (n, 3): vertical and lateral, N; moment, N m.

    leads : by how much the log evidence leads that along each other abscissa, by name. spacing : from one place to the next.
    A direction that was not estimated has no band (NaN).
    """

    along: Along
    places: Array
    force_N: Array
    sigma_N: Array
    leads: dict[str, float]
    spacing: float

    @property
    def sentence(self) -> str:
        """What the force does, for a person to act on."""
        words = [w for axis, (up, down, unit) in enumerate(_DOES) if (w := self._axis(axis, up, down, unit))]
        if not words:
            return "No missing force on the platform stands out of its band anywhere."
        return "The missing force " + " and ".join(words) + "; " + self.goes_with + "."

    @property
    def goes_with(self) -> str:
        """What the force goes with, as far as these runs can tell."""
        own = _WORDS[self.along][2]
        near = [name for name, lead in self.leads.items() if lead < CLEAR_LEAD]
        if not self.leads:
            return f"estimated along {own} only"
        if near:
            return f"whether it goes with {', '.join([own, *near])} these runs cannot tell"
        return f"it goes with the {own}, whatever the " + " and the ".join(self.leads)

    @property
    def columns(self) -> dict[str, Array]:
        """The table that is written: places, force and band."""
        return {
            _WORDS[self.along][0]: self.places,
            "vertical_force_N": self.force_N[:, 0],
            "sigma_vertical_force_N": self.sigma_N[:, 0],
            "lateral_force_N": self.force_N[:, 1],
            "sigma_lateral_force_N": self.sigma_N[:, 1],
            "moment_N_m": self.force_N[:, 2],
            "sigma_moment_N_m": self.sigma_N[:, 2],
        }

    @property
    def label(self) -> str:
        """The abscissa with its unit, for a figure."""
        return {"time": "time after the release, s", "height": "height, m", "speed": "upward speed, m/s"}[_WORDS[self.along][2]]

    def _axis(self, axis: int, positive: str, negative: str, force_unit: str) -> str:
        force, sigma = self.force_N[:, axis], self.sigma_N[:, axis]
        strong = np.abs(force) > _BAND * sigma
        if not strong.any():
            return ""
        peak = int(np.argmax(np.where(strong, np.abs(force), 0.0)))
        same = strong & (np.sign(force) == np.sign(force[peak]))
        first = last = peak
        while first > 0 and same[first - 1]:
            first -= 1
        while last < len(force) - 1 and same[last + 1]:
            last += 1
        side, unit = positive if force[peak] > 0 else negative, _WORDS[self.along][1]
        size = f"{abs(force[peak]):.3g} +- {sigma[peak]:.2g} {force_unit}"
        if len(force) == 1:
            return f"{side} about {self.places[peak]:.2f} {unit}, {size}"
        return (
            f"{side} between {self.places[first]:.2f} and {self.places[last]:.2f} {unit}, {size} at its largest ({self.places[peak]:.2f})"
        )
