"""Six legs are not six times the same leg."""

from __future__ import annotations

from dataclasses import dataclass

from simulate.model.effect import ModelEffect, RigT, parameter
from simulate.model.rig import altered


@dataclass(frozen=True)
class LegDisparity(ModelEffect):
    """The stored force of each leg differs from the common one: both asymptotes are shifted alike.

        b_l,i = b_l + d_i          b_u,i = b_u + d_i          initial force + d_i

    Aridon 2009, section 4: 1e-3 N is enough to turn the platform by a few degrees.

    A loop shows one leg and so cannot show it. In a deployment: rotation and lateral motion grow from the release on, theta_z most;
    the elevation hardly changes.
    """

    name = "leg-disparity"
    force_N: tuple[float, ...] = parameter(
        (0.0,) * 6,
        low=-5.0,
        high=5.0,
        typical=0.01,
        doc="shift of the stored force, one value a leg",
        source="Aridon 2009, section 4",
        mirror="legs",
    )

    def adjust(self, model: RigT) -> RigT:
        """The model with six different legs."""
        return altered(model, actuator=model.actuator.shifted(self.force_N))
