"""A sweep: one model, factors and a design, and the responses of all its runs, piece by piece."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, wait
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numba import get_num_threads, set_num_threads

from measure.common.arrays import Array
from measure.common.errors import InputError
from simulate.dispatch.formulas import FormulaTable
from simulate.kernel.layout import MANY
from simulate.kernel.model_rows import formula_table_of, row_of, rows_of, seed_column, without_idle
from simulate.kernel.response_kernel import Pace, respond_block, respond_on_all_cores
from simulate.kernel.runge_kutta import compiled_stage
from simulate.kernel.step_size import finest, longest_flight, pace_of
from simulate.model import responses
from simulate.model.model import Model
from simulate.model.possible import impossible, impossible_as_changed
from simulate.model.rig import geometry_of
from simulate.sweeps.designs import Design
from simulate.sweeps.factors import Factor

PIECE = 512
_MOST_STEPS = 1e11  # of all runs; two days on one core
_CORES = get_num_threads()
_BLOCKS = 2  # on each core, of runs computed together
_AHEAD = 64  # pieces handed to an executor before the first has come back


class LinearRows(NamedTuple):
    """Rows of a design that are linear in the coded levels: base + coded levels @ slopes."""

    base: Array
    slopes: Array


@dataclass(frozen=True)
class Sweep:
    """What is swept: the model, its factors, and the design that combines them. Plain data: any process can be sent it.

    longest_s : the longest step in flight.
    """

    model: Model
    factors: tuple[Factor, ...]
    design: Design
    longest_s: float = longest_flight()

    def __getstate__(self) -> dict[str, Any]:
        """What is sent: what was computed from it holds addresses, which are those of one process."""
        return {"model": self.model, "factors": self.factors, "design": self.design, "longest_s": self.longest_s}

    def require_runnable(self) -> None:
        """Refuse what no run of it can do, before anything is written.

        Raises
        ------
        InputError
            No geometry, asymptotes that a deployment cannot have, a level that the model cannot have, or more steps than anybody
            waits for.
        """
        for model in self._extremes:
            if wrong := impossible(model) or impossible_as_changed(model.adjusted()):
                raise InputError(f"a level of the sweep cannot be: {wrong[0]}")
            row_of(model)
        self.rows_at(self.design.piece(0, 1))
        steps = self.pace.between / min(self.pace.frame, self.pace.at_stops) * self.pace.samples
        if self.design.runs * steps > _MOST_STEPS:
            raise InputError(
                f"{self.design.runs} runs of {steps:.3g} steps take days. Give fewer --runs or factors, shorten "
                "simulation.duration_s, or soften what needs so small a step."
            )

    def pieces(self) -> list[tuple[int, int]]:
        """First and last run of each piece."""
        runs = self.design.runs
        return [(first, min(first + PIECE, runs)) for first in range(0, runs, PIECE)]

    def responses(self, first: int, last: int, alone: bool = False) -> Array:
        """Responses of some runs, (last - first, responses.COUNT), SI; NaN where there is none. On all cores, or alone on one."""
        return self._answered(self.rows_at(self.design.piece(first, last)), first, alone)

    def responses_at(self, coded: Array, alone: bool = False) -> Array:
        """Responses at any coded levels (runs, factors), whether the design has them or not."""
        return self._answered(self.rows_at(coded), 0, alone)

    def _answered(self, rows: Array, first: int, alone: bool) -> Array:
        """Responses of rows; of noisy sensors each run, counted from `first`, has noise of its own."""
        if self._seed is not None:
            rows[:, self._seed] += np.arange(first, first + len(rows))
        return respond(rows, self._formulas, self.pace, geometry_of(self.model).deployed_height_m, alone)

    def rows_at(self, coded: Array) -> Array:
        """Rows of runs at these coded levels for the compiled kernel."""
        if self._linear_rows is not None:
            return self._linear_rows.base + coded @ self._linear_rows.slopes
        return rows_of([self.model_at(levels) for levels in coded])

    def model_at(self, levels: Array) -> Model:
        """The model of one run, from its coded levels."""
        model = self._acting
        for factor, level in zip(self.factors, levels, strict=True):
            model = factor.applied(model, float(level))
        return model

    @cached_property
    def pace(self) -> Pace:
        """The steps of all runs: the finest that any single factor, as far out as it goes, asks for."""
        return finest(pace_of(model, self.longest_s) for model in self._extremes)

    @cached_property
    def _seed(self) -> int | None:
        return seed_column(self._acting)

    @cached_property
    def _formulas(self) -> FormulaTable:
        return formula_table_of(self._acting)

    @cached_property
    def _extremes(self) -> list[Model]:
        """The model, and each factor by itself as far out as it goes."""
        return [self.model, *(f.applied(self.model, level) for f in self.factors for level in (-f.farthest, f.farthest))]

    @cached_property
    def _acting(self) -> Model:
        """The model without the effects that are switched off, and that no factor switches on."""
        return without_idle(self._extremes)[0]

    @cached_property
    def _linear_rows(self) -> LinearRows | None:
        """The rows as a linear function of the levels, where they are one and no two factors move the same entry."""
        middle = self.model_at(np.zeros(len(self.factors)))
        base = row_of(middle)
        slopes = []
        for factor in self.factors:
            low, high = (row_of(factor.applied(middle, level)) for level in (-1.0, 1.0))
            if np.max(np.abs(low + high - 2 * base)) > 1e-12 * np.max(np.abs(base)):
                return None
            slopes.append((high - low) / 2)
        moved = np.reshape(slopes, (len(slopes), len(base))) != 0.0
        meet = bool(np.any(moved.sum(axis=0) > 1))
        return None if meet or not _same_shape(self.model, self.factors) else LinearRows(base, np.reshape(slopes, moved.shape))


def _same_shape(model: Model, factors: tuple[Factor, ...]) -> bool:
    """Whether no factor changes duration or sampling, which a row does not hold."""
    return all(factor.applied(model, 1.0).simulation == model.simulation for factor in factors)


def responses_of(models: Sequence[Model], longest_s: float = longest_flight()) -> Array:
    """Responses of models that share the kinds of their effects, duration and sampling, in steps of at most so many seconds.

    Returns
    -------
    (models, responses.COUNT) in SI units, NaN where there is none.
    """
    acting = without_idle(models)
    pace = finest(pace_of(model, longest_s) for model in models)
    rows = rows_of(acting)
    return respond(rows, formula_table_of(acting[0]), pace, geometry_of(models[0]).deployed_height_m)


def respond(rows: Array, formulas: FormulaTable, pace: Pace, full_height: float, alone: bool = False) -> Array:
    """Responses (runs, responses.COUNT) of rows of models, SI; steps as from `kernel.step_size.pace_of`. On all cores, or alone on one."""
    answers = np.empty((len(rows), responses.COUNT))
    stage = compiled_stage(MANY, False, len(formulas.control) > 0).address
    if alone:
        respond_block(rows, formulas, stage, pace, full_height, answers)
    else:
        size = max(MANY, math.ceil(len(rows) / (_BLOCKS * get_num_threads())))
        respond_on_all_cores(rows, formulas, stage, size, pace, full_height, answers)
    return answers


def run_on(sweep: Sweep, workers: int | None = None, only: Iterable[tuple[int, int]] | None = None) -> Iterator[tuple[int, Array]]:
    """First run and responses of each piece, in order, on that many cores; every run is by itself, so their number changes nothing.

    only : the pieces that are wanted, by default all.
    """
    set_num_threads(min(workers or _CORES, _CORES))
    for first, last in sweep.pieces() if only is None else only:
        yield first, sweep.responses(first, last)


def run_by(executor: Executor, sweep: Sweep, only: Iterable[tuple[int, int]] | None = None) -> Iterator[tuple[int, Array]]:
    """The same bytes by any executor (processes, threads, a cluster's): first run and responses of each piece, as they come back.

    Raises
    ------
    InputError
        The executor broke down. What came back before has been handed out.
    """
    todo = iter(sweep.pieces() if only is None else only)
    waiting = {executor.submit(piece_of, sweep, *piece) for piece in islice(todo, _AHEAD)}
    while waiting:
        done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
        for future in done:
            try:
                yield future.result()
            except BrokenExecutor as error:
                raise InputError(f"a worker of the sweep died: {error}. What was computed is kept; go on with --resume.") from error
            waiting |= {executor.submit(piece_of, sweep, *piece) for piece in islice(todo, 1)}


def piece_of(sweep: Sweep, first: int, last: int) -> tuple[int, Array]:
    """What a worker does: one piece, on one core."""
    return first, sweep.responses(first, last, alone=True)


class RunCounts(NamedTuple):
    """How many runs diverged, and how many failed of those that did not, in all and before the first stop."""

    runs: int
    diverged: int
    failed: int
    failed_before_stop: int = 0

    def __add__(self, other: tuple[Any, ...]) -> RunCounts:  # type: ignore[override]
        """The counts of both together."""
        return RunCounts(*(a + b for a, b in zip(self, other, strict=True)))

    @property
    def failed_percent(self) -> float:
        """Share of the runs that failed, diverged ones left out of both counts, %."""
        return self._percent(self.failed)

    @property
    def failed_before_stop_percent(self) -> float:
        """Share of those that had failed when the first leg reached its stop: the others failed in the rebound, %."""
        return self._percent(self.failed_before_stop)

    def _percent(self, failed: int) -> float:
        good = self.runs - self.diverged
        return 100.0 * failed / good if good else math.nan

    def interval_percent(self) -> tuple[float, float]:
        """95 % interval of the failure probability, %."""
        low, high = wilson(self.failed, self.runs - self.diverged)
        return 100.0 * low, 100.0 * high


def wilson(hits: int, of: int) -> tuple[float, float]:
    """95 % interval of a probability that was met so many times (Wilson); also where it was met never or always."""
    if of == 0:
        return math.nan, math.nan
    z, share = 1.959963984540054, hits / of
    centre = (share + z * z / (2 * of)) / (1 + z * z / of)
    half = z / (1 + z * z / of) * math.sqrt(share * (1 - share) / of + z * z / (4 * of * of))
    return max(centre - half, 0.0), min(centre + half, 1.0)


def count_runs(answers: Array, failure_deg: float) -> RunCounts:
    """Count runs that diverged, and runs whose theta_z goes beyond the failure angle."""
    diverged = ~np.isnan(answers[:, responses.DIVERGED])
    failed, before = (np.abs(np.degrees(answers[~diverged, k])) > failure_deg for k in (responses.THETA_Z, responses.BEFORE_STOP))
    return RunCounts(len(answers), int(diverged.sum()), int(failed.sum()), int(before.sum()))
