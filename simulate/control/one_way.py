"""One-way clutches: a leg uncoils freely and cannot be pushed back."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from pydantic.dataclasses import dataclass

from simulate.model.control import Controller
from simulate.model.rig import CHECKED, Positive


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

    def dry_friction(self) -> tuple[float, float]:
        """That of the clutch."""
        return self.clutch_force_N, self.clutch_speed_m_per_s

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Force of each clutch, N."""
        for leg in range(6):
            out[leg] = -p[0] * math.tanh(min(v[leg], 0.0) / p[1])
