"""Eddy-current dampers on the spools: no contact, no electronics, a force that follows the speed."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic.dataclasses import dataclass

from simulate.model.control import Controller
from simulate.model.rig import CHECKED, NotNegative, Positive, Rig


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class EddyDamper(Controller):
    """A damper on each spool, whose force follows the speed up to that at which its field no longer gets into the disc.

    F = -c v / (1 + (v / v_c)^2)

    Dampers slow all legs down; the speeds of the legs then keep the ratio of their forces, so that of the rotation little is taken away.
    """

    law: ClassVar[str] = "eddy-damper"
    damping_N_s_per_m: NotNegative
    """c: damping at small speed, seen along the strip"""
    critical_speed_m_per_s: Positive = 10.0
    """v_c: speed at which the force is largest"""

    def stiffness(self, model: Rig) -> tuple[float, float]:
        """The damper at rest."""
        del model
        return 0.0, self.damping_N_s_per_m

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Force of each damper, N."""
        for leg in range(6):
            x = v[leg] / p[1]
            out[leg] = -p[0] * v[leg] / (1.0 + x * x)
