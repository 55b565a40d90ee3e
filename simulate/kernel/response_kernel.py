"""Deployments of which only the responses are kept: a sweep's kernel, with memory for a block of runs at a time."""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaTable, pointers_of
from simulate.dispatch.intrinsics import uncounted
from simulate.kernel.block import (
    Block,
    block_memory,
    bounded,
    fill,
    first_stage,
    later_stages,
    release,
)
from simulate.kernel.layout import (
    CENTRE,
    CONTROL_MEMORY,
    CONTROL_ROWS,
    FULL,
    LEG,
    LEG_SIZE,
    LEGS,
    OUT,
    OUT_STOP,
    PEAK,
    ROTATION,
    ROWS,
    SCRATCH,
    STATE,
    STEP,
    TAKEN_OUT,
    TIME,
)
from simulate.model.responses import (
    BEFORE_STOP,
    CONTROL_ENERGY,
    CONTROL_FORCE,
    DIVERGED,
    FULL_HEIGHT,
    LATERAL,
    STOP_FORCE,
    THETA_Z,
    TILT,
)


@njit(cache=True, parallel=True, error_model="numpy")
def respond_on_all_cores(
    values: Array, table: FormulaTable, stage: int, n: int, step: float, stride: int, count: int, full_height: float, answers: Array
) -> None:
    """Responses of every row of `values`, on all cores, into answers (runs, COUNT); each run by itself, whatever the cores.

    stage, n : address of a compiled stage that keeps no account of work, and its width.
    """
    for block in prange((values.shape[0] + n - 1) // n):
        respond_block(values, block * n, table, stage, n, step, stride, count, full_height, answers)


@njit(cache=True, nogil=True, error_model="numpy")
def respond_on_one_core(
    values: Array, table: FormulaTable, stage: int, n: int, step: float, stride: int, count: int, full_height: float, answers: Array
) -> None:
    """The same digits on one core, for a worker that has others beside it."""
    for block in range((values.shape[0] + n - 1) // n):
        respond_block(values, block * n, table, stage, n, step, stride, count, full_height, answers)


@njit(cache=True, error_model="numpy")
def respond_block(
    values: Array,
    first: int,
    table: FormulaTable,
    stage: int,
    n: int,
    step: float,
    stride: int,
    count: int,
    full_height: float,
    answers: Array,
) -> None:
    """Responses of one block of deployments, sampled `count` times."""
    runs = min(n, values.shape[0] - first)
    pointers = pointers_of(table)
    w, by_lane, by_run = block_memory(values.shape[1], n, 0, len(table.control))
    block = Block(uncounted(w), uncounted(by_lane), uncounted(by_run), uncounted(pointers), stage, n, 0)
    for i in range(n):
        release(block, i, values[first + min(i, runs - 1)])
    respond_runs(block, step, stride, count, full_height, answers[first : first + runs])
    if len(table.control) > 0:
        control_responses(w, n, answers[first : first + runs])
    w[0], by_lane[0], by_run[0], pointers[0] = 0.0, 0.0, 0.0, 0  # kept alive until here


@njit(cache=True, error_model="numpy")
def respond_runs(block: Block, step: float, stride: int, count: int, full_height: float, answers: Array) -> None:
    """The deployments of one block, from the release on."""
    runs, turn = answers.shape[0], np.zeros((block.n, 3))
    fill(block, STEP, step)
    answers[:] = 0.0
    answers[:, FULL_HEIGHT] = answers[:, DIVERGED] = np.nan
    for sample in range(count):
        for j in range(stride):
            time = (sample * stride + j) * step
            fill(block, TIME, time)
            first_stage(block)
            if j == 0:
                for i in range(runs):
                    update_responses(block.w, block.by_lane, i, block.n, time, full_height, turn[i], answers[i])
                if sample + 1 == count:
                    finish_responses(answers)
                    return
            later_stages(block)


@njit(cache=True, error_model="numpy")
def update_responses(w: Array, by_lane: Array, i: int, n: int, time: float, full_height: float, turn: Array, answer: Array) -> None:
    """Work one sample of a run into its responses; turn holds theta_z so far, unwrapped, its last raw value, and if a stop was reached.

    Lateral way and tilt stand there squared, the tilt as the squared sine of its half, until the run has ended.
    """
    if not math.isnan(answer[DIVERGED]):
        return
    if not bounded(w, i, n):
        answer[:DIVERGED] = np.nan
        answer[DIVERGED] = time
        return
    a, b, c, d = w[(STATE + 3) * n + i], w[(STATE + 4) * n + i], w[(STATE + 5) * n + i], w[(STATE + 6) * n + i]
    raw = 2.0 * math.atan2(d, a)
    gained = raw - turn[1]
    turn[0] += gained - 2.0 * math.pi * np.rint(gained / (2.0 * math.pi)) if time > 0.0 else raw
    turn[1] = raw
    if abs(turn[0]) > abs(answer[THETA_Z]):
        answer[THETA_Z] = turn[0]
    for leg in range(LEGS):
        if w[(OUT + leg) * n + i] > by_lane[(LEG + leg * LEG_SIZE + FULL) * n + i]:
            turn[2] = 1.0
    if turn[2] == 0.0:
        answer[BEFORE_STOP] = answer[THETA_Z]
    x, y, z = origin(w, by_lane, 0, i, n), origin(w, by_lane, 1, i, n), origin(w, by_lane, 2, i, n)
    answer[LATERAL] = max(answer[LATERAL], x * x + y * y)
    answer[TILT] = max(answer[TILT], b * b + c * c)
    if math.isnan(answer[FULL_HEIGHT]) and z >= full_height:
        answer[FULL_HEIGHT] = time
    for leg in range(LEGS):
        answer[STOP_FORCE] = max(answer[STOP_FORCE], abs(w[(OUT_STOP + leg) * n + i]))


@njit(cache=True, error_model="numpy")
def control_responses(w: Array, n: int, answers: Array) -> None:
    """Largest force and energy of the controllers of runs that did not diverge."""
    for i in range(answers.shape[0]):
        memory = ROWS * n + SCRATCH + CONTROL_ROWS * n + i * CONTROL_MEMORY
        if math.isnan(answers[i, DIVERGED]):
            answers[i, CONTROL_FORCE], answers[i, CONTROL_ENERGY] = w[memory + PEAK], w[memory + TAKEN_OUT]


@njit(cache=True, error_model="numpy")
def finish_responses(answers: Array) -> None:
    """Turn the squares of ended runs into lateral way and tilt."""
    for i in range(answers.shape[0]):
        answers[i, LATERAL] = math.sqrt(answers[i, LATERAL])
        answers[i, TILT] = 2.0 * math.asin(math.sqrt(min(answers[i, TILT], 1.0)))


@njit(cache=True, error_model="numpy")
def origin(w: Array, by_lane: Array, k: int, i: int, n: int) -> float:
    """A coordinate of the origin of the platform frame."""
    at = w[(STATE + k) * n + i]
    for j in range(3):
        at -= w[(ROTATION + 3 * k + j) * n + i] * by_lane[(CENTRE + j) * n + i]
    return at
