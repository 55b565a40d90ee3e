"""The classical Runge-Kutta method on the memory of a block, for states and work done alike, one compiled stage of a step at a time.

A stage is compiled once for each width of a block, kept on disk, and reached by kernels through its address: handed to them as a
function it would be compiled anew inside every one of them.
"""

from __future__ import annotations

import math
from typing import Any

from numba import cfunc, njit
from numba.np.numpy_support import carray

from measure.common.arrays import Array
from simulate.dispatch.compiled_code import compiled_once
from simulate.dispatch.formulas import STAGE, FormulaPointers, pointers_at
from simulate.kernel.contributions import add_control, add_platform_wrenches, count_working, keep_leg_for_control, power_row
from simulate.kernel.layout import (
    ELONGATION,
    HEADING,
    LEAST_TRAVEL,
    LEGS,
    OUT,
    OUT_R,
    OUT_STRIP,
    PARAMETERS,
    POWERS,
    RATE,
    STATE,
    STATES,
    STORED,
    STRIP,
    TOTAL,
    TRIAL,
    TURNED,
)
from simulate.kernel.mechanics import (
    add_leg,
    assemble_platform,
    leg_forces,
    leg_kinematics,
    load_leg,
    store_leg,
)
from simulate.kernel.moving_base import base_energy, base_rates, eliminate_base, look_from_base, stand_on_base
from simulate.kernel.rigid_body import kinetic_energy, rotate, solve, state_rates
from simulate.kernel.transverse import add_transverse


@compiled_once
def compiled_stage(n: int, with_work: bool) -> Any:
    """The compiled stage for n runs side by side; `.address` is what kernels want. It must outlive their calls, and does."""
    return cfunc(STAGE, cache=True, error_model="numpy")(_stage(n, with_work))


def _stage(n: int, with_work: bool) -> Any:
    def compute(memory: Any, size: int, rows: Any, every: Any, each: int, pointers: int, time: float, reach: float, step: float) -> None:
        """The stage of the step at `time` that looks ahead by `reach`; the one that looks ahead by nothing ends the step before.

        memory : `size` numbers, the rows of `layout`. rows : parameters of the runs as rows, read only. every : the same run
        after run, `each` in all, for the formulas of effects. pointers : address of the table of formulas.
        """
        w, by_lane, by_run = carray(memory, size), carray(rows, PARAMETERS * n), carray(every, each)
        formulas = pointers_at(pointers)
        if reach == 0.0:
            finish_step(w, formulas, step, n, with_work)
            derivative(w, by_lane, by_run, formulas, max(time - step, 0.0), time, 0.0, n, with_work)
            carry_legs(w, n)
        else:
            set_trial_state(w, reach, n)
            derivative(w, by_lane, by_run, formulas, time, time + reach, reach, n, with_work)
        accumulate(w, formulas, reach, step, n, with_work)

    return compute


@njit(cache=True, error_model="numpy", forceinline=True)
def derivative(
    w: Array, by_lane: Array, by_run: Array, formulas: FormulaPointers, t0: float, t: float, reach: float, n: int, with_work: bool
) -> None:
    """Rates of the trial states, and of the work done where account of it is kept, into the rows RATE; what the legs do into OUT.

    t0 : time at which the legs stood as the rows ELONGATION and STORED say. reach : how far the stage looks ahead in its step.
    """
    rotate(w, n)
    assemble_platform(w, by_lane, by_run, formulas, n)
    if with_work:
        w[power_row(0, n) : power_row(count_working(formulas), n)] = 0.0
    if formulas.base_mass[1] > 0:
        look_from_base(w, n)
    for leg in range(LEGS):
        load_leg(w, by_lane, leg, n)
        leg_kinematics(w, n)
        leg_forces(w, by_lane, by_run, formulas, t0, t, n, with_work)
        add_leg(w, formulas, n, with_work)
        if formulas.leg_transverse[1] + formulas.joint_resistance[1] > 0:
            add_transverse(w, by_run, formulas, n, with_work)
        if formulas.control[1] > 0:
            keep_leg_for_control(w, formulas, leg, n, with_work)
        store_leg(w, leg, n)
    if formulas.control[1] > 0:
        add_control(w, by_run, formulas, t, reach, n, with_work)
    if formulas.base_mass[1] > 0:
        stand_on_base(w, by_lane, by_run, formulas, n, with_work)
    add_platform_wrenches(w, by_run, formulas, t, n, with_work)
    if with_work:
        kinetic_energy(w, n)
        if formulas.base_mass[1] > 0:
            base_energy(w, n)
    if formulas.base_mass[1] > 0:
        eliminate_base(w, n)
        solve(w, n)
        base_rates(w, n)
    else:
        solve(w, n)
    state_rates(w, n)


@njit(cache=True, error_model="numpy", forceinline=True)
def finish_step(w: Array, formulas: FormulaPointers, step: float, n: int, with_work: bool) -> None:
    """Add what the stages of the step before gathered (nothing at the release), and take the state for the trial state."""
    for k in range((STATES + POWERS) * n):
        w[STATE * n + k] += step / 6.0 * w[TOTAL * n + k]
    if with_work:
        for k in range(power_row(count_working(formulas), n) - power_row(0, n)):
            w[power_row(2 * count_working(formulas), n) + k] += step / 6.0 * w[power_row(count_working(formulas), n) + k]
    for i in range(n):
        a, b, c, d = w[(STATE + 3) * n + i], w[(STATE + 4) * n + i], w[(STATE + 5) * n + i], w[(STATE + 6) * n + i]
        per = 1.0 / math.sqrt(a * a + b * b + c * c + d * d)
        w[(STATE + 3) * n + i], w[(STATE + 4) * n + i] = a * per, b * per
        w[(STATE + 5) * n + i], w[(STATE + 6) * n + i] = c * per, d * per
    for k in range(STATES * n):
        w[TRIAL * n + k] = w[STATE * n + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def carry_legs(w: Array, n: int) -> None:
    """Carry the legs to the start of the step: elongation, hysteretic force, last reversal, the strip."""
    for k in range(LEGS * n):
        before, turned, heading = w[ELONGATION * n + k], w[TURNED * n + k], w[HEADING * n + k]
        travel = w[OUT * n + k] - before
        moved = abs(travel) > LEAST_TRAVEL
        w[TURNED * n + k] = before if moved & (travel * heading < 0.0) else turned
        w[HEADING * n + k] = travel if moved else heading
        w[ELONGATION * n + k] = w[OUT * n + k]
        w[STORED * n + k] = w[OUT_R * n + k]
        w[STRIP * n + k] = w[OUT_STRIP * n + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def set_trial_state(w: Array, reach: float, n: int) -> None:
    """The trial state along the rates of the last stage."""
    for k in range(STATES * n):
        w[TRIAL * n + k] = w[STATE * n + k] + reach * w[RATE * n + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def accumulate(w: Array, formulas: FormulaPointers, reach: float, step: float, n: int, with_work: bool) -> None:
    """Weigh the rates of a stage into the sums of the step: 1, 2, 2, 1."""
    keep = 0.0 if reach == 0.0 else 1.0
    weight = 1.0 if reach == 0.0 or reach == step else 2.0
    for k in range((STATES + POWERS) * n):
        w[TOTAL * n + k] = keep * w[TOTAL * n + k] + weight * w[RATE * n + k]
    if with_work:
        for k in range(power_row(count_working(formulas), n) - power_row(0, n)):
            summed = power_row(count_working(formulas), n) + k
            w[summed] = keep * w[summed] + weight * w[power_row(0, n) + k]
