"""Runs that are integrated side by side: their memory at the release, and how a step is computed, stage by stage."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.dispatch.formulas import call_stage
from simulate.dispatch.intrinsics import pointer
from simulate.kernel.layout import (
    CONTROL_MEMORY,
    CONTROL_ROWS,
    ELONGATION,
    JOINT,
    LEG,
    LEG_SIZE,
    LEGS,
    NEVER,
    PARAMETERS,
    POSITION,
    RIGID,
    ROTATION,
    ROWS,
    SCRATCH,
    START_FORCE,
    STATE,
    STATES,
    STORED,
    STOWED,
    STRIP,
    TRIAL,
    TURNED,
)
from simulate.kernel.rigid_body import rotate

BEYOND = 1e6  # a state outside of this has diverged


class Block(NamedTuple):
    """Runs side by side: their memory, parameters as rows and run after run, formulas, and how a stage is computed."""

    w: Array
    by_lane: Array
    by_run: Array
    pointers: NDArray[np.int64]
    stage: int
    n: int
    with_power: int


@njit(cache=True, error_model="numpy")
def rows_of_block(values: Array, first: int, n: int) -> Array:
    """Rows of a block one after the other; the last one fills lanes that have none."""
    size, last = values.shape[1], values.shape[0] - 1
    by_run = np.empty(n * size)
    for i in range(n):
        by_run[i * size : (i + 1) * size] = values[min(first + i, last)]
    return by_run


@njit(cache=True, error_model="numpy")
def lane_rows(by_run: Array, n: int) -> Array:
    """The parameters of a block as rows, those of effects left out."""
    size = len(by_run) // n
    by_lane = np.empty(PARAMETERS * n)
    for i in range(n):
        for k in range(PARAMETERS):
            by_lane[k * n + i] = by_run[i * size + k]
    return by_lane


@njit(cache=True, error_model="numpy")
def memory_at_release(by_lane: Array, n: int, with_power: int, controllers: int = 0) -> Array:
    """Memory of a block at the release, with room for the work of so many formulas, and for a controller where there is one."""
    w = np.zeros(ROWS * n + SCRATCH + 3 * with_power * n + controllers * (CONTROL_ROWS + CONTROL_MEMORY) * n)
    for k in range(RIGID * n):
        w[STATE * n + k] = w[TRIAL * n + k] = by_lane[POSITION * n + k]
    rotate(w, n)
    for i in range(n):
        for leg in range(LEGS):
            at, squared = LEG + leg * LEG_SIZE, 0.0
            for k in range(3):
                reach = w[(STATE + k) * n + i] - by_lane[(at + k) * n + i]
                for j in range(3):
                    reach += w[(ROTATION + 3 * k + j) * n + i] * by_lane[(at + JOINT + j) * n + i]
                squared += reach * reach
            u = math.sqrt(squared) - by_lane[(at + STOWED) * n + i]
            w[(ELONGATION + leg) * n + i] = w[(STRIP + leg) * n + i] = u
            w[(STORED + leg) * n + i] = by_lane[(at + START_FORCE) * n + i]
            w[(TURNED + leg) * n + i] = NEVER
    return w


@njit(cache=True, error_model="numpy")
def first_stage(block: Block, time: float, step: float) -> None:
    """End the step before, whose length is given, and compute the rates at the start of this one."""
    run_stage(block, time, 0.0, step)


@njit(cache=True, error_model="numpy")
def later_stages(block: Block, time: float, step: float) -> None:
    """The other three stages of the step; the next one's start ends it."""
    run_stage(block, time, 0.5 * step, step)
    run_stage(block, time, 0.5 * step, step)
    run_stage(block, time, step, step)


@njit(cache=True, error_model="numpy")
def run_stage(block: Block, time: float, reach: float, step: float) -> None:
    """One stage of a step, by its address."""
    numbers, parameters, every = pointer(block.w, 0), pointer(block.by_lane, 0), pointer(block.by_run, 0)
    sizes = len(block.w), len(block.by_run)
    call_stage(block.stage, (numbers, sizes[0], parameters, every, sizes[1], pointer(block.pointers, 0), time, reach, step))


@njit(cache=True, error_model="numpy")
def bounded(w: Array, i: int, n: int) -> bool:
    """Whether the state of a run is finite and within all reason."""
    within = True
    for k in range(STATES):
        within &= abs(w[(STATE + k) * n + i]) < BEYOND
    return within
