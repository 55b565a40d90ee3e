"""Spools that are coupled by a cable or a gear, so that all six turn together."""

from __future__ import annotations

from typing import ClassVar

from pydantic.dataclasses import dataclass

from simulate.control.synchronise import Synchronise
from simulate.model.control import Controller
from simulate.model.rig import CHECKED, NotNegative, Rig


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class MechanicalLink(Controller):
    """Each spool hangs on a common shaft (a ring of cable, a gear train) by a spring and a damper; the shaft follows the mean of all six.

        F_i = -k (u_i - mean u) - c (v_i - mean v) - m/6 mean u''

    k, c and the inertia of shaft and cable are seen along the strip. It has the energy m (mean v)^2 / 2 + k/2 sum (u_i - mean u)^2. A shaft
    without inertia stands at the mean exactly; one of mass m is ahead of it by m mean u'' / (6 k), which is left out.
    """

    law: ClassVar[str] = "mechanical-link"
    stiffness_N_per_m: NotNegative
    """k: stiffness between a spool and the shaft"""
    damping_N_s_per_m: NotNegative = 0.0
    """c: damping of the same"""
    shaft_mass_kg: NotNegative = 0.0
    """m: inertia of shaft, cable or gears"""

    def coupled_mass_kg(self) -> float:
        """The shaft."""
        return self.shaft_mass_kg

    def stiffness(self, model: Rig) -> tuple[float, float]:
        """The link of one leg."""
        del model
        return self.stiffness_N_per_m, self.damping_N_s_per_m

    command = staticmethod(Synchronise.command)  # against the mean of all six alike; the shaft's inertia is in the mass matrix
