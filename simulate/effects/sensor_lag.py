"""The load cell is late."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simulate.model.effect import Array, MeasurementEffect, parameter


@dataclass(frozen=True)
class SensorLag(MeasurementEffect):
    """The force is shown later than the elongation of the same moment: a filter, or two clocks.

        F_shown(t) = F(t - d)

    In a loop it opens or closes the hysteresis with the frequency, as friction would.

    In a loop: the loop opens, or closes, in proportion to the frequency, and at mid-stroke most. A deployment does not show it, for
    it has no load cell.
    """

    name = "sensor-lag"
    delay_s: float = parameter(0.0, low=-0.1, high=0.1, typical=0.002, doc="the force is this late, d")

    def observe_force(self, time_s: Array, elongation_m: Array, force_N: Array) -> Array:
        """The force as the late cell shows it; before the first sample it holds."""
        del elongation_m
        return np.interp(np.asarray(time_s) - self.delay_s, time_s, force_N)
