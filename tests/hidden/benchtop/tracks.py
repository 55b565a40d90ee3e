"""Tables as cameras and load cells of a laboratory leave them: coloured noise, outliers, frames that are missing, steps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from board.campaigns import Shaking
from board.shaker import Stroke, loop_of
from scipy.signal import lfilter

from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory

Array = np.ndarray
Chance = np.random.Generator

_FAR = 8.0  # how far an outlier lies, in sigma


@dataclass(frozen=True)
class Track:
    """How a case is measured.

    lag1 : correlation from frame to frame of noise that remembers. outliers, missing : share of frames. step : in sigma, 0 for none.
    white : share of the noise's variance that does not remember.
    """

    lag1: float
    outliers: float
    missing: float
    step: float
    white: float = 0.0

    @property
    def colour(self) -> float:
        """By how much a mean over many frames is less sure than with white noise."""
        return float(np.sqrt(self.white + (1.0 - self.white) * (1.0 + self.lag1) / (1.0 - self.lag1)))


def drawn_track(chance: Chance) -> Track:
    """Correlation 0 to 0.8; outliers, missing frames, steps and a white part in some cases."""
    some = chance.random(4) < (0.5, 0.4, 0.3, 0.4)
    sizes = np.where(some, (0.01, 0.04, chance.uniform(0.5, 2.0), chance.uniform(0.2, 0.8)), 0.0)
    return Track(float(chance.uniform(0.0, 0.8)), *sizes.tolist())


def coloured(n: int, track: Track, chance: Chance) -> Array:
    """Noise of unit size, (n,): a part that remembers the sample before, and a white one."""
    innovations = chance.normal(0.0, 1.0, n)
    innovations[1:] *= np.sqrt(1.0 - track.lag1**2)
    remembers = np.asarray(lfilter([1.0], [1.0, -track.lag1], innovations))
    return np.sqrt(1.0 - track.white) * remembers + np.sqrt(track.white) * chance.normal(0.0, 1.0, n)


def tracked(table: Trajectory, sigma: dict[str, float], track: Track, zeroed: bool, chance: Chance) -> Trajectory:
    """A table without noise as this camera gives it."""
    n = len(table.time_s)
    kept = chance.random(n) >= track.missing
    kept[0] = True
    channels = {name: _measured(values, sigma[name], track, chance)[kept] for name, values in table.channels.items()}
    if zeroed:
        channels = {name: values - values[0] + table.channels[name][0] for name, values in channels.items()}
    stated = {name: values[kept] for name, values in table.sigma.items()}
    return Trajectory(table.time_s[kept], {name: np.round(values, 8) for name, values in channels.items()}, stated)


def _measured(values: Array, sigma: float, track: Track, chance: Chance) -> Array:
    noisy = values + sigma * coloured(len(values), track, chance)
    hit = chance.random(len(values)) < track.outliers
    hit[0] = False
    noisy = noisy + np.where(hit, sigma * _FAR * chance.normal(0.0, 1.0, len(values)), 0.0)
    step = track.step * sigma
    return np.round(noisy / step) * step if step > 0.0 else noisy


def recorded(shown_N: Array, stroke: Stroke, run: Shaking, cell: Track, chance: Chance) -> Loop:
    """A loop whose load cell has coloured noise."""
    noise = run.sigma_N * coloured(len(shown_N), cell, chance)
    return loop_of(shown_N + noise, stroke, replace(run, sigma_N=0.0), chance)
