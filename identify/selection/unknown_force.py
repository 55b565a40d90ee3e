"""A force that nobody has named as a hypothesis: a table of forces with a smooth prior, weighed beside a fit like any other.

The size of such a force is not known beforehand: each size of a coarse scale has the same share of the prior.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identify.criteria import LOSES
from identify.gap.force_tables import leg_table_over, seen_places, table_over
from identify.gap.leg_force import LEG_TABLES, PLACES
from identify.gap.linear_pieces import Columns
from identify.gap.platform_force import ALONGS, KNOTS
from identify.gap.unnamed import Places, Unnamed
from identify.selection.evidence import Both
from identify.selection.stand import Weighed
from measure.common.arrays import Array
from simulate.model.effect import Effect

SIZES = (1.0, 10.0, 100.0, 1000.0)  # standard deviations of the prior, in typical sizes of the tables
_SHOWN = 1e-6
_ROUNDS = 4  # from one size to the next the noise changes little


def unnamed_forces(at: Weighed, first: float = 0.0) -> list[Unnamed]:
    """Every table weighed along straight lines, those with the largest evidence first.

    A force on the platform is weighed as a vertical one, and as one in every direction that films tell; both have the same share.

    Parameters
    ----------
    first : the most log evidence that a name brings at a first look; a table that may not come near it is not looked at more closely.
    """
    problem = at.fit.problem
    tables: list[tuple[Effect, list[Places]]] = [(leg_table_over(problem, kind), [np.arange(PLACES)]) for kind in LEG_TABLES]
    if problem.films:
        seen = seen_places(problem)
        vertical = seen[seen < KNOTS]
        directions = [seen] if len(vertical) in (0, len(seen)) else [vertical, seen]
        tables += [(table_over(problem, along), directions) for along in ALONGS]
    found = [one for table, places in tables if (one := _weighed(at, table, places, first - LOSES)) is not None]
    return sorted(found, key=lambda one: -one.log_z)


def _weighed(at: Weighed, table: Effect, directions: list[Places], least: float) -> Unnamed | None:
    """The table with the likeliest of its directions; its evidence is that of all of them."""
    columns = _columns(at, table, directions[-1])
    shown = [places[np.linalg.norm(columns[:, places], axis=0) > _SHOWN] for places in directions]
    found = [_of_any_size(at, table, columns[:, places], places, least) for places in shown if len(places)]
    if not found:
        return None
    log_z = float(np.logaddexp.reduce([one.log_z for one in found]) - np.log(len(found)))
    return replace(max(found, key=lambda one: one.log_z), log_z=log_z)


def _columns(at: Weighed, table: Effect, places: Places) -> Array:
    """What each place of a table does to the gaps, (m, n) for all its parameters; nought where it was not asked for."""
    problem = at.fit.problem.with_another(table)
    count = len(table.flat())
    start = np.concatenate([at.fit.q, np.zeros(count)])
    found = np.zeros((at.fit.problem.measured, count))
    new = (len(at.fit.q) + places).tolist()
    found[:, places] = problem.jacobian(start, new, at.fit.gaps, longer=True)[1][: at.fit.problem.measured]
    return found


def _of_any_size(at: Weighed, table: Effect, columns: Array, places: Places, least: float) -> Unnamed:
    """A table with a prior of any size; a first look tells whether one of them may gain `least` and is worth a closer one."""
    of_sizes = [Columns.free(columns, size) for size in SIZES]
    shown = at.first_look.shown(columns)
    gains = [shown.gain(one) for one in of_sizes]
    whole = float(np.logaddexp.reduce([one.log_z for one in gains]) - np.log(len(SIZES)))
    best = int(np.argmax([one.log_z for one in gains]))
    log_z, covariance, amounts = at.along_lines + whole, gains[best].covariance, gains[best].amounts
    if max(gain.most for gain in gains) > least:
        found = _weighed_from(at, of_sizes, best)
        log_z = float(np.logaddexp.reduce([one.log_z for one in found.values()]) - np.log(len(SIZES)))
        best = max(found, key=lambda place: found[place].log_z)
        of = found[best].likelier
        covariance, amounts = of.covariance[-len(places) :, -len(places) :], of.amounts[-len(places) :]
    typical, size = at.fit.problem.with_another(table).scales[len(at.fit.q) + places], SIZES[best]
    known = np.linalg.pinv(covariance, hermitian=True)
    information, drive = (known - np.eye(len(places)) / size**2) / np.outer(typical, typical), known @ amounts / typical
    return Unnamed(table, log_z, places, amounts * typical, np.sqrt(np.diag(covariance)) * typical, size, information, drive)


def _weighed_from(at: Weighed, of_sizes: Sequence[Columns], begin: int) -> dict[int, Both]:
    """Columns with priors of several sizes weighed, from one up and down until the evidence is lost: over the size it has one top."""
    found = {begin: at.beside(of_sizes[begin], rounds=_ROUNDS)}
    noise = found[begin].likelier.noise
    for places in (range(begin + 1, len(of_sizes)), range(begin - 1, -1, -1)):
        for place in places:
            found[place] = at.beside(of_sizes[place], noise=noise, rounds=_ROUNDS)
            if found[place].log_z < max(one.log_z for one in found.values()) - LOSES:
                break
    return found
