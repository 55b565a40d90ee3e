"""One-way clutches: a leg uncoils freely and cannot be pushed back."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from pydantic.dataclasses import dataclass

from simulate.model.control import Controller, slope_at_rest
from simulate.model.rig import CHECKED, Positive, Rig


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class OneWay(Controller):
    """A leg uncoils freely; against coiling stands the friction of a clutch, which holds up to its force.

    F = -F_c tanh(v / v_0)   while v < 0,      v_0 the brake speed
    """

    law: ClassVar[str] = "one-way"
    clutch_force_N: Positive
    """F_c: force up to which a clutch holds"""
    clutch_speed_m_per_s: Positive = 0.01
    """v_0: speed at which it has set in"""

    def stiffness(self, model: Rig) -> tuple[float, float]:
        """The slope of the clutch at rest as far as it decides on stability."""
        del model
        return 0.0, slope_at_rest(self.clutch_force_N, self.clutch_speed_m_per_s)

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Force of each clutch, N."""
        for leg in range(6):
            out[leg] = -p[0] * math.tanh(min(v[leg], 0.0) / p[1])
