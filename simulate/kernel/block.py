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
    BEYOND,
    CONTROL_ROWS,
    ELONGATION,
    FIRST_OF_THREE,
    JOINT,
    LEG,
    LEG_SIZE,
    LEGS,
    NEVER,
    POSITION,
    QUATERNION,
    RIGID,
    ROWS,
    SCRATCH,
    SECOND_OF_THREE,
    START_FORCE,
    STATE,
    STATES,
    STORED,
    STOWED,
    STRIP,
    TRIAL,
    TURNED,
)
from simulate.kernel.rigid_body import rotation_matrix

CACHE_LINE = 8  # numbers


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
def block_memory(size: int, n: int, with_power: int, controllers: int) -> tuple[Array, Array, Array]:
    """Memory of a block, its parameters as rows and run after run, `size` numbers each, with room for the work of so many formulas."""
    rows = ROWS * n + SCRATCH + 3 * with_power * n + controllers * CONTROL_ROWS * n
    return on_cache_line(rows), on_cache_line(size * n), np.empty(n * size)


@njit(cache=True, error_model="numpy")
def on_cache_line(size: int) -> Array:
    """Zeros that begin where a cache line does, so that no row of eight runs lies across two."""
    room = np.zeros(size + CACHE_LINE - 1)
    first = -(pointer(room, 0) // 8) % CACHE_LINE
    return room[first : first + size]


@njit(cache=True, error_model="numpy")
def release(block: Block, i: int, values: Array) -> None:
    """Lane i stands at the release of the run with these numbers, whatever it did before."""
    n, w, by_lane = block.n, block.w, block.by_lane
    block.by_run[i * len(values) : (i + 1) * len(values)] = values
    for k in range(len(values)):
        by_lane[k * n + i] = values[k]
    for row in range(ROWS):
        w[row * n + i] = 0.0
    w[ROWS * n + SCRATCH + 3 * block.with_power * n + i :: n] = 0.0  # of a controller; behind the end, and nothing, without one
    for k in range(RIGID):
        w[(STATE + k) * n + i] = w[(TRIAL + k) * n + i] = values[POSITION + k]
    for leg in range(LEGS):
        u = elongation_at_release(values, LEG + leg * LEG_SIZE)
        w[(ELONGATION + leg) * n + i] = w[(STRIP + leg) * n + i] = u
        w[(STORED + leg) * n + i] = values[LEG + leg * LEG_SIZE + START_FORCE]
        w[(TURNED + leg) * n + i] = NEVER


@njit(cache=True, error_model="numpy")
def elongation_at_release(values: Array, leg: int) -> float:
    """Elongation of the leg whose numbers start there, m."""
    matrix = rotation_matrix(values[QUATERNION], values[QUATERNION + 1], values[QUATERNION + 2], values[QUATERNION + 3])
    squared = 0.0
    for k in range(3):
        reach = values[POSITION + k] - values[leg + k]
        for j in range(3):
            reach += matrix[3 * k + j] * values[leg + JOINT + j]
        squared += reach * reach
    return math.sqrt(squared) - values[leg + STOWED]


@njit(cache=True, error_model="numpy")
def first_stage(block: Block) -> None:
    """End the step before, whose length stands in STEP, and compute the rates at the start of this one, at TIME."""
    run_stage(block, 0.0)


@njit(cache=True, error_model="numpy")
def later_stages(block: Block) -> None:
    """The other three stages of the step, whose length stands in STEP now; the next one's start ends it."""
    run_stage(block, 0.5)
    run_stage(block, 0.5)
    run_stage(block, 1.0)


@njit(cache=True, error_model="numpy")
def two_later_stages(block: Block) -> None:
    """The other two of a step of three stages: of third order, for steps that something else keeps short."""
    run_stage(block, FIRST_OF_THREE)
    run_stage(block, SECOND_OF_THREE)


@njit(cache=True, error_model="numpy")
def run_stage(block: Block, ahead: float) -> None:
    """The stage that looks ahead by this part of the step, by its address."""
    numbers, parameters, every = pointer(block.w, 0), pointer(block.by_lane, 0), pointer(block.by_run, 0)
    sizes = len(block.w), len(block.by_run)
    call_stage(block.stage, (numbers, sizes[0], parameters, every, sizes[1], pointer(block.pointers, 0), ahead))


@njit(cache=True, error_model="numpy")
def fill(block: Block, row: int, value: float) -> None:
    """The same number for all runs."""
    block.w[row * block.n : (row + 1) * block.n] = value


@njit(cache=True, error_model="numpy")
def bounded(w: Array, i: int, n: int) -> bool:
    """Whether the state of a run is finite and within all reason."""
    within = True
    for k in range(STATES):
        within &= abs(w[(STATE + k) * n + i]) < BEYOND
    return within
