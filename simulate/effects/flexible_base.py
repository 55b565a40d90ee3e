"""The rig stands on something that gives way: a table, a frame, a floor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simulate.model.effect import PlatformEffect, parameter
from simulate.model.rig import LEGS, Rig

_FREQUENCIES_HZ = (1.0, 2.0, 3.0, *(4.5 + 1.5 * k for k in range(14)), 30.0, 40.0, 60.0)  # no wider apart than a film of 0.6 s can tell


@dataclass(frozen=True)
class FlexibleBase(PlatformEffect):
    """The base ring is a mass on springs and dampers and moves along the vertical; the camera stands beside it.

        m s'' = f_0 - f - 2 zeta (2 pi f_b) m s' - (2 pi f_b)^2 m s,          s = s' = 0 at the release

    s is the height of the ring over where it was, f the vertical force of the legs with their inertia, f_0 the platform's weight, which
    the springs have carried since before the release. The legs stand on the ring and see the platform from there. The base is rigid
    where m = 0, and the more nearly so the heavier it is. m is what swings with the ring, f_b its frequency without the platform.

    A loop does not show it. In a deployment: up to the stops little, for the legs push alike wherever they stand, but for the inertia of
    their hubs, which hands on a swing from the release on; the impact at the stops sets the base swinging and the rebound differs.
    """

    name = "flexible-base"
    mass_kg: float = parameter(
        0.0, low=0.0, high=1e4, typical=5.0, starts=(20.0,), linear=False, doc="mass of the base ring, m; zero for a rigid base"
    )
    frequency_Hz: float = parameter(
        10.0, low=0.2, high=200.0, typical=5.0, starts=_FREQUENCIES_HZ, linear=False, doc="frequency of the ring by itself, f_b"
    )
    damping_ratio: float = parameter(0.03, low=0.0, high=2.0, typical=0.05, linear=False, doc="damping over critical damping, zeta")

    def stiffness(self, model: Rig) -> tuple[float, float]:
        """Springs and dampers of base and stops as the base feels them, brought to the platform's mass."""
        if self.mass_kg == 0.0:
            return 0.0, 0.0
        omega, share, stop = 2.0 * math.pi * self.frequency_Hz, LEGS / self.mass_kg, model.end_stop
        spring, damper = omega**2 + share * stop.stiffness_N_per_m, 2.0 * self.damping_ratio * omega + share * stop.damping_N_s_per_m
        return model.moving_mass_kg * spring, model.moving_mass_kg * damper

    @staticmethod
    def base_mass(p: Any) -> float:
        """Mass of the ring, kg."""
        return p[0]

    @staticmethod
    def base_force(place: float, speed: float, p: Any) -> float:
        """Force of springs and dampers on the ring, N."""
        omega = 2.0 * math.pi * p[1]
        return -p[0] * omega * (2.0 * p[2] * speed + omega * place)
