"""An amplifier or a display smooths what it shows: it follows the truth with a time constant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit

from simulate.model.effect import Array, MeasurementEffect, parameter


@dataclass(frozen=True)
class SensorFilter(MeasurementEffect):
    """A low pass of first order in the channel of the load cell, and one in the channels of the camera.

        y' = (x - y) / tau,   y = x before the first sample

    Two time constants: the load cell's and the camera's. What is shown is late by tau, which a shifted clock does as well, and what
    changes within tau is flattened, which it does not; that part grows with tau squared. Between samples x is a cubic spline, for
    which y is exact.

    In a loop: the loop opens with the frequency, and the corners behind the reversals are rounded. In a deployment: every channel
    is late, and the impact at the stops is blunted.
    """

    name = "sensor-filter"
    remembers = True
    time_s: tuple[float, ...] = parameter(
        (0.0, 0.0),
        low=0.0,
        high=1.0,
        typical=0.002,
        starts=((0.002, 0.0), (0.01, 0.0), (0.0, 0.003), (0.005, 0.005), (0.0, 0.01), (0.0, 0.03)),
        linear=False,
        doc="time constant tau of the load cell, and of the camera",
    )

    def observe_force(self, time_s: Array, elongation_m: Array, force_N: Array) -> Array:
        """The force as the slow load cell shows it."""
        del elongation_m
        return low_pass(time_s, force_N[None], self.time_s[0])[0]

    def observe(self, time_s: Array, channels: Mapping[str, Array]) -> Mapping[str, Array]:
        """Every channel as the slow camera shows it."""
        shown = low_pass(time_s, np.stack([*channels.values()]), self.time_s[1])
        return dict(zip(channels, shown, strict=True))


def low_pass(time_s: Array, values: Array, tau_s: float) -> Array:
    """Channels (c, n) behind a low pass of first order, at rest before the first sample; from one on that is not finite none is.

    On a spline P = x - tau x' + tau^2 x'' - tau^3 x''' solves the equation, and what y is away from P fades as exp(-t / tau).
    """
    from scipy.interpolate import CubicSpline

    gone = np.flatnonzero(~np.isfinite(values).all(axis=0))
    n = int(gone[0]) if len(gone) else values.shape[1]
    if tau_s == 0.0 or n < 2:
        return values
    x = values[:, :n].T
    spline, h = CubicSpline(time_s[:n], x), np.diff(time_s[:n])[:, None]
    third, second, first, start = spline.c
    ends = (start, x[1:]), (first, first + h * (2.0 * second + 3.0 * h * third)), (second, second + 3.0 * h * third)
    before, behind = (x - tau_s * (v - tau_s * (2.0 * a - tau_s * 6.0 * third)) for x, v, a in zip(*ends, strict=True))
    shown = np.full(values.T.shape, np.nan)
    shown[0] = x[0]
    _fade(shown, before, behind, np.exp(-h[:, 0] / tau_s))
    return shown.T


@njit(cache=True)
def _fade(shown: Array, before: Array, behind: Array, faded: Array) -> None:
    """Fill what is shown (n + 1, c): off P before by so much, and behind it by what has not faded of that, (n, c) each."""
    for i in range(len(faded)):
        shown[i + 1] = behind[i] + (shown[i] - before[i]) * faded[i]
