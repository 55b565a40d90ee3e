"""One deployment, or many: from a model to what the platform does."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.tables.trajectory import CHANNELS
from simulate.deployment.rate_range import assumption_of
from simulate.deployment.result import Deployment, StepError, channels_of
from simulate.dispatch.formulas import FormulaTable, count_with_power
from simulate.kernel import integrator
from simulate.kernel.layout import ALONE, FEW, LEGS, MANY, POSE_SIZE, SAMPLE_SIZE
from simulate.kernel.model_rows import effects_with_power, formula_table_of, row_of, rows_of, without_idle
from simulate.kernel.runge_kutta import compiled_stage
from simulate.kernel.speed_polynomials import with_rate_worked_in
from simulate.kernel.step_division import UNDIVIDED, StepDivision
from simulate.kernel.step_size import grid, step_of
from simulate.model.model import Model
from simulate.model.rig import stroke_of

__all__ = [
    "Deployment",
    "channels_of",
    "deploy",
    "deploy_checked",
    "deploy_many",
    "deploy_with_division",
    "grid",
    "poses_beside",
    "step_of",
]

_MOST_HALVINGS = 4


def deploy(model: Model) -> Deployment:
    """Simulate one deployment.

    Parameters
    ----------
    model : Model
        The rig with its release, duration and sample rate; it is simulated as it is given.

    Returns
    -------
    Deployment
        n samples of the six channels, forces and energies, in SI.

    Raises
    ------
    InputError
        The model has no geometry, or would take too many steps.
    """
    return _deploy_one(model, UNDIVIDED)


def deploy_with_division(model: Model, at_stops: float = np.inf) -> tuple[Deployment, StepDivision]:
    """Simulate one deployment whose steps are divided where a leg runs into a stop, and how they are, for others to follow.

    Parameters
    ----------
    model : the rig.
    at_stops : the longest part of a step while a leg is at a stop, s; by default the step itself.

    Raises
    ------
    InputError
        As `deploy`.
    """
    _, stride, count = grid(model)
    division = np.ones(stride * count, dtype=np.int64)
    return _deploy_one(model, division, at_stops), division


def _deploy_one(model: Model, division: StepDivision, at_stops: float = 0.0) -> Deployment:
    step, stride, count = grid(model)
    acting = without_idle([model])[0]
    table = formula_table_of(acting)
    samples, finite = np.empty((1, count, _columns(table))), np.empty(1, dtype=np.int64)
    stage = compiled_stage(ALONE, True, len(table.control) > 0).address
    integrator.deploy_block(row_of(acting)[None], 0, table, stage, ALONE, step, stride, division, at_stops, samples, finite)
    return _deployment(model, acting, samples[0], step, int(finite[0]))


def deploy_many(models: Sequence[Model], division: StepDivision | None = None, *, one_core: bool = False) -> list[Deployment]:
    """Simulate deployments that share effects, duration and sampling, on all cores.

    The answer of each is the same to the last digit whatever the number of cores, and as from `deploy` with the same step.

    Parameters
    ----------
    models : at least one.
    division : into how many parts each step is divided, from `deploy_with_division`; by default none is.
    one_core : for threads that keep the other cores busy themselves.

    Returns
    -------
    list of Deployment
        One for each model, in their order.

    Raises
    ------
    ValueError
        The models differ in the kinds of their effects, in their controller, or in duration, rate or step.
    """
    first = models[0]
    if any(_kinds(model) != _kinds(first) or model.simulation != first.simulation for model in models):
        raise ValueError("deploy_many: models must share the kinds of their effects and controller, and duration, rate and step.")
    step, stride, count = min((grid(model) for model in models), key=lambda g: g[0])
    acting = without_idle(models)
    table = formula_table_of(acting[0])
    samples = np.empty((len(models), count, _columns(table)))
    steps = _Steps(step, stride, UNDIVIDED if division is None else division)
    finite = steps.follow(rows_of(acting), table, _widths(len(models)), samples, one_core)
    return [_deployment(model, acting[0], samples[i], step, int(finite[i])) for i, model in enumerate(models)]


def poses_beside(models: Sequence[Model], division: StepDivision, *, one_core: bool = False) -> Array:
    """Poses (runs, n, 7) of deployments that share effects, duration, sampling and step: as `deploy_many`, with no account of work.

    Each is the same to the last digit whatever the others are, but not as from `deploy`, which rounds otherwise.

    Parameters
    ----------
    models : at least one; the step of the first is that of all. division, one_core : as for `deploy_many`.
    """
    step, stride, count = grid(models[0])
    acting = without_idle(models)
    samples = np.empty((len(models), count, POSE_SIZE))
    whole = [(MANY, slice(0, len(models)))]
    _Steps(step, stride, division).follow(rows_of(acting), formula_table_of(acting[0]), whole, samples, one_core)
    return samples


class _Steps(NamedTuple):
    """The steps of runs: their length, s, how many are between two samples, and how they are divided."""

    length_s: float
    stride: int
    division: StepDivision

    def follow(
        self, rows: Array, table: FormulaTable, widths: Iterable[tuple[int, slice]], samples: Array, one_core: bool
    ) -> NDArray[np.int64]:
        """Integrate runs, so many side by side, into their samples (runs, n, k), NaN where they have diverged: how many are finite."""
        kernel = integrator.deploy_on_one_core if one_core else integrator.deploy_on_all_cores
        finite, with_work = np.empty(len(rows), dtype=np.int64), samples.shape[2] > POSE_SIZE
        for width, block in widths:
            stage = compiled_stage(width, with_work, len(table.control) > 0).address
            kernel(rows[block], table, stage, width, *self, samples[block], finite[block])
        return finite


def _columns(table: FormulaTable) -> int:
    """Numbers in a sample: with the work of each formula that does any, and the forces of a controller."""
    return SAMPLE_SIZE + count_with_power(table) + LEGS * len(table.control)


def _deployment(model: Model, acting: Model, samples: Array, step: float, finite: int) -> Deployment:
    """The result of one run of which `finite` samples are; `acting` is the model without the effects that are switched off."""
    time_s = np.arange(len(samples)) / model.simulation.sample_rate_Hz
    diverged_at_s = None if finite == len(samples) else float(time_s[finite])
    return Deployment(model, time_s, samples, step, diverged_at_s, effects_with_power(acting))


def _widths(runs: int) -> list[tuple[int, slice]]:
    """How many stand side by side, and which: a block costs nearly the same whether or not all its places are taken."""
    rest = runs % MANY
    many = runs - rest if rest <= MANY // 2 else runs
    few = (runs - many + FEW - 2) // FEW * FEW  # a single one over is cheaper alone
    ends = [(MANY, 0, many), (FEW, many, min(many + few, runs)), (ALONE, min(many + few, runs), runs)]
    return [(width, slice(first, last)) for width, first, last in ends if last > first]


def _kinds(model: Model) -> list[type]:
    return [type(effect) for effect in with_rate_worked_in(model).effects] + [type(model.controller)]


def deploy_checked(model: Model) -> Deployment:
    """Simulate one deployment and say how exact it is; the step is halved until that is fine, unless the model gives a step.

    After four halvings, and where the run diverges, it stays as it is: the error says so. It is None where half the step would take more
    steps than anybody waits for.

    Parameters
    ----------
    model : Model
        As for `deploy`.

    Returns
    -------
    Deployment
        The coarser of the last two runs with its `step_error`.

    Raises
    ------
    InputError
        The model has no geometry, or would take too many steps.
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


def warnings_of_rates(model: Model) -> list[str]:
    """What is assumed where asymptotes follow the rate, and where the deployment of the model leaves what was measured; often nothing."""
    if model.actuator.rate is None:
        return []
    return deploy(model).of_rates if model.geometry is not None else assumption_of(model.actuator.rate)


def step_error(run: Deployment, finer: Deployment) -> StepError:
    """Twice what half the step changes; of a run that has diverged the whole is off by infinity, NaN in one of the two likewise."""
    reached = (run.work_J["by_stops"] != 0.0) | np.any(run.elongation_m > stroke_of(run.model), axis=1)
    stop = int(np.argmax(reached)) if reached.any() else len(run.time_s)
    apart = {name: _apart(run.channels[name], finer.channels[name]) for name in CHANNELS}
    least = 0.0 if run.diverged_at_s is None else np.inf
    return StepError(
        {name: max(least, 2.0 * float(np.max(values))) for name, values in apart.items()},
        {name: 2.0 * float(np.max(values[:stop], initial=0.0)) for name, values in apart.items()},
    )


def _apart(one: Array, other: Array) -> Array:
    both = np.isnan(one) & np.isnan(other)
    return np.where(both, 0.0, np.nan_to_num(np.abs(one - other), nan=np.inf))


def _with_step(model: Model, step_s: float) -> Model:
    return replace(model, simulation=replace(model.simulation, step_s=step_s))
