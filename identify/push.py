"""A push: a force on the platform at the fewest places of a table that say what is missing.

It has no physics and is never a name. But where a push at one or two places says as much as effects with many parameters, these
have bent themselves around something that they are not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from measure.tables import Array

from .fit import Fit, price
from .missing_force import ALONGS, Along, MissingForce, fitted, named_leads, read, seen_knobs, with_table

_MOST_PLACES = 4
_OPTIMISM = 1.25  # how much more than along straight lines a force may gain
_WORDS = SHORTEST = 2  # that a place costs: where, and how strong; no push is shorter


@dataclass(frozen=True)
class Push:
    """A force at a few places of a table. bic : of its fit, every place at what it takes to say it."""

    force: MissingForce
    bic: float


def push(before: Fit, bic: float) -> Push | None:
    """The force at the fewest places that base and releases leave over.

    None where no place is worth its words, or where straight lines promise nothing near a BIC that others have reached.
    """
    found = {along: _chosen(before, along) for along in ALONGS}
    along = max(found, key=lambda one: found[one][1] - _words(before, found[one][0]))
    places, gained = found[along]
    said = len(before.q) * price(before.problem) + _words(before, places)
    if not places or before.cost - _OPTIMISM * gained + said > bic:
        return None
    fit = fitted(before, along, [*range(len(before.q)), *places])
    leads = named_leads(along, {other: gained - found[other][1] for other in ALONGS}, gained)
    return Push(read(fit, along, leads), fit.cost + said)


def _words(before: Fit, places: list[int]) -> float:
    """What it costs to say these places."""
    return _WORDS * len(places) * price(before.problem)


def _chosen(before: Fit, along: Along) -> tuple[list[int], float]:
    """Places of a table, as knobs, that join one by one while each gains more than its words cost; and what they gain linearly."""
    problem, start = with_table(before, along)
    new = [knob for knob in seen_knobs(before, along) if knob >= len(before.q)]
    free = before.free_of_knobs(problem.jacobian(start, new, before.gaps)[1])
    left, gained = before.free_of_knobs(before.gaps[:, None])[:, 0], 0.0
    chosen: list[int] = []
    while len(chosen) < _MOST_PLACES:
        gains = _gains(free, left)
        best = int(np.argmax(gains))
        if gains[best] < _words(before, [best]):
            break
        chosen.append(new[best])
        gained += float(gains[best])
        way = free[:, best] / np.linalg.norm(free[:, best])
        left = left - way * float(way @ left)
        free = free - np.outer(way, way @ free)
    return chosen, gained


def _gains(free: Array, left: Array) -> Array:
    """What each column alone takes off the sum of squares; nothing, where nothing of it is left."""
    norms = np.linalg.norm(free, axis=0)
    shown = norms > 1e-6 * max(float(norms.max()), 1e-300)
    return np.where(shown, (free.T @ left) ** 2 / np.where(shown, norms, 1.0) ** 2, 0.0)
