"""Rigs that any controller can be tried on: their rows are made once, the controller's numbers are put behind them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.kernel.layout import LAW_SEED
from simulate.kernel.model_rows import formula_table_of, rows_of, without_idle
from simulate.kernel.step_size import grid, pace_of
from simulate.model import responses
from simulate.model.control import Controller
from simulate.model.model import Model
from simulate.model.rig import geometry_of
from simulate.sweeps.sweep import respond


@dataclass(frozen=True)
class Trials:
    """Rigs as rows, and the model that they vary. stiffest : of those models the one whose stops ask for the smallest step."""

    model: Model
    stiffest: Model
    rows: Array

    @classmethod
    def of(cls, model: Model, rigs: Iterable[Model]) -> Trials:
        """Trials on these rigs, which differ from the model in numbers only; controllers are left out."""
        bare = [replace(rig, controller=None) for rig in rigs]
        acting = without_idle([replace(model, controller=None), *bare])
        stiffest = max(bare, key=lambda rig: rig.end_stop.stiffness_N_per_m)
        return cls(acting[0], stiffest, rows_of(acting[1:]))

    def first(self, runs: int) -> Trials:
        """The first of them."""
        return replace(self, rows=self.rows[:runs])

    def step_s(self, controller: Controller | None) -> float:
        """Step of integration with a controller, s."""
        return grid(replace(self.stiffest, controller=controller))[0]

    def answers(self, controller: Controller | None, *, step_s: float | None = None) -> Array:
        """Responses (runs, responses.COUNT) with a controller, each run with noise of its own, or without one."""
        model = replace(self.model, controller=controller)
        rows = self.rows
        simulation = replace(self.stiffest.simulation, step_s=step_s or self.step_s(controller))
        pace = pace_of(replace(self.stiffest, simulation=simulation, controller=controller))
        if controller is not None:
            behind = np.tile(np.array([*controller.flat(), *controller.constants_of(model)]), (len(rows), 1))
            if not controller.passive:
                behind[:, LAW_SEED] += np.arange(len(rows))
            rows = np.hstack([rows, behind])
        return respond(rows, formula_table_of(model), pace, geometry_of(model).deployed_height_m)


def deployed(answers: Array) -> NDArray[np.bool_]:
    """(runs,) whether the full height was reached: a platform that is held back for good does not turn either."""
    return np.isfinite(answers[:, responses.FULL_HEIGHT])


def turned_deg(answers: Array, place: int = responses.THETA_Z) -> Array:
    """(runs,) abs(theta_z) at its largest, deg; infinite where a run diverged."""
    return np.nan_to_num(np.abs(np.degrees(answers[:, place])), nan=np.inf)
