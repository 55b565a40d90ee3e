"""Deployments of which only the responses are kept: a sweep's kernel, with memory for a block of runs at a time.

Each lane takes one run after the other. A run goes in steps of its own, so that the lanes stand at different times; frames of the
longest step hold them together with the samples. What lies between two steps is read off a cubic through both their ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaTable, pointers_of
from simulate.dispatch.intrinsics import uncounted
from simulate.dispatch.lanes import Lanes, Mask, Rows, all_of, any_of, chosen, larger, rows_at, smaller
from simulate.kernel.block import Block, block_memory, bounded, first_stage, later_stages, on_cache_line, release, two_later_stages
from simulate.kernel.layout import (
    BEYOND,
    CENTRE,
    EVENT,
    FULL,
    LEG,
    LEG_SIZE,
    LEGS,
    MANY,
    OUT,
    OUT_STOP,
    PEAK,
    RATE,
    ROTATION,
    ROWS,
    SCRATCH,
    STATE,
    STATES,
    STEP,
    TAKEN_OUT,
    TIME,
)
from simulate.kernel.step_division import own_step, step_near_rest
from simulate.model.responses import (
    BEFORE_STOP,
    CONTROL_ENERGY,
    CONTROL_FORCE,
    COUNT,
    DIVERGED,
    FULL_HEIGHT,
    LATERAL,
    STOP_FORCE,
    THETA_Z,
    TILT,
)

# Rows of what is followed beside the mechanics: the answers, where the run stands among frames and samples, and at both ends of the
# step at hand four quantities with their rates: theta_z, height, squared distance from the vertical, squared sine of half the tilt.
FRAME, SAMPLE, UNTIL, TOUCHED, ALIVE, HALF_A, HALF_D, TURNED, NOW = range(COUNT, COUNT + 9)
TURN, HEIGHT, AWAY, TILTED, QUANTITIES = 0, 2, 4, 6, 8
BEFORE = NOW + QUANTITIES
FOLLOWED = BEFORE + QUANTITIES

CONTROL = ROWS + SCRATCH // MANY  # first row of a controller's memory

_SMALL = 0.05  # half angles in a step up to which the arctangent is a polynomial
_ROUNDING = 1e-9  # of a step


class Pace(NamedTuple):
    """Steps of a sweep's runs: see `step_size.pace_of`."""

    frame: float
    at_stops: float
    part: float
    between: float
    samples: int
    near_rest: float
    slow: float
    per_braking: float
    stages: int


@njit(cache=True, parallel=True, error_model="numpy")
def respond_on_all_cores(values: Array, table: FormulaTable, stage: int, size: int, pace: Pace, full_height: float, answers: Array) -> None:
    """Responses of every row of `values`, on all cores, into answers (runs, COUNT); each run by itself, whatever the cores.

    stage : address of a compiled stage of width MANY that keeps no account of work. size : runs that share one block.
    """
    runs = values.shape[0]
    for block in prange((runs + size - 1) // size):
        first, last = block * size, min((block + 1) * size, runs)
        respond_block(values[first:last], table, stage, pace, full_height, answers[first:last])


@njit(cache=True, nogil=True, error_model="numpy")
def respond_block(values: Array, table: FormulaTable, stage: int, pace: Pace, full_height: float, answers: Array) -> None:
    """Responses of runs that share one block, the same digits on one core, for a worker that has others beside it."""
    pointers = pointers_of(table)
    w, by_lane, by_run = block_memory(values.shape[1], MANY, 0, len(table.control))
    followed = on_cache_line(FOLLOWED * MANY)
    block = Block(uncounted(w), uncounted(by_lane), uncounted(by_run), uncounted(pointers), stage, MANY, 0)
    respond_runs(block, values, uncounted(followed), pace, full_height, len(table.control) > 0, answers)
    w[0], by_lane[0], by_run[0], pointers[0], followed[0] = 0.0, 0.0, 0.0, 0, 0.0  # kept alive until here


@njit(cache=True, error_model="numpy")
def respond_runs(block: Block, values: Array, followed: Array, pace: Pace, full_height: float, controlled: bool, answers: Array) -> None:
    """One run after the other in each lane, until all have ended."""
    w, p, f = rows_at(block.w, MANY, True), rows_at(block.by_lane, MANY, True), rows_at(followed, MANY, True)
    run_of, begun, ended = np.full(MANY, -1), 0, 0
    for i in range(MANY):
        run_of[i], begun = begin_next(block, followed, i, values, begun)
    while ended < len(values):
        set_step(w, p, f, pace, controlled)
        if pace.stages == 3:
            two_later_stages(block)
        else:
            later_stages(block)
        w[TIME] = f[UNTIL]
        first_stage(block)
        follow(w, p, f, followed, full_height, pace)
        alive = within_bounds(w) & (f[SAMPLE] < float(pace.samples))
        if not all_of(alive):
            f[ALIVE] = chosen(alive, 1.0, 0.0)
            for i in range(MANY):
                if followed[ALIVE * MANY + i] == 0.0:
                    if run_of[i] >= 0:
                        write_answer(block.w, followed, i, pace, controlled, answers[run_of[i]])
                        ended += 1
                    run_of[i], begun = begin_next(block, followed, i, values, begun)


@njit(cache=True, error_model="numpy")
def begin_next(block: Block, followed: Array, i: int, values: Array, begun: int) -> tuple[int, int]:
    """Put the next run into lane i, or, where there is none, the first one for nothing: its number, and how many have begun."""
    run = begun if begun < len(values) else -1
    release(block, i, values[max(run, 0)])
    for row in range(FOLLOWED):
        followed[row * MANY + i] = 0.0
    followed[FRAME * MANY + i] = -1.0  # a step of no length computes the rates at the release
    followed[HALF_A * MANY + i] = 1.0
    followed[FULL_HEIGHT * MANY + i] = np.inf
    return run, min(begun + 1, len(values))


@njit(cache=True, error_model="numpy", forceinline=True)
def set_step(w: Rows, p: Rows, f: Rows, pace: Pace, controlled: bool) -> None:
    """Length and end of the next step of each run; none goes beyond its frame, or the next sample or command of a controller."""
    end = (f[FRAME] + 1.0) * pace.frame
    left, step = end - w[TIME], own_step(w, p, pace.frame, pace.at_stops, pace.part)
    if controlled:
        step = smaller(step_near_rest(w, pace.near_rest, pace.slow, pace.per_braking), step)
        step = smaller(w[CONTROL + EVENT] - w[TIME], step)
    last = step > left - _ROUNDING * pace.frame
    w[STEP] = chosen(last, left, step)
    f[UNTIL] = chosen(last, end, w[TIME] + step)
    f[FRAME] += chosen(last, 1.0, 0.0)


@njit(cache=True, error_model="numpy", forceinline=True)
def within_bounds(w: Rows) -> Mask:
    """Whether the states are finite and within all reason."""
    within = abs(w[STATE]) < BEYOND
    for k in range(1, STATES):
        within = within & (abs(w[STATE + k]) < BEYOND)
    return within


@njit(cache=True, error_model="numpy", forceinline=True)
def follow(w: Rows, p: Rows, f: Rows, followed: Array, full_height: float, pace: Pace) -> None:
    """Work the step that has ended, and the samples in it, into the responses."""
    followed_now(w, p, f)
    turn_on(w, f, followed)
    over = w[OUT] - p[LEG + FULL]
    for leg in range(LEGS):
        over = larger(w[OUT + leg] - p[LEG + leg * LEG_SIZE + FULL], over)
        f[STOP_FORCE] = larger(abs(w[OUT_STOP + leg]), f[STOP_FORCE])
    touched = larger(chosen(over > 0.0, 1.0, 0.0), f[TOUCHED])
    time = f[SAMPLE] * pace.between
    due = (f[SAMPLE] < float(pace.samples)) & (time < w[TIME] + _ROUNDING * pace.frame)
    while any_of(due):
        sample(w, f, time, due, touched, full_height)
        f[SAMPLE] += chosen(due, 1.0, 0.0)
        time = f[SAMPLE] * pace.between
        due = (f[SAMPLE] < float(pace.samples)) & (time < w[TIME] + _ROUNDING * pace.frame)
    f[TOUCHED] = touched
    for k in range(QUANTITIES):
        f[BEFORE + k] = f[NOW + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def followed_now(w: Rows, p: Rows, f: Rows) -> None:
    """The quantities and their rates at the end of a step, theta_z apart."""
    x, vx = origin(w, p, 0)
    y, vy = origin(w, p, 1)
    f[NOW + HEIGHT], f[NOW + HEIGHT + 1] = origin(w, p, 2)
    f[NOW + AWAY], f[NOW + AWAY + 1] = x * x + y * y, 2.0 * (x * vx + y * vy)
    b, c = w[STATE + 4], w[STATE + 5]
    f[NOW + TILTED], f[NOW + TILTED + 1] = b * b + c * c, 2.0 * (b * w[RATE + 4] + c * w[RATE + 5])


@njit(cache=True, error_model="numpy", forceinline=True)
def origin(w: Rows, p: Rows, k: int) -> tuple[Lanes, Lanes]:
    """A coordinate of the origin of the platform frame, and its rate."""
    next_one, last_one = (k + 1) % 3, (k + 2) % 3
    arms = (arm_of_centre(w, p, k), arm_of_centre(w, p, next_one), arm_of_centre(w, p, last_one))
    turning = w[STATE + 10 + next_one] * arms[2] - w[STATE + 10 + last_one] * arms[1]
    return w[STATE + k] - arms[0], w[STATE + 7 + k] - turning


@njit(cache=True, error_model="numpy", forceinline=True)
def arm_of_centre(w: Rows, p: Rows, k: int) -> Lanes:
    """A coordinate of the centre of mass as seen from the origin of the platform frame, world axes."""
    row = ROTATION + 3 * k
    return w[row] * p[CENTRE] + w[row + 1] * p[CENTRE + 1] + w[row + 2] * p[CENTRE + 2]


@njit(cache=True, error_model="numpy", forceinline=True)
def turn_on(w: Rows, f: Rows, followed: Array) -> None:
    """theta_z, unwrapped, by what it has gained in the step, and its rate."""
    a, d, da, dd = w[STATE + 3], w[STATE + 6], w[RATE + 3], w[RATE + 6]
    across, along = f[HALF_A] * d - f[HALF_D] * a, f[HALF_A] * a + f[HALF_D] * d
    x = across / along
    x2 = x * x
    f[TURNED] = x * (2.0 - x2 * (2.0 / 3.0 - x2 * (2.0 / 5.0 - x2 * (2.0 / 7.0 - x2 * (2.0 / 9.0)))))
    small = (abs(x) < _SMALL) & (along > 0.0)
    if not all_of(small):
        f[TURNED], f[NOW], f[NOW + 1] = chosen(small, f[TURNED], np.inf), across, along
        for i in range(MANY):
            if followed[TURNED * MANY + i] == np.inf:
                gained = 2.0 * math.atan2(followed[NOW * MANY + i], followed[(NOW + 1) * MANY + i])
                followed[TURNED * MANY + i] = gained - 2.0 * math.pi * np.rint(gained / (2.0 * math.pi))
    f[HALF_A], f[HALF_D] = a, d
    f[NOW + TURN] = f[BEFORE + TURN] + f[TURNED]
    f[NOW + TURN + 1] = 2.0 * (a * dd - d * da) / (a * a + d * d)


@njit(cache=True, error_model="numpy", forceinline=True)
def sample(w: Rows, f: Rows, time: Lanes, due: Mask, touched: Lanes, full_height: float) -> None:
    """Work one sample of the runs that are due into their responses; lateral way and tilt stand there squared until the run has ended."""
    back = chosen(w[STEP] > 0.0, (w[TIME] - time) / w[STEP], 0.0)
    inner = back > _ROUNDING
    turn = value_at(w, f, TURN, back)
    farther = due & (abs(turn) > abs(f[THETA_Z]))
    f[THETA_Z] = chosen(farther, turn, f[THETA_Z])
    free = due & (chosen(inner, f[TOUCHED], touched) < 0.5)
    f[BEFORE_STOP] = chosen(free, f[THETA_Z], f[BEFORE_STOP])
    f[LATERAL] = chosen(due, larger(value_at(w, f, AWAY, back), f[LATERAL]), f[LATERAL])
    f[TILT] = chosen(due, larger(value_at(w, f, TILTED, back), f[TILT]), f[TILT])
    high = due & (value_at(w, f, HEIGHT, back) >= full_height)
    f[FULL_HEIGHT] = chosen(high, smaller(time, f[FULL_HEIGHT]), f[FULL_HEIGHT])


@njit(cache=True, error_model="numpy", forceinline=True)
def value_at(w: Rows, f: Rows, k: int, back: Lanes) -> Lanes:
    """A quantity so far back from the end of the step, as a part of it: the cubic with its values and rates at both ends."""
    end, gained = f[NOW + k], f[BEFORE + k] - f[NOW + k]
    out, into = -w[STEP] * f[NOW + k + 1], -w[STEP] * f[BEFORE + k + 1]
    bent = end + back * (out + back * (3.0 * gained - 2.0 * out - into + back * (out + into - 2.0 * gained)))
    return chosen(back > _ROUNDING, bent, end)


@njit(cache=True, error_model="numpy")
def write_answer(w: Array, followed: Array, i: int, pace: Pace, controlled: bool, answer: Array) -> None:
    """The responses of the run in lane i, which has ended or diverged."""
    if followed[SAMPLE * MANY + i] < pace.samples or not bounded(w, i, MANY):
        answer[:] = np.nan
        answer[DIVERGED] = math.ceil(w[TIME * MANY + i] / pace.between - _ROUNDING) * pace.between
        return
    for k in range(COUNT):
        answer[k] = followed[k * MANY + i]
    answer[LATERAL] = math.sqrt(answer[LATERAL])
    answer[TILT] = 2.0 * math.asin(math.sqrt(min(answer[TILT], 1.0)))
    answer[DIVERGED] = np.nan
    if answer[FULL_HEIGHT] == np.inf:
        answer[FULL_HEIGHT] = np.nan
    if controlled:
        answer[CONTROL_FORCE], answer[CONTROL_ENERGY] = w[(CONTROL + PEAK) * MANY + i], w[(CONTROL + TAKEN_OUT) * MANY + i]
