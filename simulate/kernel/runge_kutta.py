"""The classical Runge-Kutta method on the memory of a block, for states and work done alike, one compiled stage of a step at a time.

A stage is compiled once for each width of a block, kept on disk, and reached by kernels through its address: handed to them as a
function it would be compiled anew inside every one of them.
"""

from __future__ import annotations

from typing import Any

from numba import cfunc, njit
from numba.np.numpy_support import carray

from measure.common.arrays import Array
from simulate.control.control_loop import add_control
from simulate.dispatch.compiled_code import compiled_once
from simulate.dispatch.formulas import STAGE, FormulaPointers, pointers_at
from simulate.dispatch.lanes import Rows, chosen, from_row, inverse_root, larger, rows_at
from simulate.kernel.contributions import add_platform_wrenches, count_working, keep_leg_for_control, power_row
from simulate.kernel.layout import (
    ELONGATION,
    FIRST_OF_THREE,
    HEADING,
    LEAST_TRAVEL,
    LEGS,
    OUT,
    OUT_R,
    OUT_STRIP,
    POWERS,
    RATE,
    SECOND_OF_THREE,
    STATE,
    STATES,
    STEP,
    STORED,
    STRIP,
    TIME,
    TIME_BEFORE,
    TIME_NOW,
    TOTAL,
    TRIAL,
    TURNED,
)
from simulate.kernel.mechanics import (
    add_axial_mass,
    assemble_platform,
    leg_forces,
    leg_kinematics,
    load_leg,
    push_platform,
    store_leg,
)
from simulate.kernel.moving_base import base_energy, base_rates, eliminate_base, look_from_base, stand_on_base
from simulate.kernel.rigid_body import kinetic_energy, rotate, solve, state_rates
from simulate.kernel.transverse import act_across, add_transverse_mass


@compiled_once
def compiled_stage(n: int, with_work: bool, controlled: bool) -> Any:
    """The compiled stage for n runs side by side; `.address` is what kernels want. It must outlive their calls, and does.

    One that keeps no account of work is for sweeps, and may round a product and its sum at once. controlled : with a controller.
    """
    return cfunc(STAGE, cache=True, error_model="numpy")(_stage(n, with_work, not with_work, controlled))


def _stage(n: int, with_work: bool, fused: bool, controlled: bool) -> Any:
    def compute(memory: Any, size: int, rows: Any, every: Any, each: int, pointers: int, ahead: float) -> None:
        """The stage that looks ahead by a part of the step at hand; the one that looks ahead by nothing ends the step before.

        memory : `size` numbers, the rows of `layout`. rows : parameters of the runs as rows, read only. every : the same run
        after run, `each` in all, for the formulas of effects. pointers : address of the table of formulas.
        """
        w, by_lane = rows_at(memory, n, fused), rows_at(rows, n, fused)
        flat, by_run, formulas = carray(memory, size), carray(every, each), pointers_at(pointers)
        if ahead == 0.0:
            finish_step(w, formulas, n, with_work)
            w[TIME_BEFORE], w[TIME_NOW] = larger(w[TIME] - w[STEP], 0.0), w[TIME]
        else:
            set_trial_state(w, ahead)
            w[TIME_BEFORE], w[TIME_NOW] = w[TIME], w[TIME] + ahead * w[STEP]
        add_legs(w, flat, by_lane, by_run, formulas, n, with_work)
        if controlled:
            add_control(w, flat, by_lane, by_run, formulas, ahead, n, with_work)
        accelerate(w, flat, by_lane, by_run, formulas, n, with_work)
        if ahead == 0.0:
            carry_legs(w)
        accumulate(w, formulas, ahead, n, with_work)

    return compute


@njit(cache=True, error_model="numpy", forceinline=True)
def add_legs(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Platform and legs at the trial states, into the system; what the legs do into OUT."""
    rotate(w)
    assemble_platform(w, flat, by_lane, by_run, formulas, n, with_work)
    if with_work:
        flat[power_row(0, n) : power_row(count_working(formulas), n)] = 0.0
    if formulas.base_mass[1] > 0:
        look_from_base(w)
    for leg in range(LEGS):
        load_leg(w, by_lane, leg)
        leg_kinematics(w)
        leg_forces(w, flat, by_lane, by_run, formulas, n, with_work)
        if formulas.leg_transverse[1] + formulas.joint_resistance[1] > 0:
            act_across(w, flat, by_lane, by_run, formulas, n, with_work)
        push_platform(w, with_work)
        if formulas.leg_transverse[1] > 0:
            add_transverse_mass(w)
            add_axial_mass(w)
        elif formulas.leg_mass[1] > 0:
            add_axial_mass(w)
        if formulas.control[1] > 0:
            keep_leg_for_control(w, formulas, leg, n, with_work)
        store_leg(w, leg)


@njit(cache=True, error_model="numpy", forceinline=True)
def accelerate(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Base and wrenches into the system, and its solution: rates of the trial states, and of the work where account of it is kept."""
    if formulas.base_mass[1] > 0:
        stand_on_base(w, flat, by_lane, by_run, formulas, n, with_work)
    add_platform_wrenches(flat, by_lane, by_run, formulas, n, with_work)
    if with_work:
        kinetic_energy(w)
        if formulas.base_mass[1] > 0:
            base_energy(w)
    if formulas.base_mass[1] > 0:
        eliminate_base(w)
        solve(w)
        base_rates(w)
    else:
        solve(w)
    state_rates(w)


@njit(cache=True, error_model="numpy", forceinline=True)
def finish_step(w: Rows, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Add what the stages of the step before gathered (nothing at the release), and take the state for the trial state."""
    part = w[STEP] / 6.0
    for k in range(STATES + POWERS):
        w[STATE + k] += part * w[TOTAL + k]
    if with_work:
        working = count_working(formulas)
        powers = from_row(w, power_row(0, n) // n)
        for k in range(working):
            powers[2 * working + k] += part * powers[working + k]
    a, b, c, d = w[STATE + 3], w[STATE + 4], w[STATE + 5], w[STATE + 6]
    per = inverse_root(a * a + b * b + c * c + d * d)
    w[STATE + 3], w[STATE + 4], w[STATE + 5], w[STATE + 6] = a * per, b * per, c * per, d * per
    for k in range(STATES):
        w[TRIAL + k] = w[STATE + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def carry_legs(w: Rows) -> None:
    """Carry the legs to the start of the step: elongation, hysteretic force, last reversal, the strip."""
    for leg in range(LEGS):
        before, heading = w[ELONGATION + leg], w[HEADING + leg]
        travel = w[OUT + leg] - before
        moved = abs(travel) > LEAST_TRAVEL
        w[TURNED + leg] = chosen(moved & (travel * heading < 0.0), before, w[TURNED + leg])
        w[HEADING + leg] = chosen(moved, travel, heading)
        w[ELONGATION + leg] = w[OUT + leg]
        w[STORED + leg] = w[OUT_R + leg]
        w[STRIP + leg] = w[OUT_STRIP + leg]


@njit(cache=True, error_model="numpy", forceinline=True)
def set_trial_state(w: Rows, ahead: float) -> None:
    """The trial state along the rates of the last stage."""
    reach = ahead * w[STEP]
    for k in range(STATES):
        w[TRIAL + k] = w[STATE + k] + reach * w[RATE + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def accumulate(w: Rows, formulas: FormulaPointers, ahead: float, n: int, with_work: bool) -> None:
    """Weigh the rates of a stage into the sums of the step: 1, 2, 2, 1 sixths, or of three stages 3/2, 0, 9/2 sixths (Heun)."""
    keep = 0.0 if ahead == 0.0 else 1.5 if ahead == SECOND_OF_THREE else 1.0
    weight = 2.0 if ahead == 0.5 else 4.5 if ahead == SECOND_OF_THREE else 0.0 if ahead == FIRST_OF_THREE else 1.0
    for k in range(STATES + POWERS):
        w[TOTAL + k] = keep * w[TOTAL + k] + weight * w[RATE + k]
    if with_work:
        working = count_working(formulas)
        powers = from_row(w, power_row(0, n) // n)
        for k in range(working):
            powers[working + k] = keep * powers[working + k] + weight * powers[k]
