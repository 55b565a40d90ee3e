"""While little strip is out its section has not opened fully, and it pushes less."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simulate.model.effect import LegEffect, parameter


@dataclass(frozen=True)
class TransitionZone(LegEffect):
    """The zone between flat coil and curved strip needs length to form; until then force is missing.

        F = -dF exp(-u / L)          u >= 0; no more than dF below

    Aridon 2009, section 3.2: the force is nearly constant once more than 0.25 m is unrolled, so L is some 0.1 m. It is a force
    and no asymptote, so that the release does not begin with a jump that beta has to relax.

    In a loop: only a loop close to the stowed length shows it: both branches droop at its short end. In a deployment: the start is
    slower; once the zone has formed the elevation runs parallel to the one without it, later by a constant time.
    """

    name = "transition-zone"
    force_N: float = parameter(
        0.0, low=-3.0, high=3.0, typical=0.1, doc="force missing at the stowed length, dF", source="Aridon 2009, section 3.2"
    )
    length_m: float = parameter(
        0.08, low=5e-3, high=1.0, typical=0.08, starts=(0.02, 0.08, 0.3), doc="over this elongation it falls to 37 %, L"
    )

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """Force along the leg, N."""
        return -p[0] * math.exp(-max(u, 0.0) / p[1])
