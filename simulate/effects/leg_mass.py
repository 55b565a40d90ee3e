"""The strip of a leg has a mass, along the leg and across it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class LegMass(LegEffect):
    """A strip of even density comes off a spool at the base; coiled or straight, all of it moves with the platform joint.

        along the leg    F = -m u''
        across it        I_t = m l^3 / (3 l_full) about the base joint, seen at the platform joint as g = I_t / l^2

    Along the leg it is hub inertia; across it adds inertia that grows with the length l, its rate of change included. The
    platform stays one rigid body: no constraint has to be closed. m is the mass of the strip of a deployed leg.

    In a loop: as hub inertia: the loop turns with the frequency squared. In a deployment: as hub inertia along the legs; and the
    longer the legs, the more slowly the platform swings and turns.
    """

    name = "leg-mass"
    mass_kg: float = parameter(0.0, low=0.0, high=5.0, typical=0.05, doc="mass of the strip at full length")

    @staticmethod
    def leg_mass(u: float, p: Any) -> float:
        """Inertia along the leg, kg."""
        return p[0]

    @staticmethod
    def leg_transverse(length: float, full_length: float, p: Any, g: Any) -> None:
        """Inertia across the leg at its platform joint, kg, and its slope over the length, kg/m."""
        slope = p[0] / (3.0 * full_length)
        g[0] += slope * length
        g[1] += slope
