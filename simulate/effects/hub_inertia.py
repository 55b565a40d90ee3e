"""The spool of a leg has to be spun up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class HubInertia(LegEffect):
    """The spool must be spun up before the strip can leave it.

        F = -m u''          m = J / r^2

    A sinusoidal test sees it as a loop that turns with the frequency squared (Aridon 2009, section 3.3, Fig. 11). Being
    proportional to the acceleration it belongs to the mass matrix, not to the forces.

    In a loop: the whole loop turns towards a steeper slope, by m omega^2, and keeps its area. In a deployment: the platform gathers
    speed more slowly from the release on and keeps its energy, so the rebound is as strong as ever.
    """

    name = "hub-inertia"
    mass_kg: float = parameter(
        0.0, low=0.0, high=1e6, typical=0.05, doc="hub inertia J seen through the coil radius r", source="Aridon 2009, section 3.3, Fig. 11"
    )

    @staticmethod
    def leg_mass(u: float, p: Any) -> float:
        """Inertia along the leg, kg; the same at every elongation."""
        return p[0]
