"""The centre of mass is not where the model has it."""

from __future__ import annotations

from dataclasses import dataclass

from simulate.model.effect import ModelEffect, RigT, parameter
from simulate.model.rig import altered


@dataclass(frozen=True)
class CentreOfMassOffset(ModelEffect):
    """A battery or a cable moves the centre of mass within the platform; its inertia about the centre of mass stays.

    c = c_model + d          platform frame

    A loop does not show it. In a deployment: the platform tilts as soon as the legs push, and moves sideways; the elevation hardly
    changes.
    """

    name = "centre-of-mass-offset"
    offset_m: tuple[float, ...] = parameter(
        (0.0,) * 3, low=-0.1, high=0.1, typical=0.002, doc="shift within the platform frame, d", mirror="shift"
    )

    def adjust(self, model: RigT) -> RigT:
        """The model with its mass elsewhere."""
        x, y, z = (a + b for a, b in zip(model.platform.centre_of_mass_m, self.offset_m, strict=True))
        return altered(model, platform=altered(model.platform, centre_of_mass_m=(x, y, z)))
