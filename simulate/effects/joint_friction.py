"""The joints at both ends of a leg do not turn freely."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from simulate.dispatch.lanes import inverse_root
from simulate.model.effect import Effect, parameter


@dataclass(frozen=True)
class JointFriction(Effect):
    """A moment against the rotation at each of the twelve joints, viscous and dry.

        M = -(c + m / sqrt(w^2 + w_0^2)) w          w_0 = 0.02 rad/s

    w is the leg's rotation at its base joint, and the platform's against the leg at the platform joint; a leg does not
    spin about itself. The moments reach the platform directly and as forces across the legs.

    A loop does not show it. In a deployment: lateral motion and rotations are damped; the elevation is late by little, for the legs
    turn slowly.
    """

    name = "joint-friction"
    acts_on = "joints"
    damping_N_m_s: float = parameter(0.0, low=0.0, high=1.0, typical=1e-3, doc="viscous part, c")
    moment_N_m: float = parameter(0.0, low=0.0, high=0.5, typical=2e-3, doc="dry part, m")

    @staticmethod
    def joint_resistance(rate: float, p: Any) -> float:
        """Moment over angular speed, N m s."""
        return p[0] + p[1] * inverse_root(rate * rate + 4e-4)
