"""The smallest size of each effect that a campaign could have shown: what an answer of "nothing" is worth."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy import special

from identify.criteria import CREDIBLE
from identify.gap.linear_pieces import Gain
from identify.gap.size import DetectionLimit
from identify.selection.first_look import Promise
from identify.selection.hypotheses import Prior
from measure.common.arrays import Array
from simulate.model.effect import Effect
from simulate.model.measures import Measures

POWER = 0.9


def detection_limits(promised: Iterable[Promise], prior: Prior, measures: Measures) -> tuple[DetectionLimit, ...]:
    """The limits of all effects that were weighed beside a fit."""
    return tuple(_limit(one.shape, one, prior, measures) for one in promised if one.shape is not None and one.looks)


def _limit(effect: Effect, promise: Promise, prior: Prior, measures: Measures) -> DetectionLimit:
    names, typical = effect.flat_names(), effect.typical(measures)
    odds = prior(()) - prior((promise.name,)) + float(np.log(CREDIBLE / (1.0 - CREDIBLE)))
    sizes = np.array([_sizes(found, shown, odds) for found, shown in promise.looks])
    ends = [np.where(np.isfinite(end), end * typical, np.nan) for end in (sizes.max(axis=0), sizes.min(axis=0))]
    return DetectionLimit(effect, *(dict(zip(names, end.tolist(), strict=True)) for end in ends))


def _sizes(found: Gain, shown: NDArray[np.bool_], odds: float) -> Array:
    """Smallest sizes, in typical ones, (n,), of the parameters in one shape.

        size = (sqrt(2 (ln(T / s) + odds)) + z_90) s

    s the standard deviation of the parameter alone, T that of its prior: the gain a^2 / 2 s^2 - ln(T / s) has to overcome the odds.
    """
    spread = found.columns.spread
    information = np.diag(np.linalg.pinv(found.covariance)) - spread**-2.0
    alone = 1.0 / np.sqrt(np.maximum(information, 1e-300))
    need = np.sqrt(2.0 * np.maximum(np.log(np.maximum(spread / alone, 1.0)) + odds, 0.0)) + float(special.ndtri(POWER))
    farthest = np.maximum(np.abs(found.columns.low), np.abs(found.columns.high))
    sizes = np.full(len(shown), np.inf)
    sizes[np.flatnonzero(shown)] = np.where(need * alone <= farthest, need * alone, np.inf)
    return sizes
