"""A push: a force on the platform at the fewest places of a table that say what is missing.

It has no physics and is never a name. But where a push at one or two places says as much as effects with many parameters, these
have bent themselves around something that they are not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile

import numpy as np

from identify.estimation.fit import Fit
from identify.estimation.least_squares import bic, bic_penalty
from identify.gap.platform_force import (
    ALONGS,
    Along,
    MissingForce,
    fitted,
    named_leads,
    read,
    seen_parameters,
    with_table,
)
from identify.selection.comparison import RIVAL_P, STRONG_BIC
from identify.selection.null_hypothesis import SEED
from measure.common.arrays import Array

_MOST_PLACES = 4
_OPTIMISM = 1.25  # how much more than along straight lines a force may gain
_WORDS = SHORTEST = 2  # that a place costs: where, and how strong; no push is shorter
_DRAWS = 500
_LEFT = 1e-6  # of a column's length: what others have taken more of says nothing any more


@dataclass(frozen=True)
class Push:
    """A force at a few places of a table. bic : of its fit, every place at what it takes to say it.

    places : how many. tables : what a force at each place of each table does to the gaps, (m, k), freed of base and releases.
    """

    force: MissingForce
    bic: float
    places: int
    tables: tuple[Array, ...]


def push(before: Fit, reached: float) -> Push | None:
    """The force at the fewest places that base and releases leave over.

    None where no place is worth its words, or where straight lines promise nothing near the BIC that others have reached.
    """
    parameters = {along: [parameter for parameter in seen_parameters(before, along) if parameter >= len(before.q)] for along in ALONGS}
    tables = {along: _table(before, along, new) for along, new in parameters.items()}
    gaps = before.free_of_parameters(before.gaps[:, None])[:, 0]
    found = {along: _worth_saying(before, table, gaps) for along, table in tables.items()}
    along = max(found, key=lambda one: found[one][1] - _words(before, len(found[one][0])))
    places, gained = found[along]
    said = len(before.q) * bic_penalty(before.problem) + _words(before, len(places))
    if not places or before.cost - _OPTIMISM * gained + said > reached:
        return None
    fit = fitted(before, along, [*range(len(before.q)), *(parameters[along][place] for place in places)])
    leads = named_leads(along, {other: gained - found[other][1] for other in ALONGS}, gained)
    return Push(read(fit, along, leads), fit.cost + said, len(places), tuple(tables.values()))


def is_bent(before: Fit, rivals: Sequence[Fit], pushed: Push) -> bool:
    """Whether effects have bent themselves around a push: it says as much in far fewer words, as it seldom would of any of the rivals.

    A push follows the velocity of a release closely, being one at the start; so where a release cannot be told from a base that
    shakes, a push that the shaking would seldom resemble says nothing against the two.
    """
    fewer = all(bic(rival) > pushed.bic + STRONG_BIC for rival in rivals)
    return fewer and all(chance_of_push(before, rival, pushed) < RIVAL_P for rival in rivals)


def chance_of_push(before: Fit, after: Fit, pushed: Push) -> float:
    """How often a push at as many places would follow effects as closely as it does, if these were the truth.

    Were they the truth, their parameters could have pointed anywhere, and the places would have been chosen to suit:

        lead = |P_F g|^2 - max over tables of what the best places take of g,   g = F z + e        against that of the gap

    F what the effects' parameters do beyond base and releases, each in its typical size, z a random direction that gives F z the
    strength that was found, e noise. Few words are no virtue where a few places can follow most of what the effects can do.
    The gap's own lead is taken along the same straight lines: fitted whole, a push with all places to choose from bends more.
    """
    unit = after.variance_inflation * max(1.0, after.rms**2)
    strength = (before.cost - after.cost) / unit
    if strength <= 0.0:
        return 0.0
    gaps = before.free_of_parameters(before.gaps[:, None]) / np.sqrt(unit)
    effects, gaps, *tables = _in_one_frame([after.beyond(len(before.q)), gaps, *pushed.tables])
    left, sizes, _ = np.linalg.svd(effects, full_matrices=False)
    span = left[:, sizes > _LEFT * sizes[0]]
    chance = np.random.default_rng(SEED)
    directions = effects @ chance.normal(size=(effects.shape[1], _DRAWS))
    drawn = np.sqrt(strength) * directions / np.linalg.norm(directions, axis=0) + chance.normal(size=directions.shape)
    seen, *leads = (_lead(span, tables, one, pushed.places) for one in np.column_stack([gaps, drawn]).T)
    return float(np.mean(np.array(leads) <= seen))


def _lead(span: Array, tables: Sequence[Array], gaps: Array, places: int) -> float:
    """By how much effects of this span take more off the sum of squares than the best places of any table."""
    return float(np.sum((span.T @ gaps) ** 2)) - max(_gained(table, gaps, places) for table in tables)


def _in_one_frame(parts: Sequence[Array]) -> list[Array]:
    """Columns (m, k) by their coordinates in a frame that all of them span: lengths and angles stay as they are."""
    columns = np.column_stack(parts)
    norms = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    values, vectors = np.linalg.eigh((columns / norms).T @ (columns / norms))
    placed = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T * norms
    return np.split(placed, np.cumsum([part.shape[1] for part in parts])[:-1], axis=1)


def _table(before: Fit, along: Along, new: list[int]) -> Array:
    problem, start = with_table(before, along)
    return before.free_of_parameters(problem.jacobian(start, new, before.gaps)[1])


def _words(before: Fit, places: int) -> float:
    """What it costs to say so many places."""
    return _WORDS * places * bic_penalty(before.problem)


def _worth_saying(before: Fit, table: Array, gaps: Array) -> tuple[list[int], float]:
    """Places that join one by one while each gains more than its words cost, and what they gain linearly."""
    chosen = list(takewhile(lambda one: one[1] >= _words(before, 1), _best_places(table, gaps, _MOST_PLACES)))
    return [place for place, _ in chosen], sum(gain for _, gain in chosen)


def _gained(table: Array, gaps: Array, places: int) -> float:
    """What so many places take off the sum of squares."""
    return sum(gain for _, gain in _best_places(table, gaps, places))


def _best_places(free: Array, left: Array, most: int) -> Iterator[tuple[int, float]]:
    """The column that takes most off the sum of squares, the best one beside it, and so on, each with what it takes."""
    for _ in range(most):
        gains = _gains(free, left)
        best = int(np.argmax(gains))
        yield best, float(gains[best])
        way = free[:, best] / np.linalg.norm(free[:, best])
        left = left - way * float(way @ left)
        free = free - np.outer(way, way @ free)


def _gains(free: Array, left: Array) -> Array:
    """What each column alone takes off the sum of squares; nothing, where nothing of it is left."""
    norms = np.linalg.norm(free, axis=0)
    shown = norms > _LEFT * max(float(norms.max()), 1e-300)
    return np.where(shown, (free.T @ left) ** 2 / np.where(shown, norms, 1.0) ** 2, 0.0)
