"""A force that nobody has named as a hypothesis: a table of forces with a smooth prior, weighed beside a fit like any other.

The size of such a force is not known beforehand: each size of a coarse scale has the same share of the prior.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.gap.leg_force import LEG_TABLES, PLACES, LegForce, LegTable, leg_table_over
from identify.gap.platform_force import ALONGS, seen_places, table_over
from identify.selection.evidence import Columns
from identify.selection.weighing import Both, Weighed, weighed_both_ways
from measure.common.arrays import Array
from simulate.model.effect import Effect

SIZES = (1.0, 10.0, 100.0, 1000.0)  # standard deviations of the prior, in typical sizes of the tables
_SHOWN = 1e-6


@dataclass(frozen=True)
class Unnamed:
    """A table weighed beside a fit. places : which of its parameters were estimated. values, sigma : these, in N or N m."""

    table: Effect
    log_z: float
    places: NDArray[np.intp]
    values: Array
    sigma: Array

    @property
    def name(self) -> str:
        """The table's name."""
        return self.table.name

    @property
    def in_legs(self) -> LegForce | None:
        """The force in the legs, where it is one."""
        if not isinstance(self.table, LegTable):
            return None
        force, sigma = np.zeros(PLACES), np.full(PLACES, np.inf)
        force[self.places], sigma[self.places] = self.values, self.sigma
        return LegForce(self.table, force, sigma)


def unnamed_forces(at: Weighed) -> list[Unnamed]:
    """Every table weighed along straight lines, those with the largest evidence first."""
    problem = at.fit.problem
    tables: list[tuple[Effect, NDArray[np.intp]]] = [(leg_table_over(problem, kind), np.arange(PLACES)) for kind in LEG_TABLES]
    if problem.films:
        tables += [(table_over(problem, along), seen_places(problem)) for along in ALONGS]
    found = [one for table, places in tables if (one := _weighed(at, table, places)) is not None]
    return sorted(found, key=lambda one: -one.log_z)


def _weighed(at: Weighed, table: Effect, places: NDArray[np.intp]) -> Unnamed | None:
    problem = at.fit.problem.with_another(table)
    start = np.concatenate([at.fit.q, np.zeros(len(table.flat()))])
    columns = problem.jacobian(start, (len(at.fit.q) + places).tolist(), at.fit.gaps)[1][: at.fit.problem.measured]
    shown = np.linalg.norm(columns, axis=0) > _SHOWN
    if not shown.any():
        return None
    own = [Columns.free(columns[:, shown], size) for size in SIZES]
    found: list[Both] = []
    for one in own:
        found.append(weighed_both_ways(at.lines, at.columns.beside(one), found[-1].likelier.noise if found else at.evidence.noise))
    log_z = float(np.logaddexp.reduce([one.log_z for one in found]) - np.log(len(SIZES)))
    best = max(found, key=lambda one: one.log_z).likelier
    typical, count = problem.scales[len(at.fit.q) + places][shown], int(shown.sum())
    sigma = np.sqrt(np.diag(best.covariance)[-count:])
    return Unnamed(table, log_z, places[shown], best.amounts[-count:] * typical, sigma * typical)


def is_unnamed(name: str) -> bool:
    """Whether a name of a hypothesis is that of a table."""
    return name.startswith("missing-force")
