"""The platform turns more heavily, or more lightly, than the model file says."""

from __future__ import annotations

from dataclasses import dataclass

from simulate.model.effect import ModelEffect, RigT, parameter
from simulate.model.rig import altered


@dataclass(frozen=True)
class PlatformInertia(ModelEffect):
    """The principal moments of inertia differ by a part of themselves each.

    I_k = I_k,model (1 + e_k)          k = x, y, z

    A loop does not show it. In a deployment: the elevation hardly changes; swing and rotation are slower, or faster, by half of the part.
    """

    name = "platform-inertia"
    fraction: tuple[float, ...] = parameter((0.0,) * 3, low=-0.9, high=9.0, typical=0.05, doc="relative error of each principal moment, e")

    def adjust(self, model: RigT) -> RigT:
        """The model with the other inertia."""
        x, y, z = (i * (1.0 + e) for i, e in zip(model.platform.inertia_kg_m2, self.fraction, strict=True))
        return altered(model, platform=altered(model.platform, inertia_kg_m2=(x, y, z)))
