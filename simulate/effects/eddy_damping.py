"""A metal disc turns in a magnetic field and is braked by the currents in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class EddyDamping(LegEffect):
    """The brake is viscous at low speed, strongest at v_0, and weaker again beyond, where its own field drives the other one out.

        F = -c v / (1 + (v / v_0)^2),   largest at v = v_0:  c v_0 / 2

    v_0 follows from thickness, conductivity and radius of the disc and from the gear to the strip. Well below v_0 it cannot be told from
    viscous friction.

    In a loop: the branches move apart with the frequency up to v_0 and close again beyond; a fast loop is pinched at mid-stroke. In a
    deployment: it holds back at the release and at the stops, and lets go in between.
    """

    name = "eddy-damping"
    damping_N_s_per_m: float = parameter(
        0.0, low=0.0, high=100.0, typical=0.05, doc="damping at low speed, c", source="Smythe 1942; Wouterse 1991"
    )
    speed_m_per_s: float = parameter(
        0.1, low=1e-3, high=10.0, typical=0.1, starts=(0.01, 0.03, 0.1, 0.3, 1.0), doc="speed of the largest force, v_0"
    )

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """Force along the leg, N."""
        relative = v / p[1]
        return -p[0] * v / (1.0 + relative * relative)
