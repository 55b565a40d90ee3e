"""The strips pushed more, or less, in one deployment than in another."""

from __future__ import annotations

from dataclasses import dataclass

from simulate.model.effect import ModelEffect, RigT, parameter
from simulate.model.rig import altered, per_leg

RUNS = 16


@dataclass(frozen=True)
class StoredForcePerRun(ModelEffect):
    """The stored force of all legs differs from run to run by a common factor: temperature, wear, another winding.

        b_l,run = b_l (1 + f_run)          b_u and the initial force by the same amount

    One fraction for each deployment of a campaign, in its order, sixteen at most. A deployment simulated by itself is the first.

    A loop does not show it. In a deployment: one run is faster from the start than another of the same condition, the other channels alike.
    """

    name = "stored-force-per-run"
    fraction: tuple[float, ...] = parameter((0.0,) * RUNS, low=-0.9, high=9.0, typical=0.005, doc="relative change of b_l, one a run")

    def in_run(self, index: int) -> StoredForcePerRun:
        """The effect as it is in one deployment of a campaign, which then stands first; nothing beyond the sixteenth."""
        own = self.fraction[index] if index < RUNS else 0.0
        return StoredForcePerRun((own, *(0.0,) * (RUNS - 1)))

    def adjust(self, model: RigT) -> RigT:
        """The model with the stored force of the first run."""
        if self.fraction[0] == 0.0:
            return model
        shift = self.fraction[0] * per_leg(model.actuator.b_l_N)
        return altered(model, actuator=model.actuator.shifted(tuple(shift.tolist())))
