"""The end-stops are stiffer or softer than the model file says."""

from __future__ import annotations

from dataclasses import dataclass

from simulate.model.effect import ModelEffect, RigT, parameter
from simulate.model.rig import altered


@dataclass(frozen=True)
class StopStiffness(ModelEffect):
    """The stiffness of all stops differs by a part of itself.

    k = k_model (1 + e)

    A loop does not show it. In a deployment: nothing changes up to the stops; then the rebound comes sooner or later.
    """

    name = "stop-stiffness"
    fraction: float = parameter(0.0, low=-0.95, high=20.0, typical=0.1, doc="relative error of the stiffness, e")

    def adjust(self, model: RigT) -> RigT:
        """The model with the other stops."""
        return altered(model, end_stop=altered(model.end_stop, stiffness_N_per_m=model.end_stop.stiffness_N_per_m * (1.0 + self.fraction)))
