"""The steps of a sweep, found by trying: the longest ones that half of them does not change, on runs taken from all over the design."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.model import responses
from simulate.model.model import Model
from simulate.model.rig import Nuisance
from simulate.sweeps.sweep import Sweep, responses_of

ERROR_DEG = 0.05
_PROBES = 64
_MOST_HALVINGS = 5
_TURN_RAD = 1e-6


@dataclass(frozen=True)
class StepChoice:
    """A sweep with its step, and how exact it is.

    error_deg : (probes,) what half the step changes of theta_z at its largest. growth : (probes,) by how much the answer turns for a
    release that is turned by one microradian, rad/rad. limit : growth above which a run is called sensitive.
    """

    sweep: Sweep
    error_deg: Array
    growth: Array
    limit: float

    @property
    def sensitive(self) -> NDArray[np.bool_]:
        """Probes whose answer depends on what nobody controls: the usual spread of the release alone can make them fail."""
        return ~(self.growth <= self.limit)

    @property
    def good(self) -> bool:
        """Whether the step is fine enough for all runs that are not sensitive."""
        return bool(np.all(self.error_deg[~self.sensitive] <= ERROR_DEG))

    @property
    def report(self) -> dict[str, Any]:
        """As the JSON of a sweep gives it."""
        steady, sensitive = self.error_deg[~self.sensitive], self.error_deg[self.sensitive]
        return {
            "step_s": self.sweep.pace.frame,
            "probes": len(self.error_deg),
            "largest_error_deg": float(steady.max()) if len(steady) else None,
            "sensitive_probes": len(sensitive),
            "sensitive_above_growth": self.limit,
            "largest_error_of_sensitive_deg": float(sensitive.max()) if len(sensitive) else None,
        }


def choose_step(sweep: Sweep, failure_deg: float) -> StepChoice:
    """The sweep with the longest steps that are fine enough, or, where the model gives a step, with that.

    Sensitive is a run that a release off by its nuisance spread can turn beyond the failure angle, to first order; a small step changes
    its answer too, and no step makes it right.
    """
    # drawn, because runs at even distances of a factorial design share their levels
    runs = np.unique(np.random.default_rng(0).integers(0, sweep.design.runs, _PROBES))
    models = [sweep.model_at(sweep.design.piece(run, run + 1)[0]) for run in runs.tolist()]
    spread = sweep.model.nuisance.release_theta_rad or Nuisance().release_theta_rad
    limit = np.radians(failure_deg) / spread
    given = sweep.model.simulation.step_s
    step = given or sweep.longest_s
    found, halvings = _tried(sweep, models, step, limit), 0
    while not (found.good or given or halvings == _MOST_HALVINGS):
        step, halvings = step / 2, halvings + 1
        found = _tried(sweep, models, step, limit)
    return found


def _tried(sweep: Sweep, models: Sequence[Model], step: float, limit: float) -> StepChoice:
    here, finer = (_theta_z(models, s) for s in (step, step / 2))
    turned = _theta_z([_turned(model) for model in models], step)
    both = np.isnan(here) & np.isnan(finer)
    error = np.where(both, 0.0, np.nan_to_num(np.degrees(np.abs(here - finer)), nan=np.inf))
    growth = np.nan_to_num(np.abs(turned - here) / _TURN_RAD, nan=0.0)
    return StepChoice(replace(sweep, longest_s=step), error, growth, limit)


def _theta_z(models: Sequence[Model], step: float) -> Array:
    """(runs,) theta_z at its largest in steps of at most so many seconds, where the models give a step as where they give none."""
    stepped = [_stepped(model, step) if model.simulation.step_s else model for model in models]
    return responses_of(stepped, step)[:, responses.THETA_Z]


def _stepped(model: Model, step: float) -> Model:
    return replace(model, simulation=replace(model.simulation, step_s=step))


def _turned(model: Model) -> Model:
    """The same rig let go a microradian askew about every axis: an unstable tilt is found as well as an unstable twist."""
    x, y, z = model.release.theta_rad
    return replace(model, release=replace(model.release, theta_rad=(x + _TURN_RAD, y + _TURN_RAD, z + _TURN_RAD)))
