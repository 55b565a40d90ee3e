"""The smallest size of each effect that a campaign could have shown: what an answer of "nothing" is worth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from measure.tables import Array
from simulate.effect import Effect

from .chance import Family, gained_by
from .evidence import EFFECT_P
from .fit import Fit
from .problem import Problem

POWER = 0.9
_OCTAVES = np.arange(-6.0, 7.0)


@dataclass(frozen=True)
class Sight:
    """What could have been seen of one effect.

    sizes : for each parameter, alone, the smallest size that would be found nine times out of ten, in its unit; NaN where
    the measurements do not show it, or base and releases can do the same.
    """

    effect: Effect
    sizes: Mapping[str, float]


def sight(fit: Fit, effects: Sequence[Effect], noise: Array, tests: Family) -> tuple[Sight, ...]:
    """The smallest sizes that a fit of these measurements could have shown, effect by effect.

        size = (sqrt(chi^2_needed) + z_90) sqrt(inflation) / |free signature of one typical size|

    chi^2_needed is what a name asks for, all effects that are looked at counted; the inflation is that of slow noise.
    """
    single = -np.expm1(np.log1p(-EFFECT_P) / tests.tests)
    wanted = float(np.sqrt(stats.chi2.isf(single, 1)) + stats.norm.ppf(POWER))
    return tuple(_sight(fit, effect, noise, wanted * float(np.sqrt(fit.dilution))) for effect in effects)


def _sight(fit: Fit, effect: Effect, noise: Array, wanted: float) -> Sight:
    problem = fit.problem.with_another(effect)
    here = np.concatenate([fit.q, np.zeros(len(effect.flat()))])
    new = range(len(fit.q), len(here))
    if effect.is_straight():
        free = fit.free_of_knobs(problem.jacobian(here, new, fit.gaps)[1])
        sizes = [_straight(free[:, [i]], noise, wanted) for i in range(free.shape[1])]
    else:
        steps = 2.0 ** _OCTAVES[:, None] * np.ones(len(new))
        sizes = [_bent(fit, [np.concatenate([fit.q, step]) for step in steps], problem, noise, wanted)] * len(new)
    return Sight(effect, dict(zip(effect.flat_names(), np.array(sizes) * problem.scales[len(fit.q) :], strict=True)))


def _straight(free: Array, noise: Array, wanted: float) -> float:
    """Typical sizes of a parameter whose signature grows with it; infinitely many are none."""
    shown = float(np.linalg.norm(free))
    return wanted * _inflation(free, noise) / shown if shown > 1e-6 else float("nan")


def _inflation(free: Array, noise: Array) -> float:
    return float(np.sqrt(max(1.0, float(np.mean(gained_by(free, noise))))))


def _bent(fit: Fit, points: Sequence[Array], problem: Problem, noise: Array, wanted: float) -> float:
    """Typical sizes of an effect that has no straight beginning (a gap that opens), all its parameters grown together."""
    low, high = np.array([k.low for k in problem.knobs]), np.array([k.high for k in problem.knobs])
    inside = [np.clip(point, low, high) for point in points]
    shown = []
    for gaps in problem.gaps_many(inside):
        free = fit.free_of_knobs((gaps - fit.gaps)[:, None])
        shown.append(float(np.linalg.norm(free)) / _inflation(free, noise))
    seen = np.flatnonzero(np.array(shown) > wanted)
    return float(2.0 ** _OCTAVES[seen[0]]) if len(seen) else float("nan")
