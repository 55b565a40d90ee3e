"""Legs held together: each is braked by what it is ahead of the mean of all six."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic.dataclasses import dataclass

from simulate.model.control import SampledController
from simulate.model.rig import CHECKED, NotNegative


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class Synchronise(SampledController):
    """A leg that is ahead of the mean of all six, or faster, is held back.

        F_i = -s_i clip(s_i (k (u_i - mean u) + d (v_i - mean v)), 0, limit),      s_i = tanh(v_i / v_0)

    with brakes; motors give F_i = -clip(k (u_i - mean u) + d (v_i - mean v), -limit, limit). The platform turns about the vertical because
    legs with unequal forces uncoil unequally; brakes need no more force than the forces differ by.
    """

    law: ClassVar[str] = "synchronise"
    stiffness_N_per_m: NotNegative
    """k: force for what a leg is ahead by"""
    damping_N_s_per_m: NotNegative
    """d: force for what it is faster by"""

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Forces against what each leg is ahead by, N."""
        place = (u[0] + u[1] + u[2] + u[3] + u[4] + u[5]) / 6.0
        speed = (v[0] + v[1] + v[2] + v[3] + v[4] + v[5]) / 6.0
        for leg in range(6):
            out[leg] = -p[0] * (u[leg] - place) - p[1] * (v[leg] - speed)
