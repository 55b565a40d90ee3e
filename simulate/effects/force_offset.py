"""The load cell was not tared, or its zero drifts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simulate.model.effect import Array, MeasurementEffect, parameter


@dataclass(frozen=True)
class ForceOffset(MeasurementEffect):
    """A constant and a drift are added to every force.

    F_shown = F + f + d t

    In a loop: the loop lies higher or lower as a whole, or creeps from cycle to cycle. A deployment does not show it, for it has no
    load cell.
    """

    name = "force-offset"
    force_N: float = parameter(0.0, low=-1000.0, high=1000.0, typical=0.05, doc="shown without load, f")
    drift_N_per_s: float = parameter(0.0, low=-100.0, high=100.0, typical=0.01, doc="growth of the zero, d")

    def observe_force(self, time_s: Array, elongation_m: Array, force_N: Array) -> Array:
        """The force as the cell with the wrong zero shows it."""
        del elongation_m
        return force_N + self.force_N + self.drift_N_per_s * np.asarray(time_s)
