"""The platform is heavier or lighter than the model file says."""

from __future__ import annotations

from dataclasses import dataclass

from simulate.model.effect import Bounds, ModelEffect, RigT, parameter
from simulate.model.measures import PROTOTYPE, Measures
from simulate.model.rig import Rig, altered


@dataclass(frozen=True)
class PlatformMass(ModelEffect):
    """A drawing or a balance was wrong: the mass differs by a constant, in every run alike; the inertia stays.

        M = M_model + dm

    Ballast that a run states comes on top. Pulley inertia resists vertical motion only; this resists motion in every direction.

    A loop does not show it. In a deployment: the platform is slower, as with pulley inertia, and so are lateral motion
    and rotation; a run with ballast is hardly touched.
    """

    name = "platform-mass"
    mass_kg: float = parameter(0.0, low=-1e3, high=1e3, typical=0.01, doc="added to the platform's mass, dm")

    def adjust(self, model: RigT) -> RigT:
        """The model with the other mass."""
        return altered(model, platform=altered(model.platform, mass_kg=model.platform.mass_kg + self.mass_kg))

    @classmethod
    def bounds(cls, model: Rig | None = None, measures: Measures = PROTOTYPE) -> Bounds:
        """As declared, and never below what leaves a tenth of the mass."""
        (name, (low, high)), *_ = super().bounds(None, measures).items()
        return {name: (low if model is None else -0.9 * model.platform.mass_kg, high)}
