"""A counterweight over a pulley moves only with the vertical."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.model.effect import PlatformEffect, parameter


@dataclass(frozen=True)
class CounterweightInertia(PlatformEffect):
    """The mass that the counterweight adds is felt vertically only; sideways and in rotation there is less.

        m_x, m_y and inertias = what the model has, times f;   m_z stays

    The paper doubles the mass in every direction; with its mass factor of 2 a true pulley has f = 0.5. Halving the
    rotational inertia alone moves the largest rotation before the stops by some 10 deg.

    A loop does not show it. In a deployment: the elevation stays; lateral motion and rotations are faster, as of a lighter body.
    """

    name = "counterweight-inertia"
    lateral_mass_factor: float = parameter(1.0, low=0.2, high=1.0, typical=0.7, doc="on lateral mass and rotational inertia, f")

    @staticmethod
    def platform_mass(pose: Any, p: Any, mass: Any) -> None:
        """Scales what is not vertical of the bare platform's mass matrix."""
        mass[0] *= p[0]
        mass[7] *= p[0]
        for i in range(3, 6):
            for j in range(3, 6):
                mass[6 * i + j] *= p[0]
