"""Releases looked for again where films can be met before their stops and are missed behind them.

Behind the stops errors grow, and a release has several valleys there. A model that is right up to the stops and wrong behind
them has most likely found the wrong one; a model that is wrong before the stops already has no right one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from measure.tables import Array

from .evidence import GAP_P, gap_test
from .fit import ROUGHLY, Fit, before_the_stops, first_stop_s, laid_out, solve, to_the_end

_MET = 1.25  # times the noise
_DRAWS, _TRIED = 120, 5
_STEPS = 12
_ALIKE, _DEEPER = 1e-3, 0.01  # relative to the sum of squares


def released_again(fit: Fit, free: Sequence[int] | None = None) -> Fit:
    """The same fit, or a better one that another valley of a film's release leads to.

    Parameters
    ----------
    free : indices of the knobs that may move; by default all.
    """
    missed = _missed_behind_the_stops(fit)
    if gap_test(fit).p_value > GAP_P or not missed:
        return fit
    early = solve(before_the_stops(fit.problem), fit.q, free=free)
    if gap_test(early).p_value < GAP_P:
        return fit
    return to_the_end(_searched(fit, early, missed, free), free)


def searched_everywhere(fit: Fit) -> Fit:
    """The same fit, or a better one: every film's release looked for again, whether or not the film seems to have strayed.

    A wrong valley can be so shallow that it is only told from noise by an effect that mends it.
    """
    early = solve(before_the_stops(fit.problem), fit.q)
    return to_the_end(_searched(fit, early, range(len(fit.problem.films))))


def _searched(fit: Fit, early: Fit, films: Sequence[int], free: Sequence[int] | None = None) -> Fit:
    spread = early.covariance if free is None else _own_covariance(early, free)
    for index in films:
        fit = _from_elsewhere(fit, index, early.q, spread, free)
    return fit


def _missed_behind_the_stops(fit: Fit) -> list[int]:
    """The films that are missed behind their stops; a fit in a wrong valley can miss them before these, too, for the sake of the rest."""
    found = []
    for index, film in enumerate(fit.problem.films):
        stop = first_stop_s(replace(fit.problem, films=(film,)))
        parts = [(fit.part(block), film.time_s[block.samples]) for block in fit.problem.blocks if block.run == film.run.name]
        late = np.concatenate([gaps[time >= stop] for gaps, time in parts])
        if len(late) and _rms(late) > _MET:
            found.append(index)
    return found


def _rms(gaps: Array) -> float:
    return float(np.sqrt(np.mean(gaps**2)))


def _from_elsewhere(fit: Fit, index: int, early: Array, spread: Array, free: Sequence[int] | None) -> Fit:
    """A film's release from many places that its motion before the stops allows, and the whole fitted on from the best.

    The places are drawn from the covariance of the fit that ends at the stop; always the same draws, so always the same answer.
    """
    problem = fit.problem
    first = problem.first_nuisance + sum(len(own) for own in problem.own_knobs[:index])
    own = list(range(first, first + len(problem.own_knobs[index])))
    chance = np.random.default_rng(0)
    root = np.linalg.cholesky(spread[np.ix_(own, own)] + 1e-12 * np.eye(len(own)))
    starts = [_with(fit.q, own, early[own] + root @ chance.normal(size=len(own))) for _ in range(_DRAWS)]
    alone = replace(problem, films=(problem.films[index],), loops=(), covariate="")  # nothing else depends on where the film was released
    places = [laid_out(replace(fit, q=q), alone) for q in (fit.q, *starts)]
    costs = [float(gaps @ gaps) for gaps in alone.gaps_beside(places)[1:]]
    valleys: list[Fit] = []
    for i in np.argsort(costs)[:_TRIED]:
        valleys.append(solve(problem, starts[i], free=own, most_steps=_STEPS, enough=ROUGHLY))
        if _deeper_twice(valleys, fit):
            break
    # the rest was fitted to the wrong valley, so a valley shows how deep it is only when everything moves
    elsewhere = [valley for valley in _distinct(valleys) if abs(valley.cost - fit.cost) > ROUGHLY]
    return min([fit, *(solve(problem, valley.q, free=free) for valley in elsewhere)], key=lambda f: f.cost)


def _deeper_twice(valleys: Sequence[Fit], fit: Fit) -> bool:
    """Whether two ways have led into the same valley and it is well below the one the fit stands in."""
    depths = sorted(valley.cost for valley in valleys)[:2]
    return len(depths) == 2 and depths[1] < depths[0] * (1.0 + _ALIKE) and depths[0] < fit.cost * (1.0 - _DEEPER)


def _distinct(valleys: Sequence[Fit]) -> list[Fit]:
    """The two deepest of different depth; mirror images are equally deep."""
    found: list[Fit] = []
    for valley in sorted(valleys, key=lambda f: f.cost):
        if all(abs(valley.cost - other.cost) > _ALIKE * other.cost for other in found):
            found.append(valley)
    return found[:2]


def _own_covariance(fit: Fit, free: Sequence[int]) -> Array:
    """The covariance of the knobs that moved, set into a matrix of all."""
    whole = np.zeros((len(fit.q), len(fit.q)))
    whole[np.ix_(list(free), list(free))] = fit.covariance
    return whole


def _with(q: Array, places: Sequence[int], values: Array) -> Array:
    changed = q.copy()
    changed[list(places)] = values
    return changed
