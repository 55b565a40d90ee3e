"""Probabilities of failures that plain draws would never show: subset simulation.

A rare failure is reached by steps that are not rare. The runs that come nearest, a tenth, set the first threshold; chains that begin in
them and stay beyond it fill the next level, and so on, so that with a level of N runs and k of them

    P = 0.1^(k - 1) (runs beyond the limit in the last level) / N

Chains move by x' = r x + sqrt(1 - r^2) z, z standard normal, and are kept where they stay beyond the threshold; r follows their
acceptance. Sources: Au and Beck 2001, doi:10.1016/S0266-8920(01)00019-4; Papaioannou et al. 2015, doi:10.1016/j.probengmech.2015.06.006.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array

KEPT = 0.1  # of a level's runs
_MOST_LEVELS = 12
_WANTED = 0.44  # acceptance of the chains
_QUANTILE = 1.959963984540054
_ALIKE = 0.5  # correlation of the errors of neighbouring levels; without it intervals of known cases hold 87 instead of 95 %

State = Callable[[Array], Array]


@dataclass(frozen=True)
class RareFailure:
    """Probability of a failure, with its coefficient of variation; `thresholds` are those of the levels, `runs` all that were simulated.

    reached : False where the limit was not reached within all levels; `probability` is then an upper bound.
    """

    probability: float
    variation: float
    thresholds: tuple[float, ...]
    runs: int
    reached: bool

    @property
    def interval(self) -> tuple[float, float]:
        """95 %, of a lognormal estimate."""
        width = _QUANTILE * math.sqrt(math.log1p(self.variation**2))
        return self.probability * math.exp(-width), min(1.0, self.probability * math.exp(width))

    @property
    def report(self) -> dict[str, Any]:
        """As the JSON of a sweep gives it."""
        return {
            "probability": self.probability,
            "interval": self.interval if self.reached else (0.0, self.probability),
            "variation": self.variation,
            "thresholds": self.thresholds,
            "runs": self.runs,
            "reached": self.reached,
        }


def subset_simulation(state: State, factors: int, limit: float, runs: int, seed: int = 0) -> RareFailure:
    """Probability that the state goes beyond a limit.

    Parameters
    ----------
    state : of (runs, factors) independent standard normal numbers, (runs,), the larger the nearer to failure; infinite is failure.
    limit : failure is a state above it. runs : of each level, at least `limits.FEWEST_RARE`.

    Returns
    -------
    RareFailure. Its variation is put together from those of the levels, each with the correlation along its chains.
    """
    rng = np.random.default_rng([seed, 11])
    chains = max(1, round(KEPT * runs))
    length = round(1.0 / KEPT)
    places = rng.standard_normal((chains * length, factors))
    values = state(places)
    probability, parts, thresholds, spent, ratio = 1.0, [], [], len(values), 0.6
    inside = (values > limit).reshape(1, -1)  # (length of the chains, chains)
    for _ in range(_MOST_LEVELS):
        order = np.argsort(-values, kind="stable")[:chains]
        threshold = float(values[order[-1]])
        if threshold >= limit:
            break
        thresholds.append(threshold)
        parts.append(_variation((values > threshold).reshape(inside.shape)))
        probability *= KEPT
        places, values, ratio = _walked(state, places[order], values[order], threshold, length, ratio, rng)
        spent += chains * (length - 1)
        inside = (values > limit).reshape(length, chains)
    share = float(np.mean(values > limit))
    reached = share > 0.0
    parts.append(_variation(inside))
    return RareFailure(probability * share if reached else probability / len(values), _together(parts), tuple(thresholds), spent, reached)


def _together(parts: list[float]) -> float:
    """Coefficient of variation of the product of the levels' shares; a level's chains begin in runs of the one before."""
    neighbours = sum(one * other for one, other in pairwise(parts))
    return math.sqrt(sum(part * part for part in parts) + 2.0 * _ALIKE * neighbours)


def _walked(
    state: State, places: Array, values: Array, threshold: float, length: int, ratio: float, rng: np.random.Generator
) -> tuple[Array, Array, float]:
    """Chains from these places, side by side, each staying beyond the threshold; the first entry of each is where it begins."""
    found, worth = [places], [values]
    for _ in range(length - 1):
        along = math.sqrt(1.0 - ratio**2)
        tried = along * found[-1] + ratio * rng.standard_normal(places.shape)
        there = state(tried)
        kept = there >= threshold
        found.append(np.where(kept[:, None], tried, found[-1]))
        worth.append(np.where(kept, there, worth[-1]))
        ratio = float(np.clip(ratio * math.exp(float(np.mean(kept)) - _WANTED), 0.05, 1.0))
    return np.concatenate(found), np.concatenate(worth), ratio


def _variation(inside: NDArray[np.bool_]) -> float:
    """Coefficient of variation of a level's share; (length of the chains, chains), one row for independent runs."""
    count, share = inside.size, float(inside.mean())
    if share in (0.0, 1.0):
        return 1.0 - share
    off, length = inside - share, len(inside)
    lags = [float(np.mean(off[: length - lag] * off[lag:])) / (share * (1.0 - share)) for lag in range(1, length)]
    correlated = 2.0 * sum((1.0 - lag / length) * value for lag, value in enumerate(lags, 1))
    return math.sqrt((1.0 - share) / (share * count) * (1.0 + max(correlated, 0.0)))
