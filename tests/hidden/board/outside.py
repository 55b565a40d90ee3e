"""Effects that no catalogue holds, for cases whose right answer is that nobody knows; and a ripple, for tests."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simulate.model.effect import Effect, LegEffect, PlatformEffect, parameter


@dataclass(frozen=True)
class Gust(PlatformEffect):
    """Blows upwards for a tenth of a second, smoothly."""

    name = "gust"
    force_N: float = parameter(0.0, low=-10.0, high=10.0, typical=0.1, doc="at its strongest, 0.2 s after the release")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the gust."""
        if 0.15 < t < 0.25:
            wrench[2] += p[0] * math.sin(math.pi * (t - 0.15) / 0.1) ** 2


@dataclass(frozen=True)
class CoilRipple(LegEffect):
    """A dent in the spool: the force of every leg ripples with each turn of 60 mm."""

    name = "coil-ripple"
    force_N: float = parameter(0.0, low=-1.0, high=1.0, typical=0.02, doc="amplitude of the ripple")

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """The ripple, N."""
        return p[0] * math.sin(2.0 * math.pi * u / 0.06)


@dataclass(frozen=True)
class CoilDents(LegEffect):
    """Two dents in the strip: a short help where the first leaves the coil, and a longer hindrance at the second."""

    name = "coil-dents"
    force_N: float = parameter(0.0, low=-1.0, high=1.0, typical=0.02, doc="largest force of a dent")

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """The dents, N."""
        return p[0] * (math.exp(-(((u - 0.085) / 0.005) ** 2)) - math.exp(-(((u - 0.118) / 0.009) ** 2)))


@dataclass(frozen=True)
class SideWind(PlatformEffect):
    """A draught from the side that swells and dies away four times a second, and twists the platform."""

    name = "side-wind"
    force_N: float = parameter(0.0, low=-10.0, high=10.0, typical=0.05, doc="strongest lateral force")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds force along x and a moment about y."""
        swell = p[0] * math.sin(4.0 * math.pi * t) ** 2
        wrench[0] += swell
        wrench[4] += 0.05 * swell


@dataclass(frozen=True)
class Snag(PlatformEffect):
    """A cable catches between two heights and holds the platform back there."""

    name = "snag"
    force_N: float = parameter(0.0, low=0.0, high=10.0, typical=0.2, doc="held back while it is caught")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Takes the force away within 40 mm, eased in."""
        wrench[2] -= p[0] * math.exp(-(((pose[2] - 0.42) / 0.02) ** 2))


@dataclass(frozen=True)
class StageDrive(LegEffect):
    """A motor helps every leg in the middle of its stroke only."""

    name = "stage-drive"
    force_N: float = parameter(0.0, low=-3.0, high=3.0, typical=0.05, doc="added in the middle of the stroke")

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """The push, N."""
        return p[0] / (1.0 + math.exp(-(u - 0.12) / 0.004)) / (1.0 + math.exp((u - 0.18) / 0.004))


@dataclass(frozen=True)
class Hardening(PlatformEffect):
    """A cable that comes under tension above a height, and pulls back the more the higher it goes."""

    name = "hardening-cable"
    force_N: float = parameter(0.0, low=0.0, high=100.0, typical=0.2, doc="pulls down 0.1 m above the height from which it is tight")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Takes away what grows with the cube of the way above 0.45 m."""
        if pose[2] > 0.45:
            wrench[2] -= p[0] * ((pose[2] - 0.45) / 0.1) ** 3


@dataclass(frozen=True)
class SideLift(PlatformEffect):
    """A plate that stands askew: the faster the platform rises, the more it is pushed aside, with the square of the speed."""

    name = "side-lift"
    force_N: float = parameter(0.0, low=-10.0, high=10.0, typical=0.05, doc="lateral force at 1 m/s")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds force along x."""
        wrench[0] += p[0] * twist[2] * abs(twist[2])


@dataclass(frozen=True)
class LostLoad(PlatformEffect):
    """A ballast that hangs on for 0.18 s and then falls off: its weight is missing from then on."""

    name = "lost-load"
    force_N: float = parameter(0.0, low=-10.0, high=10.0, typical=0.1, doc="upwards from then on")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds a step, eased in over some milliseconds."""
        wrench[2] += p[0] / (1.0 + math.exp(-(t - 0.18) / 0.003))


_ALL = (Gust, CoilDents, SideWind, Snag, StageDrive, Hardening, SideLift, LostLoad)
KINDS: dict[str, type[Effect]] = {kind.name: kind for kind in _ALL}
