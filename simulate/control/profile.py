"""Legs that follow a profile: a smooth way from the stowed to the full length in a given time."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic.dataclasses import dataclass

from simulate.model.control import SampledController
from simulate.model.rig import CHECKED, LEGS, NotNegative, Positive, Rig, stroke_of


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class Profile(SampledController):
    """Each leg is held to a way that is given in advance, so that the stops are reached slowly.

        F_i = -k (u_i - r_i) - d (v_i - r_i'),      r_i = stroke_i (10 x^3 - 15 x^4 + 6 x^5),      x = t / duration

    within what brakes or motors can do. The way has no speed and no acceleration at either end. Brakes can only make a deployment slower
    than it is by itself, so the duration has to be longer than that.
    """

    law: ClassVar[str] = "profile"
    constants: ClassVar[int] = LEGS
    duration_s: Positive
    """time from the release to the full length"""
    stiffness_N_per_m: NotNegative
    """k: force for what a leg is ahead of its way"""
    damping_N_s_per_m: NotNegative
    """d: force for what it is faster"""

    def constants_of(self, model: Rig) -> tuple[float, ...]:
        """Stroke of each leg, m."""
        return tuple(float(stroke) for stroke in stroke_of(model))

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Forces against what each leg is ahead of its way, N."""
        x = min(t / p[0], 1.0)
        share = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
        rate = 30.0 * x * x * (1.0 - x) * (1.0 - x) / p[0]
        for leg in range(6):
            out[leg] = -p[1] * (u[leg] - p[3 + leg] * share) - p[2] * (v[leg] - p[3 + leg] * rate)
