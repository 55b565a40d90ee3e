"""Effects of the catalogue tried on what a fit of loops leaves: screened by their signatures, the foremost fitted jointly."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from identify.actuator.actuator_fit import Trial
from identify.actuator.effect_starts import starts_with_effects
from identify.actuator.loops_alone import HELD_IN_LOOPS, searched, variants
from identify.actuator.rounding import rounded_only
from identify.criteria import SURE_EFFECT
from identify.estimation.covariance import scatter
from identify.estimation.estimates import away_from_turns
from identify.estimation.least_squares import solve
from identify.estimation.parameters import amplitudes_of
from identify.estimation.problem import Fit, Problem
from identify.loops.loop_data import first_cycles
from identify.noise.effective_number import effective_number
from measure.common.arrays import Array
from simulate.effects import CATALOGUE, ForceOffset, RateDependentAsymptotes
from simulate.model.effect import Effect

_FOREMOST, _FITTED = 3, 1  # effects, and starts of each beside that which its signature leads to
_STEPS = 12
_SAMPLES = 12_000  # of all loops, that effects are tried on
_POOR = 2.0  # times the noise: the law may have gone astray
_SAME_SIGNATURE = 4.0  # independent samples, two standard deviations of one number


@dataclass(frozen=True)
class Screened:
    """An effect and what its signature promises to take from the sum of squares.

    p_value : how often noise gives so much, all its shapes counted. signature : (m,) what it takes from the gaps. start : parameters
    that its signature leads to.
    """

    kind: type[Effect]
    promise: float
    p_value: float
    signature: Array
    start: Array


def shortened(fit: Fit, samples: int) -> Fit:
    """The fit to the first cycles of each loop, about so many samples in all; the fit itself where there are no more."""
    counts = [int(run.data.used.sum()) for run in fit.problem.loops]
    if sum(counts) <= samples:
        return fit
    runs = tuple(replace(run, data=first_cycles(run.data, max(samples // len(counts), 1))) for run in fit.problem.loops)
    return solve(replace(fit.problem, loops=runs), fit.q)


def kinds_for(fit: Fit, kinds: Sequence[type[Effect]] | None = None) -> list[type[Effect]]:
    """Effects that a shaker shows and that are not in the fit; polynomials of the rate have an option of their own."""
    there = {effect.name for effect in fit.problem.effects}
    listed = CATALOGUE.values() if kinds is None else kinds
    return [k for k in listed if k.acts_on_shaker() and k.name not in there and k is not RateDependentAsymptotes]


def tried(fit: Fit, kinds: Sequence[type[Effect]] | None = None) -> tuple[Trial, ...]:
    """The effects that are surely there, the one that explains most first; nothing where only noise is left.

    Parameters
    ----------
    kinds : effects to try; by default those of the catalogue.
    """
    if rounded_only(fit):
        return ()
    fit = shortened(fit, _SAMPLES)
    screened = sorted((_screened(fit, kind) for kind in kinds_for(fit, kinds)), key=lambda one: -one.promise)
    looked = max(len(screened), 1)
    worth = _distinct([one for one in screened if one.p_value < SURE_EFFECT / looked], max(fit.variance_inflation, 1.0))[:_FOREMOST]
    if fit.rms > _POOR and ForceOffset not in {one.kind for one, _ in worth}:  # a drift can lead the law itself far astray
        worth += [(one, ()) for one in screened if one.kind is ForceOffset]
    made = [replace(trial, alike=alike) for one, alike in worth if (trial := _fitted(fit, one, looked)) is not None]
    return tuple(sorted(made, key=lambda trial: -trial.delta_bic))


def _with(problem: Problem, kind: type[Effect]) -> Problem:
    return replace(problem.with_another(kind()), changes=(*problem.changes, *HELD_IN_LOOPS))


def _screened(fit: Fit, kind: type[Effect]) -> Screened:
    """The best of an effect's shapes by what its signature takes away, as far as the signs that physics allows let it."""
    problem = _with(fit.problem, kind).with_exact_motion()
    off = np.concatenate([fit.q, np.zeros(len(problem.parameters) - len(fit.q))])
    best, rows, shapes = Screened(kind, 0.0, 1.0, np.zeros(len(fit.gaps)), off), _rows_that_tell(fit, kind), 0
    for table, low, high, at in _signatures(problem, kind, off, len(fit.q)):
        shapes += 1
        free = fit.free_of_parameters(table)
        size = np.linalg.norm(free, axis=0)
        if not np.any(size > 1e-6 * np.linalg.norm(table, axis=0)):
            continue
        share = np.clip(np.linalg.lstsq(free, -fit.gaps, rcond=1e-8)[0], low, high)
        left = fit.gaps + free @ share
        promise = float(np.sum(fit.gaps[rows] ** 2) - np.sum(left[rows] ** 2))
        if promise > best.promise:
            p_value = float(chi2.sf(promise / _unit(fit, left), free.shape[1]))
            best = Screened(kind, promise, p_value, free @ share, at(share, fit, table))
    return replace(best, p_value=min(best.p_value * max(shapes, 1), 1.0))


def _rows_that_tell(fit: Fit, kind: type[Effect]) -> NDArray[np.bool_]:
    """Rows (m,) in which an effect is looked for: an inertia not beside reversals, where a motion that turns sharply is not known."""
    return away_from_turns(fit) if kind.leg_mass is not None else np.ones(len(fit.gaps), dtype=bool)


Place = Callable[[Array, Fit, Array], Array]


def _signatures(problem: Problem, kind: type[Effect], off: Array, first: int) -> Iterator[tuple[Array, Array, Array, Place]]:
    """What an effect does to the gaps, (m, amplitudes), with the bounds of its amplitudes; for each shape, or each size of a play.

    With them comes where a share of it leads to: all other parameters as they follow it.
    """
    if not kind.is_linear() and not any(amplitudes_of(kind)[1]):
        gaps = problem.gaps(off)
        for q in list(starts_with_effects(problem, off[:first]))[1:]:
            yield (problem.gaps(q) - gaps)[:, None], np.zeros(1), np.full(1, np.inf), lambda share, fit, table, q=q: q
        return
    free = [first + k for k, amplitude in enumerate(amplitudes_of(kind)[0]) if amplitude and not problem.held[first + k]]
    low, high = (bound[free] - off[free] for bound in problem.bounds)
    for shape in kind().starts():
        q = off.copy()
        q[first:] = (shape.flat() - kind().flat()) / problem.scales[first:]
        yield (
            problem.jacobian(q, free)[1],
            low,
            high,
            lambda share, fit, table, q=q, free=free: _followed(problem, q, free, share, fit, table),
        )


def _followed(problem: Problem, q: Array, free: list[int], share: Array, fit: Fit, table: Array) -> Array:
    """Parameters with an effect's amplitudes at a share, and all others where they follow it."""
    place, kept = q.copy(), np.flatnonzero(fit.clear_of_bounds)
    place[free] += share
    place[kept] -= np.linalg.lstsq(fit.jacobian[:, kept], fit.gaps + table @ share, rcond=1e-10)[0]
    return np.clip(place, *problem.bounds)


def _unit(fit: Fit, left: Array) -> float:
    """Of a sum of squares, one independent sample's worth of the residual that is left."""
    blocks = [left[block.rows] for block in fit.problem.blocks]
    independent = sum(effective_number(part) for part in blocks)
    power = sum(float(part @ part) for part in blocks)
    return max(power / max(independent, 1.0), fit.problem.measured / max(independent, 1.0))


def _distinct(screened: Sequence[Screened], unit: float) -> list[tuple[Screened, tuple[str, ...]]]:
    """Each effect with those behind it whose signature differs from its own by less than noise does.

    Parameters
    ----------
    unit : of a sum of squares, one independent sample's worth of noise.
    """
    kept: list[tuple[Screened, list[str]]] = []
    for one in screened:
        twins = [names for other, names in kept if _apart(one.signature, other.signature) < _SAME_SIGNATURE * unit]
        if twins:
            twins[0].append(one.kind.name)
        elif np.any(one.signature):
            kept.append((one, []))
    return [(one, tuple(names)) for one, names in kept]


def _apart(signature: Array, other: Array) -> float:
    """Sum of squares of a signature that is no multiple of another."""
    power = float(other @ other)
    return float(np.sum((signature - float(signature @ other) / power * other) ** 2)) if power > 0.0 else float(signature @ signature)


def _fitted(fit: Fit, one: Screened, looked: int) -> Trial | None:
    """The effect fitted jointly, from its best starts; None where it gains no more than noise does."""
    problem = _with(fit.problem, one.kind)
    begun = [(own, q) for own in variants(problem, len(fit.problem.effects)) for q in list(starts_with_effects(own, fit.q))[1:]]
    nearest = sorted(begun, key=lambda pair: float(np.sum(pair[0].with_exact_motion().gaps(pair[1]) ** 2)))[:_FITTED]
    nearest += [(own, one.start) for own in variants(problem, len(fit.problem.effects))[:1]]
    nearest += [(problem, searched(problem))] if fit.rms > _POOR else []
    found = min((roughly(own, q) for own, q in nearest), key=lambda f: f.cost, default=None)
    if found is None or found.cost >= fit.cost:
        return None
    count, unit = int(np.count_nonzero(~found.problem.held[len(fit.q) :])), _unit(found, found.gaps)
    along = max(unit, _unit_along(found, fit.free_of_parameters(fit.gaps - found.gaps)))
    rows = _rows_that_tell(fit, one.kind)
    gained = float(np.sum(fit.gaps[rows] ** 2) - np.sum(found.gaps[rows] ** 2))
    p_value = min(float(chi2.sf(gained / along, count)) * looked, 1.0)
    independent = max(fit.problem.measured / max(found.variance_inflation, 1.0), 2.0)
    bic = gained / unit - count * float(np.log(independent))
    return Trial(one.kind.name, solve(found.problem, found.q), fit, p_value, bic) if p_value < SURE_EFFECT else None


def _unit_along(found: Fit, change: Array) -> float:
    """Of a sum of squares, what noise of the residual's own spectrum puts into the signature (m,) that an effect was found by.

        e = s' W s / s' s

    W is the covariance of the noise, as in `sandwich`, and of the turning points. A slow creep of the force holds many samples and few
    independent ones; an effect that is slow itself imitates it, and by the average sample its gain would be far too sure.
    """
    power, turned = float(change @ change), float(change @ found.problem.turned(found.q, found.gaps))
    rows = [block.rows for block in found.problem.blocks]
    noise = sum(float(scatter(change[part, None], found.gaps[part])[0, 0]) for part in rows)
    return (noise + turned**2) / max(power, 1e-300)


def roughly(problem: Problem, start: Array) -> Fit:
    """A fit that stops where the sum of squares hardly falls any more."""
    return solve(problem, start, most_steps=_STEPS, loosely=True)


@dataclass(frozen=True)
class OutOfStep:
    """The score of a delay between the channels: whether a force that came a little later or earlier would fit better."""

    fit: Fit
    lag: type[Effect]

    @cached_property
    def widened(self) -> Array:
        """What a delay that is neither seen nor excluded adds to the covariance, (k, k), in scales.

            C_w = w d d',   w = 1 / (1 + exp((ln n - z^2) / 2))

        d is what the most likely delay moves the parameters by, z its score in standard errors, n the effective number of samples: two
        models, with and without a delay, weighed by BIC (Burnham and Anderson 2002, section 4.3).
        """
        problem = _with(self.fit.problem, self.lag).with_exact_motion()
        first, nothing = len(self.fit.q), np.zeros((len(self.fit.q),) * 2)
        table = problem.jacobian(np.append(self.fit.q, 0.0), [first])[1]
        free = self.fit.free_of_parameters(table)[:, 0]
        power = float(free @ free)
        if power < 1e-12 * float(np.sum(table**2)):
            return nothing
        delay = -float(free @ self.fit.gaps) / power
        left = self.fit.gaps + delay * free
        score = delay**2 * power / _unit(self.fit, left)
        independent = max(self.fit.problem.measured / max(self.fit.variance_inflation, 1.0), 2.0)
        weight = 1.0 / (1.0 + float(np.exp(np.clip((np.log(independent) - score) / 2.0, -50.0, 50.0))))
        moved = np.zeros(first)
        kept = self.fit.clear_of_bounds
        moved[kept] = -np.linalg.lstsq(self.fit.jacobian[:, kept], table[:, 0] * delay, rcond=1e-12)[0]
        return weight * np.outer(moved, moved)
