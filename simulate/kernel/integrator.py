"""A deployment, compiled: RK4 steps through the mechanics, rows of numbers in, samples out.

The hysteretic force of each leg is no state: it is the exact function of the path since the last step, which takes the
stiffness of beta out of the integration and leaves 13 states. Runs stand side by side in blocks; each is by itself, so the
block's size and the number of cores change no digit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.dispatch.formulas import Program
from simulate.dispatch.intrinsics import pointer, uncounted
from simulate.dispatch.programs import listed, workers
from simulate.kernel.layout import ELONGATION as AT_ELONGATION
from simulate.kernel.layout import (
    KINETIC,
    LEGS,
    OUT,
    OUT_FORCE,
    OUT_R,
    POWERS,
    ROTATION,
    ROWS,
    SCRATCH,
    SPENT,
    STATE,
    STATES,
    TRIAL,
    TURNED,
)
from simulate.kernel.layout import STORED as AT_STORED
from simulate.kernel.mechanics import rotate
from simulate.kernel.model_rows import (
    CENTRE,
    JOINT,
    LEG,
    LEG_SIZE,
    PARAMETERS,
    POSITION,
    START_FORCE,
    STOWED,
)
from simulate.kernel.rk_stage import call_stage
from simulate.kernel.step_division import Pace, parts_of_step
from simulate.law import NEVER

# Columns of a sample: pose (7), twist (6), elongation (6), hysteretic force (6), leg force (6), energies (4); behind them the
# work of each formula that does any.
POSE, TWIST, ELONGATION, STORED, FORCE, ENERGY = 0, 7, 13, 19, 25, 31
BY_LEGS, BY_STOPS, BY_WEIGHT = 1, 2, 3
SAMPLE = ENERGY + 4
BEYOND = 1e6  # a state outside of this has diverged


class Block(NamedTuple):
    """Runs side by side: their memory, parameters as rows and run after run, calls, and how a stage is computed."""

    w: Array
    fixed: Array
    mine: Array
    table: NDArray[np.int64]
    stage: int
    n: int
    workers: int


@njit(cache=True, parallel=True, error_model="numpy")
def deploy_kernel(
    values: Array, called: Program, stage: int, n: int, step: float, stride: int, pace: Pace, samples: Array, good: NDArray[np.int64]
) -> None:
    """Integrate every row of `values`, block by block on all cores.

    stage, n : address of a compiled stage that keeps a ledger, and its width.
    pace : into how many parts each step is divided.
    samples : (runs, count, SAMPLE + workers), filled with one sample every `stride` steps, NaN from the one on that is not finite.
    good : (runs,) number of good samples.
    """
    for block in prange((values.shape[0] + n - 1) // n):
        deploy_block(values, block * n, called, stage, n, step, stride, pace, False, samples, good)


@njit(cache=True, nogil=True, error_model="numpy")
def deploy_on_one_core(
    values: Array, called: Program, stage: int, n: int, step: float, stride: int, pace: Pace, samples: Array, good: NDArray[np.int64]
) -> None:
    """The same, block after block, for callers whose threads keep the other cores busy."""
    for block in range((values.shape[0] + n - 1) // n):
        deploy_block(values, block * n, called, stage, n, step, stride, pace, False, samples, good)


@njit(cache=True, nogil=True, error_model="numpy")
def deploy_block(
    values: Array,
    first: int,
    called: Program,
    stage: int,
    n: int,
    step: float,
    stride: int,
    pace: Pace,
    leads: bool,
    samples: Array,
    good: NDArray[np.int64],
) -> None:
    """One block of deployments, from run `first` on. leads : the first run of the block sets the pace and writes it down."""
    runs = min(n, values.shape[0] - first)
    mine = rows_of_block(values, first, n)
    fixed = transposed(mine, n)
    w, table = start(fixed, n, workers(called)), listed(called)
    block = Block(uncounted(w), uncounted(fixed), uncounted(mine), uncounted(table), stage, n, workers(called))
    deploy_runs(block, step, stride, pace, leads, samples[first : first + runs], good[first : first + runs])
    w[0], fixed[0], mine[0], table[0] = 0.0, 0.0, 0.0, 0  # kept alive until here


@njit(cache=True, error_model="numpy")
def deploy_runs(block: Block, step: float, stride: int, pace: Pace, leads: bool, samples: Array, good: NDArray[np.int64]) -> None:
    """The deployments of one block, from the release on."""
    count, runs = samples.shape[1], samples.shape[0]
    part = step
    good[:] = count
    for sample in range(count):
        for j in range(stride):
            place = sample * stride + j
            time = place * step
            begin_step(block, time, part)
            if j == 0:
                for i in range(runs):
                    if good[i] == count and not record(block, i, samples[i, sample]):
                        samples[i, sample:, :] = np.nan
                        good[i] = sample
                if sample + 1 == count:
                    return
            if leads:
                pace[place] = parts_of_step(block.w, block.fixed, 0, block.n, step)
            parts = pace[place] if place < len(pace) else 1
            part = step / parts
            end_step(block, time, part)
            for k in range(1, parts):
                begin_step(block, time + k * part, part)
                end_step(block, time + k * part, part)


@njit(cache=True, error_model="numpy")
def rows_of_block(values: Array, first: int, n: int) -> Array:
    """Rows of a block one after the other; the last one fills lanes that have none."""
    size, last = values.shape[1], values.shape[0] - 1
    mine = np.empty(n * size)
    for i in range(n):
        mine[i * size : (i + 1) * size] = values[min(first + i, last)]
    return mine


@njit(cache=True, error_model="numpy")
def transposed(mine: Array, n: int) -> Array:
    """The parameters of a block as rows, those of effects left out."""
    size = len(mine) // n
    fixed = np.empty(PARAMETERS * n)
    for i in range(n):
        for k in range(PARAMETERS):
            fixed[k * n + i] = mine[i * size + k]
    return fixed


@njit(cache=True, error_model="numpy")
def start(fixed: Array, n: int, working: int) -> Array:
    """Memory of a block at the release, with room for the work of so many formulas."""
    w = np.zeros(ROWS * n + SCRATCH + 3 * working * n)
    for k in range(STATES * n):
        w[STATE * n + k] = w[TRIAL * n + k] = fixed[POSITION * n + k]
    rotate(w, n)
    for i in range(n):
        for leg in range(LEGS):
            at, squared = LEG + leg * LEG_SIZE, 0.0
            for k in range(3):
                reach = w[(STATE + k) * n + i] - fixed[(at + k) * n + i]
                for j in range(3):
                    reach += w[(ROTATION + 3 * k + j) * n + i] * fixed[(at + JOINT + j) * n + i]
                squared += reach * reach
            w[(AT_ELONGATION + leg) * n + i] = math.sqrt(squared) - fixed[(at + STOWED) * n + i]
            w[(AT_STORED + leg) * n + i] = fixed[(at + START_FORCE) * n + i]
            w[(TURNED + leg) * n + i] = NEVER
    return w


@njit(cache=True, error_model="numpy")
def begin_step(block: Block, time: float, step: float) -> None:
    """End the step before, whose length is given, and compute the rates at the start of this one."""
    look(block, time, 0.0, step)


@njit(cache=True, error_model="numpy")
def end_step(block: Block, time: float, step: float) -> None:
    """The other three stages of the step; the next one's start ends it."""
    look(block, time, 0.5 * step, step)
    look(block, time, 0.5 * step, step)
    look(block, time, step, step)


@njit(cache=True, error_model="numpy")
def look(block: Block, time: float, reach: float, step: float) -> None:
    """One stage of a step, by its address."""
    numbers, parameters, every = pointer(block.w, 0), pointer(block.fixed, 0), pointer(block.mine, 0)
    sizes = len(block.w), len(block.mine)
    call_stage(block.stage, (numbers, sizes[0], parameters, every, sizes[1], pointer(block.table, 0), time, reach, step))


@njit(cache=True, error_model="numpy")
def bounded(w: Array, i: int, n: int) -> bool:
    """Whether the state of a run is finite and within all reason."""
    within = True
    for k in range(STATES):
        within &= abs(w[(STATE + k) * n + i]) < BEYOND
    return within


@njit(cache=True, error_model="numpy")
def record(block: Block, i: int, sample: Array) -> bool:
    """Fill one sample of a run at the start of a step; false where it has diverged."""
    w, fixed, n = block.w, block.fixed, block.n
    if not bounded(w, i, n):
        return False
    for k in range(3):
        # from the centre of mass back to the origin of the platform frame
        arm = 0.0
        for j in range(3):
            arm += w[(ROTATION + 3 * k + j) * n + i] * fixed[(CENTRE + j) * n + i]
        sample[TWIST + k] = arm
        sample[POSE + k] = w[(STATE + k) * n + i] - arm
    x, y, z = sample[TWIST], sample[TWIST + 1], sample[TWIST + 2]
    a, b, c = w[(STATE + 10) * n + i], w[(STATE + 11) * n + i], w[(STATE + 12) * n + i]
    sample[TWIST] = w[(STATE + 7) * n + i] - (b * z - c * y)
    sample[TWIST + 1] = w[(STATE + 8) * n + i] - (c * x - a * z)
    sample[TWIST + 2] = w[(STATE + 9) * n + i] - (a * y - b * x)
    sample[TWIST + 3], sample[TWIST + 4], sample[TWIST + 5] = a, b, c
    for k in range(4):
        sample[POSE + 3 + k] = w[(STATE + 3 + k) * n + i]
    for k in range(POWERS):
        sample[ENERGY + BY_LEGS + k] = w[(SPENT + k) * n + i]
    for k in range(block.workers):
        sample[SAMPLE + k] = w[ROWS * n + SCRATCH + (2 * block.workers + k) * n + i]
    for leg in range(LEGS):
        sample[ELONGATION + leg] = w[(OUT + leg) * n + i]
        sample[STORED + leg] = w[(OUT_R + leg) * n + i]
        sample[FORCE + leg] = w[(OUT_FORCE + leg) * n + i]
    sample[ENERGY] = w[KINETIC * n + i]
    return True
