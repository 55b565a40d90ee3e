"""A sweep: one model, factors and a design, and the responses of all its runs, piece by piece."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import get_num_threads, set_num_threads

from measure.tables import Array

from . import responses, watching
from .compiled import Program
from .deployment import grid
from .designs import Design, Factor
from .layout import MANY
from .model import Model
from .packing import geometry_of, program_of, row_of, without_idle
from .stage import stage

PIECE = 512
_CORES = get_num_threads()


class Rows(NamedTuple):
    """Rows of a design by straight lines: base + coded levels @ slopes."""

    base: Array
    slopes: Array


@dataclass(frozen=True)
class Sweep:
    """What is swept: the model, its factors, and the design that combines them."""

    model: Model
    factors: tuple[Factor, ...]
    design: Design

    def require_runnable(self) -> None:
        """Refuse what no run of it can do, before anything is written.

        Raises
        ------
        InputError
            No geometry, asymptotes that a deployment cannot have, or more steps than anybody waits for.
        """
        self.rows(0, 1)
        _ = self._grid

    def pieces(self) -> list[tuple[int, int]]:
        """First and last run of each piece."""
        runs = self.design.runs
        return [(first, min(first + PIECE, runs)) for first in range(0, runs, PIECE)]

    def responses(self, first: int, last: int) -> Array:
        """Responses of some runs, (last - first, responses.COUNT), SI; NaN where there is none. On all cores."""
        step, stride, count = self._grid
        answers = np.empty((last - first, responses.COUNT))
        full_height = geometry_of(self.model).deployed_height_m
        side_by_side = stage(MANY, False).address
        rows = self.rows(first, last)
        watching.respond_kernel(rows, self._program, side_by_side, MANY, step, stride, count, full_height, answers)
        return answers

    def rows(self, first: int, last: int) -> Array:
        """Rows of some runs for the compiled kernel."""
        coded = self.design.piece(first, last)
        if self._lines is not None:
            return self._lines.base + coded @ self._lines.slopes
        return np.array([row_of(self.model_at(levels)) for levels in coded])

    def model_at(self, levels: Array) -> Model:
        """The model of one run, from its coded levels."""
        model = self._acting
        for factor, level in zip(self.factors, levels, strict=True):
            model = factor.applied(model, float(level))
        return model

    @cached_property
    def _program(self) -> Program:
        return program_of(self._acting)

    @cached_property
    def _acting(self) -> Model:
        """The model without the effects that are switched off; no factor switches one on."""
        return without_idle([self.model])[0]

    @cached_property
    def _grid(self) -> tuple[float, int, int]:
        """The finest step that any single factor, at either level, asks for."""
        models = [self.model, *(factor.applied(self.model, level) for factor in self.factors for level in (-1.0, 1.0))]
        return min((grid(model) for model in models), key=lambda found: found[0])

    @cached_property
    def _lines(self) -> Rows | None:
        """Straight lines through the rows at the levels, where the rows are such lines and no two factors meet in an entry."""
        middle = self.model_at(np.zeros(len(self.factors)))
        base = row_of(middle)
        slopes = []
        for factor in self.factors:
            low, high = (row_of(factor.applied(middle, level)) for level in (-1.0, 1.0))
            if np.max(np.abs(low + high - 2 * base)) > 1e-12 * np.max(np.abs(base)):
                return None
            slopes.append((high - low) / 2)
        moved = np.array(slopes) != 0.0
        meet = bool(np.any(moved.sum(axis=0) > 1))
        return None if meet or not _same_shape(self.model, self.factors) else Rows(base, np.array(slopes))


def _same_shape(model: Model, factors: tuple[Factor, ...]) -> bool:
    """Whether no factor changes duration or sampling, which a row does not hold."""
    return all(factor.applied(model, 1.0).simulation == model.simulation for factor in factors)


def run_on(sweep: Sweep, workers: int | None = None, known: Mapping[int, Path] | None = None) -> Iterator[tuple[int, Array]]:
    """First run and responses of each piece, in order, on that many cores; every run is by itself, so their number changes nothing.

    known : files of pieces that were computed before, by first run.
    """
    kept = known or {}
    set_num_threads(min(workers or _CORES, _CORES))
    for first, last in sweep.pieces():
        yield first, np.load(kept[first], allow_pickle=False) if first in kept else sweep.responses(first, last)


class Tally(NamedTuple):
    """How many runs diverged, and how many failed of those that did not."""

    runs: int
    diverged: int
    failed: int

    @property
    def failed_percent(self) -> float:
        """Share of the runs that failed, diverged ones left out of both counts, %."""
        good = self.runs - self.diverged
        return 100.0 * self.failed / good if good else math.nan

    def interval_percent(self) -> tuple[float, float]:
        """95 % interval of the failure probability (Wilson), %."""
        n = self.runs - self.diverged
        if n == 0:
            return math.nan, math.nan
        z, share = 1.959963984540054, self.failed / n
        centre = (share + z * z / (2 * n)) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
        return 100.0 * max(centre - half, 0.0), 100.0 * min(centre + half, 1.0)


def tally(answers: Array, failure_deg: float) -> Tally:
    """Count runs that diverged, and runs whose theta_z goes beyond the failure angle."""
    diverged = ~np.isnan(answers[:, responses.DIVERGED])
    failed = np.abs(np.degrees(answers[~diverged, responses.THETA_Z])) > failure_deg
    return Tally(len(answers), int(diverged.sum()), int(failed.sum()))
