"""A deployment, compiled: RK4 steps through the mechanics, rows of numbers in, samples out.

The hysteretic force of each leg is no state: it is the exact function of the path since the last step, which takes the
stiffness of beta out of the integration and leaves 13 states. Runs stand side by side in blocks; each is by itself, so the
block's size and the number of cores change no digit.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaTable, count_with_power, pointers_of
from simulate.dispatch.intrinsics import uncounted
from simulate.kernel.block import Block, block_memory, bounded, fill, first_stage, later_stages, release
from simulate.kernel.layout import (
    BY_LEGS,
    CENTRE,
    CONTROL_FORCE,
    KINETIC,
    LEGS,
    OUT,
    OUT_FORCE,
    OUT_R,
    POSE_SIZE,
    POWERS,
    ROTATION,
    ROWS,
    SAMPLE_ELONGATION,
    SAMPLE_ENERGY,
    SAMPLE_FORCE,
    SAMPLE_POSE,
    SAMPLE_SIZE,
    SAMPLE_STORED,
    SAMPLE_TWIST,
    SCRATCH,
    SPENT,
    STATE,
    STEP,
    TIME,
)
from simulate.kernel.step_division import StepDivision, parts_of_step


@njit(cache=True, parallel=True, error_model="numpy")
def deploy_on_all_cores(
    values: Array,
    table: FormulaTable,
    stage: int,
    n: int,
    step: float,
    stride: int,
    division: StepDivision,
    samples: Array,
    finite: NDArray[np.int64],
) -> None:
    """Integrate every row of `values`, block by block on all cores.

    stage, n : address of a compiled stage, and its width; it keeps account of work unless samples are poses alone.
    division : into how many parts each step is divided.
    samples : (runs, count, SAMPLE_SIZE + count_with_power(table)), six columns more with a controller, or (runs, count, POSE_SIZE); one
        every `stride` steps, NaN from the one on that is not finite.
    finite : (runs,) number of samples before the run diverged.
    """
    for block in prange((values.shape[0] + n - 1) // n):
        deploy_block(values, block * n, table, stage, n, step, stride, division, 0.0, samples, finite)


@njit(cache=True, nogil=True, error_model="numpy")
def deploy_on_one_core(
    values: Array,
    table: FormulaTable,
    stage: int,
    n: int,
    step: float,
    stride: int,
    division: StepDivision,
    samples: Array,
    finite: NDArray[np.int64],
) -> None:
    """The same, block after block, for callers whose threads keep the other cores busy."""
    for block in range((values.shape[0] + n - 1) // n):
        deploy_block(values, block * n, table, stage, n, step, stride, division, 0.0, samples, finite)


@njit(cache=True, nogil=True, error_model="numpy")
def deploy_block(
    values: Array,
    first: int,
    table: FormulaTable,
    stage: int,
    n: int,
    step: float,
    stride: int,
    division: StepDivision,
    at_stops: float,
    samples: Array,
    finite: NDArray[np.int64],
) -> None:
    """One block of deployments, from run `first` on.

    at_stops : zero, or the first run of the block chooses the division and writes it down, with parts at a stop of at most so long.
    """
    runs = min(n, values.shape[0] - first)
    with_power, pointers = count_with_power(table) if samples.shape[2] > POSE_SIZE else 0, pointers_of(table)
    w, by_lane, by_run = block_memory(values.shape[1], n, with_power, len(table.control))
    block = Block(uncounted(w), uncounted(by_lane), uncounted(by_run), uncounted(pointers), stage, n, with_power)
    for i in range(n):
        release(block, i, values[first + min(i, runs - 1)])
    deploy_runs(block, step, stride, division, at_stops, samples[first : first + runs], finite[first : first + runs])
    w[0], by_lane[0], by_run[0], pointers[0] = 0.0, 0.0, 0.0, 0  # kept alive until here


@njit(cache=True, error_model="numpy")
def deploy_runs(
    block: Block, step: float, stride: int, division: StepDivision, at_stops: float, samples: Array, finite: NDArray[np.int64]
) -> None:
    """The deployments of one block, from the release on."""
    count, runs = samples.shape[1], samples.shape[0]
    fill(block, STEP, step)
    finite[:] = count
    for sample in range(count):
        for j in range(stride):
            place = sample * stride + j
            time = place * step
            fill(block, TIME, time)
            first_stage(block)
            if j == 0:
                for i in range(runs):
                    if finite[i] == count and not write_sample(block, i, samples[i, sample]):
                        samples[i, sample:, :] = np.nan
                        finite[i] = sample
                if sample + 1 == count:
                    return
            if at_stops > 0.0:
                division[place] = parts_of_step(block.w, block.by_lane, 0, block.n, step, at_stops)
            parts = division[place] if place < len(division) else 1
            part = step / parts
            fill(block, STEP, part)
            later_stages(block)
            for k in range(1, parts):
                fill(block, TIME, time + k * part)
                first_stage(block)
                later_stages(block)


@njit(cache=True, error_model="numpy")
def write_sample(block: Block, i: int, sample: Array) -> bool:
    """Fill one sample of a run at the start of a step; false where it has diverged."""
    w, by_lane, n = block.w, block.by_lane, block.n
    if not bounded(w, i, n):
        return False
    x, y, z = arm_of_centre(w, by_lane, 0, i, n), arm_of_centre(w, by_lane, 1, i, n), arm_of_centre(w, by_lane, 2, i, n)
    sample[SAMPLE_POSE] = w[STATE * n + i] - x
    sample[SAMPLE_POSE + 1] = w[(STATE + 1) * n + i] - y
    sample[SAMPLE_POSE + 2] = w[(STATE + 2) * n + i] - z
    for k in range(4):
        sample[SAMPLE_POSE + 3 + k] = w[(STATE + 3 + k) * n + i]
    if len(sample) == POSE_SIZE:
        return True
    a, b, c = w[(STATE + 10) * n + i], w[(STATE + 11) * n + i], w[(STATE + 12) * n + i]
    sample[SAMPLE_TWIST] = w[(STATE + 7) * n + i] - (b * z - c * y)
    sample[SAMPLE_TWIST + 1] = w[(STATE + 8) * n + i] - (c * x - a * z)
    sample[SAMPLE_TWIST + 2] = w[(STATE + 9) * n + i] - (a * y - b * x)
    sample[SAMPLE_TWIST + 3], sample[SAMPLE_TWIST + 4], sample[SAMPLE_TWIST + 5] = a, b, c
    for k in range(POWERS):
        sample[SAMPLE_ENERGY + BY_LEGS + k] = w[(SPENT + k) * n + i]
    for k in range(block.with_power):
        sample[SAMPLE_SIZE + k] = w[ROWS * n + SCRATCH + (2 * block.with_power + k) * n + i]
    behind = SAMPLE_SIZE + block.with_power
    for k in range(len(sample) - behind):
        sample[behind + k] = w[ROWS * n + SCRATCH + (3 * block.with_power + CONTROL_FORCE + k) * n + i]
    for leg in range(LEGS):
        sample[SAMPLE_ELONGATION + leg] = w[(OUT + leg) * n + i]
        sample[SAMPLE_STORED + leg] = w[(OUT_R + leg) * n + i]
        sample[SAMPLE_FORCE + leg] = w[(OUT_FORCE + leg) * n + i]
    sample[SAMPLE_ENERGY] = w[KINETIC * n + i]
    return True


@njit(cache=True, error_model="numpy", forceinline=True)
def arm_of_centre(w: Array, by_lane: Array, k: int, i: int, n: int) -> float:
    """A coordinate of the centre of mass of run i as seen from the origin of the platform frame, world axes."""
    arm = 0.0
    for j in range(3):
        arm += w[(ROTATION + 3 * k + j) * n + i] * by_lane[(CENTRE + j) * n + i]
    return arm
