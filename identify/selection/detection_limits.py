"""The smallest size of each effect that a campaign could have shown: what an answer of "nothing" is worth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from identify.estimation.fit import Fit
from identify.estimation.problem import Problem
from identify.selection.gap_test import EFFECT_P
from identify.selection.null_hypothesis import Family, gained_by
from identify.selection.screening import columns_of_shapes
from measure.common.arrays import Array
from simulate.model.effect import Effect

POWER = 0.9
_OCTAVES = np.arange(-6.0, 7.0)


@dataclass(frozen=True)
class Sight:
    """What could have been seen of one effect.

    sizes : for each parameter, alone, the smallest size that would be found nine times out of ten, in its unit, whatever the
    effect's shape (a frequency, a time constant) of those from which a search starts. easiest : the same for the shape that shows
    most. NaN where the measurements do not show it within its bounds, or base and releases can do the same.
    """

    effect: Effect
    sizes: Mapping[str, float]
    easiest: Mapping[str, float]


def sight(fit: Fit, effects: Sequence[Effect], noise: Array, tests: Family) -> tuple[Sight, ...]:
    """The smallest sizes that a fit of these measurements could have shown, effect by effect.

        size = (sqrt(chi^2_needed) + z_90) sqrt(inflation) / |free signature of one typical size|

    chi^2_needed is what a name asks for, all effects that are looked at counted; the inflation is that of slow noise.
    """
    single = -np.expm1(np.log1p(-EFFECT_P) / tests.tests)
    wanted = float(np.sqrt(stats.chi2.isf(single, 1)) + stats.norm.ppf(POWER)) * float(np.sqrt(fit.variance_inflation))
    return tuple(_sight(fit, effect, noise, wanted) for effect in effects)


def _sight(fit: Fit, effect: Effect, noise: Array, wanted: float) -> Sight:
    problem = fit.problem.with_another(effect)
    if effect.is_linear():
        looks = [_straight(fit.free_of_parameters(columns), noise, wanted) for _, _, columns in columns_of_shapes(fit, effect)]
    else:
        looks = [_bent(fit, problem, noise, wanted)]
    new = slice(len(fit.q), None)
    farthest = np.array([max(abs(parameter.low), abs(parameter.high)) for parameter in problem.parameters[new]])
    sizes = np.array(looks or [np.full(len(farthest), np.inf)])
    sizes[sizes > farthest] = np.inf
    ends = [np.where(np.isfinite(end), end * problem.scales[new], np.nan) for end in (sizes.max(axis=0), sizes.min(axis=0))]
    return Sight(effect, *(dict(zip(effect.flat_names(), end.tolist(), strict=True)) for end in ends))


def _straight(free: Array, noise: Array, wanted: float) -> Array:
    """Typical sizes of parameters whose signatures, (m, k) for one typical size, grow with them; infinitely many where nothing shows."""
    shown = np.linalg.norm(free, axis=0)
    inflations = np.array([_inflation(free[:, [i]], noise) for i in range(free.shape[1])])
    return np.divide(wanted * inflations, shown, out=np.full(len(shown), np.inf), where=shown > 1e-6)


def _inflation(free: Array, noise: Array) -> float:
    return float(np.sqrt(max(1.0, float(np.mean(gained_by(free, noise))))))


def _bent(fit: Fit, problem: Problem, noise: Array, wanted: float) -> Array:
    """Typical sizes of an effect that has no straight beginning (a gap that opens), all its parameters grown together."""
    new = slice(len(fit.q), None)
    steps = 2.0 ** _OCTAVES[:, None] * np.ones(len(problem.parameters[new]))
    low, high = (np.array([getattr(parameter, side) for parameter in problem.parameters[new]]) for side in ("low", "high"))
    inside = np.clip(steps, low, high)
    shown = []
    for gaps in problem.gaps_many([np.concatenate([fit.q, step]) for step in inside]):
        free = fit.free_of_parameters((gaps - fit.gaps)[:, None])
        shown.append(float(np.linalg.norm(free)) / _inflation(free, noise))
    seen = np.flatnonzero(np.array(shown) > wanted)
    return inside[seen[0]] if len(seen) else np.full(inside.shape[1], np.inf)
