"""A force without a name that was weighed beside a fit: as plain data, and estimated by full simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identify.criteria import ROUGHLY
from identify.estimation.least_squares import laid_out, solve
from identify.estimation.problem import Fit
from identify.gap.leg_force import PLACES, LegForce, LegTable
from identify.gap.platform_force import AXES, KNOTS, ForceTable, MissingForce
from measure.common.arrays import Array
from simulate.model.effect import Effect

Places = NDArray[np.intp]
_MOST_STEPS = 12


@dataclass(frozen=True)
class Unnamed:
    """A table weighed beside a fit.

    places : which of its parameters were estimated. values, sigma : these, in N or N m. size : standard deviation of their prior, in
    typical sizes. information, drive : (n, n) and (n,) what the measurements alone say of them, F' A F - 2 b' F.
    """

    table: Effect
    log_z: float
    places: Places
    values: Array
    sigma: Array
    size: float
    information: Array
    drive: Array

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

    def on_platform(self, leads: Mapping[str, float]) -> MissingForce | None:
        """The force on the platform, where it is one, from the first to the last place that had a say.

        Parameters
        ----------
        leads : by how much its log evidence leads that along each other abscissa.
        """
        table = self.table
        if not isinstance(table, ForceTable):
            return None
        force, sigma = np.zeros(AXES * KNOTS), np.full(AXES * KNOTS, np.nan)
        force[self.places], sigma[self.places] = self.values, self.sigma
        force, sigma = force.reshape(AXES, KNOTS).T, sigma.reshape(AXES, KNOTS).T
        had_a_say = np.flatnonzero(np.isfinite(sigma).any(axis=1))
        used = slice(had_a_say[0], had_a_say[-1] + 1)
        return MissingForce(type(table), table.places[used], force[used], sigma[used], dict(leads), table.spacing)


def simulated(one: Unnamed, beside: Fit) -> Unnamed:
    """The same force estimated by full simulation beside base and releases, from where straight lines lead; effects stay as they are."""
    problem = replace(beside.problem.with_another(one.table), effect_spread=one.size)
    new = problem.rows_of(one.name)[one.places]
    start = laid_out(beside, problem)
    start[new] = one.values / problem.scales[new]
    found = solve(problem, start, free=[*range(problem.first_effect), *new.tolist()], most_steps=_MOST_STEPS, enough=ROUGHLY)
    spread = np.sqrt(np.diag(found.covariance)[-len(new) :])
    return replace(one, values=found.q[new] * problem.scales[new], sigma=spread * problem.scales[new])
