"""The pulley of the counterweight has to be spun up by every vertical motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import PlatformEffect, parameter


@dataclass(frozen=True)
class PulleyInertia(PlatformEffect):
    """Extra inertia of the vertical motion alone.

    F_z = -m z''          m = J / r^2

    A loop does not show it. In a deployment: the elevation is slower, as of a heavier body; lateral motion and rotations are not.
    """

    name = "pulley-inertia"
    mass_kg: float = parameter(0.0, low=0.0, high=5.0, typical=0.1, doc="pulley inertia J seen through its radius r")

    @staticmethod
    def platform_mass(pose: Any, p: Any, mass: Any) -> None:
        """Adds to the vertical mass, kg."""
        mass[14] += p[0]
