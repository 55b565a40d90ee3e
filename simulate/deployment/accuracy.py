"""How exact a deployment is: every run is computed again with half the step, and the difference is what is reported."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.tables.trajectory import CHANNELS
from simulate.deployment.deploy import Deployment, deploy
from simulate.deployment.energy import stroke_of
from simulate.model.model import Model

# What films and other engines are compared at: a hundredth of a millimetre, a hundredth of a degree.
FINE_M, FINE_RAD = 1e-5, np.radians(0.01)
_MOST_HALVINGS = 4


@dataclass(frozen=True)
class StepError:
    """Error of each channel over the whole run and up to the first stop: twice the largest difference from the run with half the step.

    Twice is what a method of first order would leave, as the chord of an asymptote that moves with the speed is; RK4 leaves a fifteenth
    of the half while the motion is smooth, and about the half across reversals and stops. Behind the stops errors grow, which is
    why both are told.
    """

    whole: Mapping[str, float]
    to_the_stops: Mapping[str, float]

    @property
    def fine(self) -> bool:
        """Whether no channel is off by more than a hundredth of a millimetre or of a degree."""
        return all(error <= (FINE_M if name.endswith("_m") else FINE_RAD) for name, error in self.whole.items())

    @cached_property
    def report(self) -> dict[str, Any]:
        """As the JSON of a deployment gives it."""
        return {"whole_run": dict(self.whole), "to_the_stops": dict(self.to_the_stops)}


def deploy_checked(model: Model) -> Deployment:
    """Simulate one deployment and say how exact it is; the step is halved until that is fine, unless the model gives a step.

    After four halvings, and where the run diverges, it stays as it is: the error says so. It is None where half the step would take more
    steps than anybody waits for.
    """
    run, halvings = deploy(model), 0
    while True:
        try:
            finer = deploy(_with_step(model, run.step_s / 2))
        except InputError:  # so many steps that nobody waits for twice as many
            return run
        error = step_error(run, finer)
        if error.fine or model.simulation.step_s is not None or halvings == _MOST_HALVINGS or finer.diverged_at_s is not None:
            return replace(run, step_error=error)
        run, halvings = replace(finer, model=model), halvings + 1


def step_error(run: Deployment, finer: Deployment) -> StepError:
    """Twice what half the step changes; NaN in both, a run that has diverged, is no difference, NaN in one is an infinite one."""
    reached = (run.work_J["by_stops"] != 0.0) | np.any(run.elongation_m > stroke_of(run.model), axis=1)
    stop = int(np.argmax(reached)) if reached.any() else len(run.time_s)
    apart = {name: _apart(run.channels[name], finer.channels[name]) for name in CHANNELS}
    return StepError(
        {name: 2.0 * float(np.max(values)) for name, values in apart.items()},
        {name: 2.0 * float(np.max(values[:stop], initial=0.0)) for name, values in apart.items()},
    )


def _apart(one: Array, other: Array) -> Array:
    both = np.isnan(one) & np.isnan(other)
    return np.where(both, 0.0, np.nan_to_num(np.abs(one - other), nan=np.inf))


def _with_step(model: Model, step_s: float) -> Model:
    return replace(model, simulation=replace(model.simulation, step_s=step_s))
