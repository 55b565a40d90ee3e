"""The stops give back less, or more, than the model says."""

from __future__ import annotations

from dataclasses import dataclass

from simulate.model.effect import Bounds, ModelEffect, RigT, parameter
from simulate.model.measures import PROTOTYPE, Measures
from simulate.model.rig import Rig, altered


@dataclass(frozen=True)
class EndStopDissipation(ModelEffect):
    """The damping of the stops differs from the model's by a constant, the same at every leg.

        c = c_model + dc

    It is a difference, so zero switches it off; it cannot take away more than there is.

    A loop does not show it. In a deployment: nothing changes up to the stops; then the rebound is lower, and feeds the rotation
    less, the larger the damping.
    """

    name = "end-stop-dissipation"
    damping_N_s_per_m: float = parameter(0.0, low=-1.0e4, high=1.0e4, typical=0.5, doc="added to the damping of each stop")

    def adjust(self, model: RigT) -> RigT:
        """The model with the changed stops."""
        return altered(model, end_stop=altered(model.end_stop, damping_N_s_per_m=model.end_stop.damping_N_s_per_m + self.damping_N_s_per_m))

    @classmethod
    def bounds(cls, model: Rig | None = None, measures: Measures = PROTOTYPE) -> Bounds:
        """As declared, and never below what leaves the stop without any damping."""
        (name, (low, high)), *_ = super().bounds(None, measures).items()
        return {name: (low if model is None else -model.end_stop.damping_N_s_per_m, high)}
