"""What is said of each name: its parameters and how surely, its share of the gap; and the noise that everything is measured by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from identify.criteria import EFFECT_SPREAD, TWO_SIDED_95
from identify.estimation.parameters import STORED_FORCE
from identify.selection.explanation import NoiseOfChannel, share_closed
from identify.selection.hypotheses import Hypothesis
from identify.selection.stand import Weighed
from identify.selection.verdict import Finding, Verdict
from measure.common.arrays import Array
from simulate.effects import StoredForcePerRun
from simulate.model.effect import Effect

_OUTLIER = 4.0  # scales of Student's t
_AT_BOUND = 1e-3  # typical sizes
_SHOWN = 0.95  # of the prior's standard deviation: a parameter that is no better known than before does not show


def noise_of_channels(found: Weighed) -> tuple[NoiseOfChannel, ...]:
    """The noise of every run and channel under a hypothesis: what it leaves, outliers apart, root mean square, and how that remembers."""
    problem = found.fit.problem
    sigmas = {(film.run.name, name): float(np.nanmedian(film.sigma[i])) for film in problem.films for i, name in enumerate(film.channels)}
    sigmas |= {(loop.run.name, "force_N"): loop.data.force_sigma_N for loop in problem.loops}
    made = []
    for block, noise, left in zip(problem.blocks, found.evidence.noise, found.evidence.left, strict=True):
        far = np.abs(left) > _OUTLIER
        over = noise.scale * float(np.sqrt(np.mean(left[~far] ** 2) / (1.0 - noise.lag1**2)))
        outliers = 100.0 * float(np.mean(far))
        sigma = over * sigmas[block.run, block.channel]
        made.append(NoiseOfChannel(block.run, block.channel, sigma, noise.lag1, outliers, block.rows, over))
    return tuple(made)


def findings_of(foremost: Hypothesis, nothing: Hypothesis, verdict: Verdict, noise: Sequence[NoiseOfChannel]) -> tuple[Finding, ...]:
    """The names of a verdict with their evidence, in order of weight."""
    closed = share_closed(nothing.fit, foremost.fit, noise)
    parts = [_estimated(foremost.weighed, name) for name in verdict.names]
    whole = sum(part.strength for part in parts) or 1.0
    gain = 2.0 * (foremost.weighed.log_z - nothing.weighed.log_z)
    found = [
        Finding(
            part.effect,
            part.stderr,
            part.ci95,
            verdict.equivalents.get(part.effect.name, ()),
            float(stats.chi2.sf(part.strength, max(part.count, 1))),
            gain * part.strength / whole,
            closed * part.strength / whole,
            part.at_bound,
        )
        for part in parts
    ]
    return tuple(sorted(found, key=lambda finding: -finding.share))


@dataclass(frozen=True)
class _Part:
    """An effect as estimated. strength : a' C^-1 a of its parameters that show, of which there are count."""

    effect: Effect
    stderr: Array
    ci95: Array
    strength: float
    count: int
    at_bound: tuple[str, ...]


def _estimated(found: Weighed, name: str) -> _Part:
    kind, scale, values, covariance, prior, ends = _raw(found, name)
    stderr = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    shown = stderr < _SHOWN * prior
    strength = 0.0
    if shown.any():
        own = covariance[np.ix_(shown, shown)]
        strength = float(values[shown] @ np.linalg.pinv(own, hermitian=True) @ values[shown])
    plain = kind.flat()
    effect = kind.with_flat(np.clip(plain + values * scale, plain + ends[0] * scale, plain + ends[1] * scale))
    low, high = plain + ends[0] * scale, plain + ends[1] * scale
    at = effect.flat()
    reach = TWO_SIDED_95 * stderr * scale
    ci95 = np.clip(np.column_stack([at - reach, at + reach]), low[:, None], high[:, None])
    ci95[~shown] = np.column_stack([low, high])[~shown]
    near = shown & ((values - ends[0] < _AT_BOUND) | (ends[1] - values < _AT_BOUND))
    names = np.array(kind.flat_names())
    return _Part(effect, np.where(shown, stderr * scale, np.nan), ci95, strength, int(shown.sum()), tuple(names[near].tolist()))


def _raw(found: Weighed, name: str) -> tuple[Effect, Array, Array, Array, Array, Array]:
    """The effect where the fit's parameters are zero; scale, values, covariance, prior spread and bounds (2, k) of these, in scales."""
    problem = found.fit.problem
    effect = next((one for one in problem.effects if one.name == name), None)
    if effect is not None:
        rows = problem.rows_of(name)
        return (
            effect,
            problem.scales[rows],
            found.fit.q[rows],
            found.covariance[np.ix_(rows, rows)],
            np.minimum([problem.parameters[k].spread for k in rows], EFFECT_SPREAD),
            found.stand.bounds[:, rows],
        )
    return _forces(found)


def _forces(found: Weighed) -> tuple[Effect, Array, Array, Array, Array, Array]:
    problem = found.fit.problem
    rows = np.array([i for i, one in enumerate(problem.parameters) if one.key == STORED_FORCE][: len(StoredForcePerRun().fraction)])
    size = len(StoredForcePerRun().fraction)
    values, covariance, prior = np.zeros(size), np.eye(size), np.full(size, 1.0)
    count = len(rows)
    values[:count] = found.fit.q[rows]
    covariance[:count, :count] = found.covariance[np.ix_(rows, rows)]
    prior[:count] = problem.parameters[rows[0]].spread if count else 1.0
    scale = np.full(size, problem.scales[rows[0]] if count else 0.005)
    return StoredForcePerRun(), scale, values, covariance, prior, np.array([np.full(size, -0.9), np.full(size, 9.0)]) / scale
