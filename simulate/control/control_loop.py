"""A controller in the kernel: at every stage of a step, once all legs are known, what its actuators do; at a sample, sensors and law.

Commands are held from sample to sample. A brake's force follows its command with a lag, a(t) = c + (a_0 - c) exp(-t / lag), exactly from
step to step and at every stage; its friction follows the speed at the stage, so it takes energy out at any speed and any command:

    F_i = -tanh(v_i / v_0) a_i
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.control.sensors import read_sensors
from simulate.dispatch import lane_functions as lane_functions
from simulate.dispatch.compiled_code import compiled_once
from simulate.dispatch.formulas import FormulaPointers, address, call_law, formula_at, parameter_place
from simulate.dispatch.intrinsics import pointer
from simulate.dispatch.lane_forms import call_law_lanes, form_for_all
from simulate.dispatch.lanes import Lanes, Rows, all_of, any_of, chosen, from_row, larger, smaller
from simulate.kernel.contributions import address_for_all, control_place, count_working, power_row
from simulate.kernel.layout import (
    ARRIVAL,
    CLOCK,
    COMMAND,
    CONTROL_AXIS,
    CONTROL_BIAS,
    CONTROL_FORCE,
    COUNTED,
    DUE,
    ESTIMATE,
    EVENT,
    FAILED,
    HELD,
    HOLDS,
    LAW_BRAKE_SPEED,
    LAW_CAMERA,
    LAW_COUPLED_MASS,
    LAW_DELAY,
    LAW_FAILED,
    LAW_FAILS_AT,
    LAW_GAINS,
    LAW_LAG,
    LAW_LIMIT,
    LAW_MOTOR,
    LAW_PASSIVE,
    LAW_RATE,
    LAW_STUCK,
    LEGS,
    LEVEL,
    OUT,
    OUT_FORCE,
    OUT_V,
    OWN,
    OWN_NEXT,
    OWN_SIZE,
    PEAK,
    POWER_BEFORE,
    QUEUE,
    QUEUE_LENGTH,
    QUEUED,
    RIGHT,
    ROWS,
    SCRATCH_OUT,
    SCRATCH_OWN,
    SCRATCH_TURN,
    SCRATCH_U,
    SCRATCH_V,
    SPEED,
    STEP,
    SYSTEM,
    TAKEN,
    TAKEN_OUT,
    TIME_NOW,
    TRIAL,
    TRUE_TURN,
    TURN,
)
from simulate.law import nearest_whole
from simulate.model.control import Controller, require_law

_SOON = 1e-7  # of a sample period: rounding of times
_ROUNDING = 1e-12  # of a time
_NEVER = 1e300  # s


@compiled_once
def control_rows(kind: type[Controller], place: int) -> NDArray[np.int64]:
    """The row of a law in the table of formulas: address, place of the controller's parameters, address of the form for lanes."""
    law = require_law(kind).command
    alone = address(law, "law")
    lanes = form_for_all(law, "law")
    return np.array([[alone, place, 0 if lanes is None else lanes.address]], dtype=np.int64)


@njit(cache=True, error_model="numpy", forceinline=True)
def add_control(
    w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, ahead: float, n: int, with_work: bool
) -> None:
    """Forces of the controllers of a block along the legs, when all legs are known, and their power.

    ahead : how far the stage looks ahead, as a part of the step.
    """
    at = control_place(formulas, n, with_work)
    c, p = from_row(w, at // n), from_row(by_lane, parameter_place(formulas.control, 0))
    if ahead == 0.0:
        look_for_failure(w, c, p)
    if any_of(p[LAW_PASSIVE] > 0.0):
        c[DUE] = 1.0
        ask_law(w, c, p, flat, by_run, formulas, OUT * n, OUT_V * n, at, CONTROL_FORCE, n, with_work)
    else:
        act(w, c, p, flat, by_run, formulas, at, ahead, n, with_work)
    fail(w, c, p)
    push_legs(w, c, from_row(w, power_row(count_working(formulas) - 1, n) // n), with_work)
    if any_of(p[LAW_COUPLED_MASS] > 0.0):
        add_coupled_mass(w, c, p[LAW_COUPLED_MASS])
    if ahead == 0.0:
        keep_account(w, c)


@njit(cache=True, error_model="numpy", forceinline=True)
def act(
    w: Rows, c: Rows, p: Rows, flat: Array, by_run: Array, formulas: FormulaPointers, at: int, ahead: float, n: int, with_work: bool
) -> None:
    """Forces of actuators at this stage, N: ideal ones by their command at once, others by what is held."""
    sampled, by_camera, motor = p[LAW_RATE] > 0.0, p[LAW_CAMERA] > 0.0, p[LAW_MOTOR] > 0.0
    if any_of(by_camera):
        for i in range(n):
            flat[at + TRUE_TURN * n + i] = 2.0 * math.atan2(flat[(TRIAL + 6) * n + i], flat[(TRIAL + 3) * n + i])
    if ahead == 0.0 and any_of(sampled):
        begin_step(w, c, p, flat, by_run, formulas, at, n, with_work)
    if any_of(sampled) or any_of(by_camera):
        if not all_of(sampled):
            know_exactly(w, c, p)
            ask_law(w, c, p, flat, by_run, formulas, at + ESTIMATE * n, at + SPEED * n, at, COMMAND, n, with_work)
    else:
        c[DUE] = 1.0
        ask_law(w, c, p, flat, by_run, formulas, OUT * n, OUT_V * n, at, COMMAND, n, with_work)
    fading = faded(ahead * w[STEP], p[LAW_LAG])
    for leg in range(LEGS):
        direction = direction_of(w[OUT_V + leg], p)
        at_once = command_of(c[COMMAND + leg], chosen(by_camera, 1.0, direction), p)
        level = chosen(sampled, c[HELD + leg] + (c[LEVEL + leg] - c[HELD + leg]) * fading, at_once)
        c[CONTROL_FORCE + leg] = chosen(motor, level, -direction * level)


@njit(cache=True, error_model="numpy", forceinline=True)
def know_exactly(w: Rows, c: Rows, p: Rows) -> None:
    """What an ideal sensor gives the law: the truth, of a camera that part of it which comes from the rotation."""
    ideal, by_camera = p[LAW_RATE] < _SOON, p[LAW_CAMERA] > 0.0
    c[DUE] = chosen(ideal, 1.0, 0.0)
    c[TURN] = chosen(ideal & by_camera, c[TRUE_TURN], c[TURN])
    c[TURN + 1] = chosen(ideal & by_camera, w[TRIAL + 12], c[TURN + 1])
    for leg in range(LEGS):
        lever = c[CONTROL_AXIS + 6 * leg + 5]
        c[ESTIMATE + leg] = chosen(ideal, chosen(by_camera, lever * c[TURN], w[OUT + leg]), c[ESTIMATE + leg])
        c[SPEED + leg] = chosen(ideal, chosen(by_camera, lever * c[TURN + 1], w[OUT_V + leg]), c[SPEED + leg])


@njit(cache=True, error_model="numpy", forceinline=True)
def begin_step(w: Rows, c: Rows, p: Rows, flat: Array, by_run: Array, formulas: FormulaPointers, at: int, n: int, with_work: bool) -> None:
    """At the start of a step: actuators carried on, commands that are due taken, and at a sample sensors read and the law computed."""
    now, rate = w[TIME_NOW], p[LAW_RATE]
    fading = faded(now - c[CLOCK], p[LAW_LAG])
    for leg in range(LEGS):
        c[LEVEL + leg] = c[HELD + leg] + (c[LEVEL + leg] - c[HELD + leg]) * fading
    if any_of(now >= c[ARRIVAL]):
        take_due(flat, at, n)
    samples = now * rate + _SOON
    due = (rate > 0.0) & (samples >= c[COUNTED])
    if any_of(due):
        read_sensors(w, c, p, due)
        c[DUE], c[HOLDS] = chosen(due, 1.0, 0.0), now + p[LAW_DELAY] - _SOON / rate
        ask_law(w, c, p, flat, by_run, formulas, at + ESTIMATE * n, at + SPEED * n, at, COMMAND, n, with_work)
        for leg in range(LEGS):
            along = chosen(p[LAW_CAMERA] > 0.0, 1.0, direction_of(c[SPEED + leg], p))
            c[COMMAND + leg] = command_of(c[COMMAND + leg], along, p)
        c[COUNTED] = chosen(due, nearest_whole(samples - 0.5) + 1.0, c[COUNTED])
        send_commands(flat, at, n)
        if any_of(now >= c[ARRIVAL]):
            take_due(flat, at, n)
    c[EVENT] = chosen(rate > 0.0, smaller(smaller(c[COUNTED] / rate, c[ARRIVAL] + _SOON / rate), c[EVENT]), c[EVENT])


@njit(cache=True, error_model="numpy")
def ask_law(
    w: Rows,
    c: Rows,
    p: Rows,
    flat: Array,
    by_run: Array,
    formulas: FormulaPointers,
    u: int,
    v: int,
    at: int,
    out: int,
    n: int,
    with_work: bool,
) -> None:
    """Ask the law of the runs that are DUE; u and v are where elongations and speeds stand, `out` is the row of its forces."""
    for_all = address_for_all(formulas.control, 0, n, with_work)
    if for_all == 0:
        ask_law_run_by_run(flat, by_run, formulas, u, v, at, out, n)
        return
    now, turn, forces = pointer(flat, TIME_NOW * n), pointer(flat, at + TURN * n), pointer(flat, at + out * n)
    due, gains = c[DUE] > 0.0, from_row(p, LAW_GAINS)
    if all_of(due):
        call_law_lanes(for_all, (now, pointer(flat, u), pointer(flat, v), turn, pointer(flat, at + OWN * n), gains, forces))
        return
    for k in range(OWN_SIZE):
        c[OWN_NEXT + k] = c[OWN + k]
    call_law_lanes(for_all, (now, pointer(flat, u), pointer(flat, v), turn, pointer(flat, at + OWN_NEXT * n), gains, forces))
    for k in range(OWN_SIZE):
        c[OWN + k] = chosen(due, c[OWN_NEXT + k], c[OWN + k])


@njit(cache=True, error_model="numpy")
def ask_law_run_by_run(flat: Array, by_run: Array, formulas: FormulaPointers, u: int, v: int, at: int, out: int, n: int) -> None:
    """The same run by run, by way of plain vectors."""
    law, first, size = formula_at(formulas.control, 0), parameter_place(formulas.control, 0) + LAW_GAINS, len(by_run) // n
    scratch = ROWS * n
    for i in range(n):
        if flat[at + DUE * n + i] > 0.0:
            bring(flat, scratch + SCRATCH_U, u + i, n, LEGS)
            bring(flat, scratch + SCRATCH_V, v + i, n, LEGS)
            bring(flat, scratch + SCRATCH_TURN, at + TURN * n + i, n, 2)
            bring(flat, scratch + SCRATCH_OWN, at + OWN * n + i, n, OWN_SIZE)
            known = pointer(flat, scratch + SCRATCH_U), pointer(flat, scratch + SCRATCH_V), pointer(flat, scratch + SCRATCH_TURN)
            own, gains, forces = (
                pointer(flat, scratch + SCRATCH_OWN),
                pointer(by_run, i * size + first),
                pointer(flat, scratch + SCRATCH_OUT),
            )
            call_law(law, (flat[TIME_NOW * n + i], *known, own, gains, forces))
            for k in range(OWN_SIZE):
                flat[at + (OWN + k) * n + i] = flat[scratch + SCRATCH_OWN + k]
            for leg in range(LEGS):
                flat[at + (out + leg) * n + i] = flat[scratch + SCRATCH_OUT + leg]


@njit(cache=True, error_model="numpy", forceinline=True)
def bring(flat: Array, to: int, place: int, apart: int, count: int) -> None:
    """Numbers that stand apart, one behind the other."""
    for k in range(count):
        flat[to + k] = flat[place + k * apart]


@njit(cache=True, error_model="numpy")
def send_commands(flat: Array, at: int, n: int) -> None:
    """The commands of the runs that are DUE, to those under way."""
    for i in range(n):
        if flat[at + DUE * n + i] > 0.0:
            sent = flat[at + QUEUED * n + i]
            place = at + (QUEUE + 7 * (int(sent) % QUEUE_LENGTH)) * n + i
            flat[place] = flat[at + HOLDS * n + i]
            for leg in range(LEGS):
                flat[place + (1 + leg) * n] = flat[at + (COMMAND + leg) * n + i]
            if flat[at + TAKEN * n + i] == sent:
                flat[at + ARRIVAL * n + i] = flat[place]
            flat[at + QUEUED * n + i] = sent + 1.0


@njit(cache=True, error_model="numpy")
def take_due(flat: Array, at: int, n: int) -> None:
    """Commands that have arrived, the last one stays."""
    for i in range(n):
        now, arrival = flat[TIME_NOW * n + i], flat[at + ARRIVAL * n + i]
        while now >= arrival:
            taken = flat[at + TAKEN * n + i]
            if taken < flat[at + QUEUED * n + i]:
                place = at + (QUEUE + 7 * (int(taken) % QUEUE_LENGTH)) * n + i
                for leg in range(LEGS):
                    flat[at + (HELD + leg) * n + i] = flat[place + (1 + leg) * n]
                taken += 1.0
                flat[at + TAKEN * n + i] = taken
            following = at + (QUEUE + 7 * (int(taken) % QUEUE_LENGTH)) * n + i
            arrival = flat[following] if taken < flat[at + QUEUED * n + i] else _NEVER
        flat[at + ARRIVAL * n + i] = arrival


@njit(cache=True, error_model="numpy", forceinline=True)
def faded(time: Lanes, lag: Lanes) -> Lanes:
    """What is left of a difference after a time by which a force follows its command; nothing where it does not lag."""
    if any_of(lag > 0.0):
        return chosen(lag > 0.0, math.exp(-time / lag), 0.0)
    return 0.0 * time


@njit(cache=True, error_model="numpy", forceinline=True)
def command_of(wanted: Lanes, along: Lanes, p: Rows) -> Lanes:
    """Command for a force that the law asks for: of a motor that force, of a brake how hard it presses, where it can give it."""
    limit = p[LAW_LIMIT]
    pressed = smaller(larger(-along * wanted, 0.0), limit)
    return chosen(p[LAW_MOTOR] > 0.0, smaller(larger(wanted, -limit), limit), pressed)


@njit(cache=True, error_model="numpy", forceinline=True)
def direction_of(speed: Lanes, p: Rows) -> Lanes:
    """tanh(speed / brake speed): by how much dry friction has set in, and which way. It is 1 to the last digit where x is above 20."""
    if all_of(abs(speed) > 20.0 * p[LAW_BRAKE_SPEED]):
        return chosen(speed > 0.0, 1.0 + 0.0 * speed, -1.0)
    return math.tanh(speed / p[LAW_BRAKE_SPEED])


@njit(cache=True, error_model="numpy", forceinline=True)
def look_for_failure(w: Rows, c: Rows, p: Rows) -> None:
    """At the start of a step: whether an actuator has failed, and if it has yet to, that this is what happens next."""
    can_fail, time = p[LAW_FAILED] > 0.0, p[LAW_FAILS_AT]
    has_failed = w[TIME_NOW] * (1.0 + _ROUNDING) >= time
    c[FAILED] = chosen(can_fail & has_failed, 1.0, 0.0)
    c[EVENT] = chosen(can_fail, chosen(has_failed, _NEVER, time), _NEVER)


@njit(cache=True, error_model="numpy", forceinline=True)
def fail(w: Rows, c: Rows, p: Rows) -> None:
    """An actuator that has failed does nothing, or brakes all the time."""
    failed = c[FAILED] > 0.0
    if any_of(failed):
        for leg in range(LEGS):
            here = failed & (abs(p[LAW_FAILED] - (leg + 1.0)) < 0.5)
            c[CONTROL_FORCE + leg] = chosen(here, -direction_of(w[OUT_V + leg], p) * p[LAW_STUCK], c[CONTROL_FORCE + leg])


@njit(cache=True, error_model="numpy", forceinline=True)
def push_legs(w: Rows, c: Rows, power: Rows, with_work: bool) -> None:
    """The forces into the right side, along the legs, and their power."""
    for k in range(6):
        right = w[RIGHT + k]
        for leg in range(LEGS):
            right += c[CONTROL_AXIS + 6 * leg + k] * c[CONTROL_FORCE + leg]
        w[RIGHT + k] = right
    for leg in range(LEGS):
        w[OUT_FORCE + leg] += c[CONTROL_FORCE + leg]
        if with_work:
            power[0] += c[CONTROL_FORCE + leg] * w[OUT_V + leg]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_coupled_mass(w: Rows, c: Rows, mass: Lanes) -> None:
    """A mass that moves with the mean of the legs: m j'j into the mass matrix, j the mean of their J; -m c j into the right side."""
    bias = mean_of_legs(c, CONTROL_BIAS, 1)
    j = (
        mean_of_legs(c, CONTROL_AXIS, 6),
        mean_of_legs(c, CONTROL_AXIS + 1, 6),
        mean_of_legs(c, CONTROL_AXIS + 2, 6),
        mean_of_legs(c, CONTROL_AXIS + 3, 6),
        mean_of_legs(c, CONTROL_AXIS + 4, 6),
        mean_of_legs(c, CONTROL_AXIS + 5, 6),
    )
    for row in range(6):
        heavy = mass * j[row]
        w[RIGHT + row] -= bias * heavy
        for column in range(row + 1):
            w[SYSTEM + row * (row + 1) // 2 + column] += heavy * j[column]


@njit(cache=True, error_model="numpy", forceinline=True)
def mean_of_legs(c: Rows, first: int, apart: int) -> Lanes:
    """Mean over the legs of rows that stand so far apart."""
    total = c[first]
    for leg in range(1, LEGS):
        total += c[first + apart * leg]
    return total / 6.0


@njit(cache=True, error_model="numpy", forceinline=True)
def keep_account(w: Rows, c: Rows) -> None:
    """Largest force of one actuator so far, and the energy taken out, by the trapezoidal rule over the steps."""
    out = -c[CONTROL_FORCE] * w[OUT_V]
    c[PEAK] = larger(abs(c[CONTROL_FORCE]), c[PEAK])
    for leg in range(1, LEGS):
        out -= c[CONTROL_FORCE + leg] * w[OUT_V + leg]
        c[PEAK] = larger(abs(c[CONTROL_FORCE + leg]), c[PEAK])
    c[TAKEN_OUT] += 0.5 * (c[POWER_BEFORE] + out) * (w[TIME_NOW] - c[CLOCK])
    c[POWER_BEFORE], c[CLOCK] = out, w[TIME_NOW]
