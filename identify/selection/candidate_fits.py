"""Effects that were screened, fitted together with everything else, and seen on runs left out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.estimation.fit import Fit
from identify.estimation.least_squares import NEAR, ROUGHLY, laid_out, solve, solve_from_afar, to_the_end
from identify.estimation.multistart import released_again, searched_everywhere
from identify.estimation.parameters import POSE
from identify.estimation.problem import Problem
from identify.selection.gap_test import GAP_P, Gain, Signature, gain, gap_test
from identify.selection.screening import Screened
from measure.common.arrays import Array
from simulate.model.effect import Effect

_SHORT_OF_PROMISE = 0.8
_ON_ITS_WAY = 2.0  # times the sum of squares that was promised
_FIRST_STEPS, _LAST_STEPS = 12, 20
_FEW = 3  # numbers of an effect


@dataclass(frozen=True)
class Candidate:
    """An effect fitted jointly with base and releases."""

    effect: Effect
    fit: Fit
    gain: Gain
    signature: Signature

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name


def fit_screened(before: Fit, screened: Screened) -> Candidate:
    """Fit an effect jointly, from one start after the other until the fit keeps what its signature promised; then from other shapes."""
    problem = before.problem.with_another(screened.effect)
    promised = before.cost - _SHORT_OF_PROMISE * screened.promise * before.variance_inflation
    found: Fit | None = None
    for start in _starts(problem, before, screened):
        fit = _fitted(problem, start, promised)
        found = fit if found is None or fit.cost < found.cost else found
        if found.cost <= promised:
            break
    assert found is not None
    for effect, start in screened.others:
        fit = _fitted(before.problem.with_another(effect), np.concatenate([before.q, start]), promised)
        found = fit if fit.cost < found.cost else found
    return Candidate(found.problem.effects[-1], found, gain(before, found), screened.signature)


def _starts(problem: Problem, before: Fit, screened: Screened) -> Iterator[Array]:
    """Where the fit of an effect may start: what its signature promises; releases as planned; its typical size, up and down.

    Releases farther from the plan than they can be have swallowed a part of what is missing; then the plan comes first, the
    effect not there yet, for straight lines from a release that cannot be led far astray.
    """
    promised = np.concatenate([before.q, screened.start])
    fresh = np.zeros_like(screened.start) if screened.effect.is_linear() else screened.start
    planned = np.concatenate([as_planned(before.problem, before.q), fresh])
    yield from (planned, promised) if gap_test(before).release_p < GAP_P else (promised, planned)
    yield from (np.concatenate([before.q, sign * np.ones_like(fresh)]) for sign in _signs(problem, len(before.q)))


def as_planned(problem: Problem, q: Array) -> Array:
    """The same parameters, every film released where it was planned to be."""
    planned = q.copy()
    planned[[i for i, parameter in enumerate(problem.parameters) if parameter.key in POSE]] = 0.0
    return planned


def _fitted(problem: Problem, start: Array, promised: float) -> Fit:
    """Fitted in a hurry; one that is on its way and falls short of what was promised is carried on."""
    found = solve(problem, start, most_steps=_FIRST_STEPS, enough=ROUGHLY)
    return _fitted_on(found) if promised < found.cost < _ON_ITS_WAY * promised and not found.converged else found


def _fitted_on(fit: Fit) -> Fit:
    return solve(fit.problem, fit.q, most_steps=_LAST_STEPS, enough=ROUGHLY)


def carried_on(before: Fit, tried: Sequence[Candidate]) -> list[Candidate]:
    """Candidates with those fitted on that come near the best and were cut off: who may stay must not hang on when that was."""
    near = min(c.fit.cost for c in tried) + NEAR
    return [c if c.fit.converged or c.fit.cost > near else _refitted(c, before, _fitted_on(c.fit)) for c in tried]


def carried_to_the_end(before: Fit, foremost: Sequence[Candidate]) -> list[Candidate]:
    """Candidates that were fitted up to the stops, or in a hurry, fitted whole.

    Once one of them leaves only noise, its releases, searched again, lie in the right minima; the others start from those. An effect more
    cannot fit worse than none: a fit that does has lost its way behind the stops, and begins again where nothing was added.
    """
    closing: Fit | None = None
    done: list[Candidate] = []
    for candidate in foremost:
        found = _whole(before, candidate) if closing is None else _whole_from(before, candidate, closing)
        if closing is None and gap_test(found).p_value > GAP_P:
            closing = found = searched_everywhere(found)
            done = [_better(before, one, closing) for one in done]
        done.append(_refitted(candidate, before, found))
    return [one if one.fit.cost <= before.cost else _refitted(one, before, _from_nothing(before, one)) for one in done]


def _from_nothing(before: Fit, candidate: Candidate) -> Fit:
    problem = candidate.fit.problem
    return to_the_end(solve(problem, np.concatenate([before.q, np.zeros(len(problem.parameters) - len(before.q))]), most_steps=_LAST_STEPS))


def _whole(before: Fit, candidate: Candidate) -> Fit:
    problem = before.problem.with_effects(candidate.fit.problem.effects)
    from_afar = released_again(solve_from_afar(problem, candidate.fit.q, most_steps=_LAST_STEPS))
    in_a_hurry = [to_the_end(candidate.fit)] if candidate.fit.problem.until_s == problem.until_s else []
    return min([from_afar, *in_a_hurry], key=lambda fit: fit.cost)


def _whole_from(before: Fit, candidate: Candidate, closing: Fit) -> Fit:
    """Fitted whole from the releases of another fit; one that comes near that fit is fitted in its own way too."""
    problem = before.problem.with_effects(candidate.fit.problem.effects)
    own = slice(problem.first_nuisance, problem.first_effect)
    start = candidate.fit.q.copy()
    start[own] = closing.q[own]
    found = to_the_end(solve(problem, start, most_steps=_LAST_STEPS))
    if found.cost < closing.cost or found.cost > closing.cost + NEAR:
        return found
    return min(found, _whole(before, candidate), key=lambda fit: fit.cost)


def _better(before: Fit, candidate: Candidate, closing: Fit) -> Candidate:
    """The candidate as it is, or fitted again from the releases of another."""
    again = _whole_from(before, candidate, closing)
    return _refitted(candidate, before, again) if again.cost < candidate.fit.cost else candidate


def _refitted(candidate: Candidate, before: Fit, fit: Fit) -> Candidate:
    return replace(candidate, fit=fit, gain=gain(before, fit))


def _signs(problem: Problem, first: int) -> tuple[float, ...]:
    """Which ways an effect of its typical size may go; of one with many numbers all of them at once are no likely place."""
    if len(problem.parameters) - first > _FEW:
        return ()
    return (1.0, -1.0) if all(parameter.low < -1.0 for parameter in problem.parameters[first:]) else (1.0,)


def held_out_rms(fit: Fit) -> float:
    """Gap over noise of measurements that took no part: each group of runs is left out in turn, the rest fitted.

    Films are left out one by one while the loops stay; without films, the loops of one frequency together. Of a film left
    out only its own release is fitted. The refits are steps along the fit's own straight lines.
    """
    parts = [_left_out(fit, fold) for fold in _folds(fit.problem)]
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2))) if parts else float("nan")


def _folds(problem: Problem) -> list[set[str]]:
    films = [film.run.name for film in problem.films]
    if films:
        return [{name} for name in films] if len(films) > 1 else []
    by_frequency: dict[float, set[str]] = {}
    for loop in problem.loops:
        by_frequency.setdefault(round(loop.data.frequency_Hz, 2), set()).add(loop.run.name)
    return list(by_frequency.values()) if len(by_frequency) > 1 else []


def _left_out(fit: Fit, fold: set[str]) -> Array:
    """The gaps of the runs of a fold, once base and effects have been fitted to the others and the fold's own releases to itself."""
    problem, size = fit.problem, len(fit.q)
    out = np.zeros(len(fit.gaps), dtype=bool)
    for block in problem.blocks:
        out[block.rows] = block.run in fold
    own = np.array([parameter.run in fold for parameter in problem.parameters])
    prior = np.arange(len(out)) >= problem.measured
    of_own = prior & np.any(fit.jacobian[:, own] != 0.0, axis=1)
    rest = ~out & ~of_own
    step = np.zeros(size)
    step[~own] = np.linalg.lstsq(fit.jacobian[np.ix_(rest, ~own)], -fit.gaps[rest], rcond=1e-12)[0]
    moved = fit.gaps + fit.jacobian @ step
    if own.any():
        seen = out | of_own
        moved = moved + fit.jacobian[:, own] @ np.linalg.lstsq(fit.jacobian[np.ix_(seen, own)], -moved[seen], rcond=1e-12)[0]
    return moved[out]


def carried_over(fit: Fit, other: Problem) -> Fit:
    """Other runs seen with the base and effects of a fit; only their own releases are fitted."""
    free = range(other.first_nuisance, other.first_effect)
    return released_again(solve_from_afar(other, laid_out(fit, other), free=free), free)
