"""Releases looked for again where films can be met before their stops and are missed behind them.

Behind the stops errors grow, and a release has several local minima there. A model that is right up to the stops and wrong behind
them has most likely found the wrong one; a model that is wrong before the stops already has no right one.
"""

from __future__ import annotations

from collections.abc import MutableMapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from identify.criteria import CLOSE, GAP_P, NEAR, ROUGHLY
from identify.estimation.horizons import before_the_stops, first_stop_s
from identify.estimation.least_squares import laid_out, solve, to_the_end
from identify.estimation.problem import Fit, Problem
from identify.gap.gap_test import gap_test
from measure.common.arrays import Array
from simulate.dispatch.threads import side_by_side

_MET = 1.25  # times the noise
_DRAWS, _FIRST_STEPS, _STEPS = 10, 5, 20
_FOR_ONE_KEPT = 3  # places that are tried for each that is followed to the end
_FARTHER = 0.7, 1.3  # times as far off
_REMEMBERED = 4  # local minima of a release

Minima: TypeAlias = MutableMapping[str, Sequence[Array]]
"""By the name of a run: the releases (k,) that are its deepest local minima, as some model has them."""


def released_again(fit: Fit, free: Sequence[int] | None = None, known: Minima | None = None) -> Fit:
    """The same fit, or a better one that another local minimum of a film's release leads to.

    Parameters
    ----------
    free : indices of the parameters that may move; by default all.
    known : minima found with other models of the same runs: those alone are tried then. What is found here is added.
    """
    if gap_test(fit).p_value > GAP_P or not (missed := _missed_behind_the_stops(fit)):
        return fit
    early = solve(before_the_stops(fit.problem), fit.q, free=free)
    if gap_test(early).p_value < GAP_P:
        return fit
    spread = early.covariance if free is None else _own_covariance(early, free)
    for index in missed:
        fit = from_elsewhere(fit, index, early.q, spread, free, known)
    return to_the_end(fit, free)


def _missed_behind_the_stops(fit: Fit) -> list[int]:
    """The films that are missed behind their stops; where the whole is hardly more than noise, every one that reaches them may be."""
    found = []
    for index, film in enumerate(fit.problem.films):
        stop = first_stop_s(replace(fit.problem, films=(film,)))
        parts = [(fit.part(block), film.time_s[block.samples]) for block in fit.problem.blocks if block.run == film.run.name]
        late = np.concatenate([gaps[time >= stop] for gaps, time in parts])
        if len(late) and (fit.rms < CLOSE or _rms(late) > _MET):
            found.append(index)
    return found


def _rms(gaps: Array) -> float:
    return float(np.sqrt(np.mean(gaps**2)))


def from_elsewhere(
    fit: Fit, index: int, early: Array, spread: Array, free: Sequence[int] | None = None, known: Minima | None = None
) -> Fit:
    """A film's release from many places, each followed into its local minimum by itself, and the whole fitted on from the deepest.

    Parameters
    ----------
    index : of the film. early, spread : parameters (k,) as the motion before the stops has them, and their covariance (k, k).
    free, known : as in `released_again`.
    """
    problem = fit.problem
    own = problem.of_release(index)
    first = own[0]
    alone = replace(problem, films=(problem.films[index],), loops=(), covariate="")  # nothing else depends on where the film was released
    own_alone = list(range(alone.first_nuisance, alone.first_nuisance + len(own)))
    unseen = [i - first for i in problem.unseen_of_release(index)]
    known, name = {} if known is None else known, problem.films[index].run.name
    places = known.get(name) or _places(fit.q[own], early[own], spread[np.ix_(own, own)], unseen)
    here, *starts = (laid_out(replace(fit, q=_with(fit.q, own, place)), alone) for place in (fit.q[own], *places))
    minima = _followed(alone, starts, own_alone)
    known.setdefault(name, [minimum.q[own_alone] for minimum in _distinct(minima)[:_REMEMBERED]])
    gaps = alone.gaps(here)
    # the rest was fitted to the local minimum the film stands in, so another shows how deep it is only when everything moves
    elsewhere = [_with(fit.q, own, minimum.q[own_alone]) for minimum in _distinct(minima, float(gaps @ gaps))[:2]]
    return min([fit, *(solve(problem, q, free=free) for q in elsewhere)], key=lambda f: f.cost)


def _followed(alone: Problem, starts: Sequence[Array], own: Sequence[int]) -> list[Fit]:
    """The local minima that a film's release leads to: a few steps from each of many places, on to the end from the deepest of them."""

    def led(places: Sequence[Array], steps: int) -> list[Fit]:
        found = side_by_side(lambda i: solve(alone, places[i], free=own, most_steps=steps, enough=ROUGHLY), len(places))
        return sorted(found, key=lambda fit: fit.cost)

    tried = led(starts, _FIRST_STEPS)
    kept = max(len(tried) // _FOR_ONE_KEPT, min(len(tried), 2))
    unfinished = [fit.q for fit in tried[:kept] if not fit.converged]
    return [fit for fit in tried if fit.converged] + led(unfinished, _STEPS)


def _places(here: Array, early: Array, spread: Array, unseen: Sequence[int]) -> list[Array]:
    """Releases (k,) as the motion before the stops allows them; and those there are with what is unseen of them turned any way.

    What a film does not show of a release acts on what it shows by its square, so that it tells how far off that was sooner
    than where to. Always the same draws, so always the same answer.
    """
    chance = np.random.default_rng(0)
    root = np.linalg.cholesky(spread + 1e-12 * np.eye(len(here)))
    places: list[Array] = [early + root @ chance.normal(size=len(here)) for _ in range(_DRAWS)]
    if not unseen:
        return places
    ways = chance.normal(size=(_DRAWS, len(unseen)))
    ways *= chance.uniform(*_FARTHER, size=(_DRAWS, 1)) * np.linalg.norm(here[unseen]) / np.linalg.norm(ways, axis=1, keepdims=True)
    return places + [_with(here, unseen, way) for way in ways]


def _distinct(minima: Sequence[Fit], here: float = np.inf) -> list[Fit]:
    """Those of different depth that are not far above the one the film stands in, the deepest first; mirror images are equally deep."""
    found: list[Fit] = []
    depths = [here]
    for minimum in sorted(minima, key=lambda f: f.cost):
        if minimum.cost < here + NEAR and all(abs(minimum.cost - depth) > ROUGHLY for depth in depths):
            found.append(minimum)
            depths.append(minimum.cost)
    return found


def _own_covariance(fit: Fit, free: Sequence[int]) -> Array:
    """The covariance of the parameters that moved, set into a matrix of all."""
    whole = np.zeros((len(fit.q), len(fit.q)))
    whole[np.ix_(list(free), list(free))] = fit.covariance
    return whole


def _with(q: Array, places: Sequence[int], values: Array) -> Array:
    changed = q.copy()
    changed[list(places)] = values
    return changed
