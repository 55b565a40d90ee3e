"""The camera's clock started elsewhere, or does not run at the rate it says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simulate.model.effect import Array, MeasurementEffect, parameter


@dataclass(frozen=True)
class TimeOffset(MeasurementEffect):
    """The measured clock shows another time than the rig's, in every run alike.

        t_shown = (1 + r) t + t_0

    The offset of a single run is a nuisance (release instant); the rate, and an offset common to all runs, are this effect.

    A loop does not show it. In a deployment: the curves are shifted along the time, or stretched, and otherwise unchanged.
    """

    name = "time-offset"
    offset_s: float = parameter(0.0, low=-0.5, high=0.5, typical=0.002, doc="shown at the true time zero")
    rate_fraction: float = parameter(0.0, low=-0.2, high=0.2, typical=0.002, doc="the clock gains this much")

    def true_time(self, shown_s: Array) -> Array:
        """The rig's time at which the camera's clock showed `shown_s`."""
        return (np.asarray(shown_s) - self.offset_s) / (1.0 + self.rate_fraction)
