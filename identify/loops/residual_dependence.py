"""What a residual still contains: on which quantity it depends, if on any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identify.loops.loop_data import LoopData
from measure.common.arrays import Array

_BINS = 16
_WORTH_NAMING = 0.15


@dataclass(frozen=True)
class Dependence:
    """Shares of the residual's variance that a smooth curve in each quantity explains, and the sentence made of them."""

    shares: dict[str, float]
    sentence: str

    @property
    def strongest(self) -> str:
        """The quantity with the largest share."""
        return max(self.shares, key=lambda name: self.shares[name])


def depends_on(loops: Sequence[LoopData], residuals: Sequence[Array]) -> Dependence:
    """Which of elongation, speed, acceleration, time and force rate the residual follows.

    For each quantity the samples of all loops are put into sixteen bins of equal count; the share is that of the bin means
    in the residual's variance, in odd cycles predicted from even ones and the other way round, so that noise explains
    nothing. Time is counted within each loop.
    """
    left = np.concatenate(residuals)
    half = np.concatenate([_halves(d) for d in loops])
    shares = {name: _share(np.concatenate([_quantity(d, name) for d in loops]), left, half) for name in _NAMES}
    name = max(shares, key=lambda key: shares[key])
    noise = float(np.sqrt(np.mean([d.force_sigma_N**2 for d in loops])))
    ratio = float(np.sqrt(np.mean(left**2))) / max(noise, 1e-300)
    if shares[name] < _WORTH_NAMING:
        tail = "it looks like noise" if ratio < 1.5 else f"it is {ratio:.1f} times the noise of the samples all the same"
        return Dependence(shares, f"nothing that was looked at ({', '.join(_NAMES)}); {tail}")
    return Dependence(shares, f"{name}: explains {100 * shares[name]:.0f} % of the residual, which is {ratio:.1f} times the noise")


_NAMES = ("speed", "elongation", "acceleration", "time")


def _quantity(data: LoopData, name: str) -> Array:
    columns = {
        "speed": data.speed_m_per_s,
        "elongation": data.elongation_m,
        "acceleration": data.acceleration_m_per_s2,
        "time": data.time_s - data.time_s[0],
    }
    return columns[name][data.used]


def _halves(data: LoopData) -> Array:
    """0 or 1 for each sample that counts, changing from cycle to cycle."""
    turns = np.asarray(data.cycles.reversals[::2])
    return (np.searchsorted(turns, np.flatnonzero(data.used)) % 2).astype(float)


def _share(x: Array, left: Array, half: Array) -> float:
    edges = np.quantile(x, np.linspace(0.0, 1.0, _BINS + 1)[1:-1])
    place = np.searchsorted(edges, x)
    predicted = np.empty_like(left)
    for part in (0.0, 1.0):
        learnt, told = half == part, half != part
        count = np.maximum(np.bincount(place[learnt], minlength=_BINS), 1)
        predicted[told] = (np.bincount(place[learnt], left[learnt], minlength=_BINS) / count)[place[told]]
    power = float(np.sum(left**2))
    return max(0.0, 1.0 - float(np.sum((left - predicted) ** 2)) / power) if power > 0.0 else 0.0
