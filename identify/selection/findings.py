"""What is said of each name: its parameters and how surely, and its share of the gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize, special

from identify.criteria import TWO_SIDED_95
from identify.estimation.parameters import STORED_FORCE
from identify.gap.size import NoiseOfChannel, share_closed
from identify.selection.hypotheses import Hypothesis
from identify.selection.stand import Stand, Weighed
from identify.selection.verdict import Finding, Verdict
from measure.common.arrays import Array
from simulate.effects import StoredForcePerRun
from simulate.model.effect import Effect

_TAIL, _FAR_OUT = 0.025, 10.0  # on either side of an interval; standard deviations from where one ends in any case
_AT_BOUND = 1e-3  # typical sizes
_STEP = 1e-4  # of a central difference, relative
_SHOWN = 0.95  # of the prior's standard deviation: a parameter that is no better known than before does not show


def moved_of(stand: Stand) -> tuple[tuple[Effect, float], ...]:
    """What of the model file was moved, and by how many tolerances (root mean square of its parameters), the farthest first."""
    sizes = dict(zip(stand.errors.keys, np.where(stand.free(), stand.sizes, 0.0), strict=True))
    made = [one for one in stand.errors.effects(stand.given, np.array(list(sizes.values()))) if one.name not in stand.names]
    rows = [(one, float(np.sqrt(np.mean([size**2 for (name, _), size in sizes.items() if name == one.name])))) for one in made]
    return tuple(sorted((row for row in rows if row[1] > 0.0), key=lambda row: -row[1]))


def findings_of(
    foremost: Hypothesis, sides: Sequence[Weighed], nothing: Hypothesis, verdict: Verdict, noise: Sequence[NoiseOfChannel]
) -> tuple[Finding, ...]:
    """The names of a verdict with their evidence, in order of weight.

    Parameters
    ----------
    sides : the foremost hypothesis where its numbers are stated, and wherever else films from one side may have it.
    """
    closed = share_closed(nothing.fit, foremost.fit, noise)
    logs = np.array([side.evidence.kept for side in sides])
    shares = np.exp(logs - np.logaddexp.reduce(logs))
    parts = [_on_all_sides([_estimated(side, name) for side in sides], shares) for name in verdict.names]
    whole = sum(part.strength for part in parts) or 1.0
    gain = 2.0 * (foremost.weighed.log_z - nothing.weighed.log_z)
    found = [
        Finding(
            part.effect,
            part.stderr,
            part.ci95,
            verdict.equivalents.get(part.effect.name, ()),
            float(special.chdtrc(max(part.count, 1), part.strength)),
            gain * part.strength / whole,
            closed * part.strength / whole,
            part.at_bound,
        )
        for part in parts
    ]
    return tuple(sorted(found, key=lambda finding: -finding.share))


def _on_all_sides(parts: Sequence[_Part], shares: Array) -> _Part:
    """The likeliest estimate, which comes first, with intervals over all sides on which the same may be."""
    first = parts[0]
    if len(parts) == 1:
        return first
    values, deviations = np.array([part.effect.flat() for part in parts]), np.array([part.stderr for part in parts])
    ci95 = first.ci95.copy()
    for k in np.flatnonzero(first.stderr > 0.0):  # what does not show there keeps its bounds
        ci95[k] = np.clip(_over_all(values[:, k], deviations[:, k], shares), *first.limits[:, k])
    return replace(first, ci95=ci95)


def _over_all(values: Array, deviations: Array, shares: Array) -> tuple[float, float]:
    """The middle 95 % of a mixture of normal distributions, the first of them known; where others are not, they say nothing."""
    known = deviations > 0.0
    at, size, share = values[known], deviations[known], shares[known] / float(shares[known].sum())
    ends = (float(np.min(at - _FAR_OUT * size)), float(np.max(at + _FAR_OUT * size)))

    def beyond(x: float, below: float) -> float:
        return float(share @ special.ndtr((x - at) / size)) - below

    low, high = (optimize.brentq(beyond, *ends, args=(below,)) for below in (_TAIL, 1.0 - _TAIL))
    return low, high  # type: ignore[return-value]


@dataclass(frozen=True)
class _Part:
    """An effect as estimated. strength : a' C^-1 a of its parameters that show, of which there are count. limits : (2, k) its bounds."""

    effect: Effect
    stderr: Array
    ci95: Array
    strength: float
    count: int
    at_bound: tuple[str, ...]
    limits: Array


def _estimated(found: Weighed, name: str) -> _Part:
    kind, scale, values, covariance, prior, ends = _raw(found, name)
    low, high = kind.flat() + ends * scale
    at = np.clip(kind.flat() + values * scale, low, high)
    effect, turned = _stated(kind.with_flat(at), low, high)
    own = turned @ (covariance * np.outer(scale, scale)) @ turned.T
    stderr = np.sqrt(np.maximum(np.diag(own), 0.0))
    shown = stderr < _SHOWN * prior * scale
    reach = TWO_SIDED_95 * stderr[:, None] * (-1.0, 1.0)
    ci95 = np.where(shown[:, None], np.clip(effect.flat()[:, None] + reach, low[:, None], high[:, None]), np.column_stack([low, high]))
    names = np.array(kind.flat_names())
    ends_there = np.array([name.partition("[")[0] not in kind.directions for name in names])
    near = shown & ends_there & ((values - ends[0] < _AT_BOUND) | (ends[1] - values < _AT_BOUND))
    at_bound = tuple(names[near].tolist())
    strength = _strength(values, covariance, np.sqrt(np.maximum(np.diag(covariance), 0.0)) < _SHOWN * prior)
    return _Part(effect, np.where(shown, stderr, np.nan), ci95, strength, int(shown.sum()), at_bound, np.array([low, high]))


def _strength(values: Array, covariance: Array, shown: NDArray[np.bool_]) -> float:
    """a' C^-1 a of those that show."""
    own = covariance[np.ix_(shown, shown)]
    return float(values[shown] @ np.linalg.pinv(own, hermitian=True) @ values[shown]) if shown.any() else 0.0


def _stated(fitted: Effect, low: Array, high: Array) -> tuple[Effect, Array]:
    """An effect as one states it, and how each of its numbers follows those fitted (n, n), by differences within the bounds."""
    stated, at = fitted.as_stated(), fitted.flat()
    if stated is fitted:
        return fitted, np.eye(len(at))
    slopes = []
    for place, step in enumerate(_STEP * np.maximum(np.abs(at), 1.0)):
        unit = step * np.eye(len(at))[place]
        ahead, behind = np.minimum(at + unit, high), np.maximum(at - unit, low)
        change = fitted.with_flat(ahead).as_stated().flat() - fitted.with_flat(behind).as_stated().flat()
        slopes.append(change / (ahead - behind)[place])
    return stated, np.stack(slopes, axis=1)


def _raw(found: Weighed, name: str) -> tuple[Effect, Array, Array, Array, Array, Array]:
    """The effect where the fit's parameters are zero; scale, values, covariance, prior spread and bounds (2, k) of these, in scales."""
    problem = found.fit.problem
    effect = next((one for one in problem.effects if one.name == name), None)
    if effect is not None:
        rows = problem.rows_of(name)
        covariance, prior = found.covariance[np.ix_(rows, rows)], found.stand.columns.spread[rows - problem.first_effect]
        return effect, problem.scales[rows], found.fit.q[rows], covariance, prior, found.stand.bounds[:, rows]
    return _forces(found)


def _forces(found: Weighed) -> tuple[Effect, Array, Array, Array, Array, Array]:
    """The same of stored forces, which are parameters of the releases; of runs that were not made they are as unknown as before."""
    problem, size = found.fit.problem, len(StoredForcePerRun().fraction)
    rows = np.array([i for i, one in enumerate(problem.parameters) if one.key == STORED_FORCE][:size])
    first, further = problem.parameters[rows[0]], size - len(rows)
    values = np.pad(found.fit.q[rows], (0, further))
    covariance = np.asarray(linalg.block_diag(found.covariance[np.ix_(rows, rows)], first.spread**2 * np.eye(further)))
    scale, prior = np.full(size, problem.scales[rows[0]]), np.full(size, first.spread)
    return StoredForcePerRun(), scale, values, covariance, prior, np.array([np.full(size, -0.9), np.full(size, 9.0)]) / scale
