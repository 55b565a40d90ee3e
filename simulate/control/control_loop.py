"""A controller in the kernel: at every stage of a step, once all legs are known, what its actuators do; at a sample, sensors and law.

Commands are held from sample to sample. A brake's force follows its command with a lag, a(t) = c + (a_0 - c) exp(-t / lag), exactly from
step to step and at every stage; its friction follows the speed at the stage, so it takes energy out at any speed and any command:

    F_i = -tanh(v_i / v_0) a_i
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import cfunc, njit
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.control.sensors import read_sensors
from simulate.dispatch.compiled_code import compiled_once
from simulate.dispatch.formulas import CONTROL, address, call_law
from simulate.dispatch.intrinsics import pointer
from simulate.kernel.layout import (
    CLOCK,
    CONTROL_AXIS,
    CONTROL_BIAS,
    CONTROL_FORCE,
    CONTROL_MEMORY,
    CONTROL_ROWS,
    COUNTED,
    ESTIMATE,
    FORCE,
    HELD,
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
    PEAK,
    POWER_BEFORE,
    QUEUE,
    QUEUE_LENGTH,
    QUEUED,
    RIGHT,
    SPEED,
    STEP,
    SYSTEM,
    TAKEN,
    TAKEN_OUT,
    TIME_NOW,
    TRIAL,
    TRUE_U,
    TRUE_V,
    TURN,
)
from simulate.model.control import Controller, require_law

_SOON = 1e-7  # of a sample period: rounding of times


@compiled_once
def control_rows(kind: type[Controller], place: int) -> NDArray[np.int64]:
    """The row of a law in the table of formulas: its address, the place of the controller's parameters, the address of what calls it."""
    return np.array([[address(require_law(kind).command, "law"), place, _loop().address]], dtype=np.int64)


@compiled_once
def _loop() -> Any:
    return cfunc(CONTROL, cache=True, error_model="numpy")(_control_block)


def _control_block(memory: Any, size: int, every: Any, each: int, place: int, law: int, at: int, power: int, n: int, ahead: float) -> None:
    """The controllers of a block: `at` is where their memory begins, `power` where their power stands, if account of it is kept.

    ahead : how far the stage looks ahead, as a part of the step.
    """
    w, by_run = carray(memory, size), carray(every, each)
    for i in range(n):
        time, reach = w[TIME_NOW * n + i], ahead * w[STEP * n + i]
        m, p = at + CONTROL_ROWS * n + i * CONTROL_MEMORY, i * (each // n) + place
        for leg in range(LEGS):
            w[m + TRUE_U + leg], w[m + TRUE_V + leg] = w[(OUT + leg) * n + i], w[(OUT_V + leg) * n + i]
        find_forces(w, by_run, m, p, law, at, i, n, time, reach)
        if by_run[p + LAW_FAILED] > 0.0 and time >= by_run[p + LAW_FAILS_AT]:
            leg = int(by_run[p + LAW_FAILED]) - 1
            w[m + FORCE + leg] = -direction_of(w[m + TRUE_V + leg], by_run[p + LAW_BRAKE_SPEED]) * by_run[p + LAW_STUCK]
        for leg in range(LEGS):
            w[at + (CONTROL_FORCE + leg) * n + i] = w[m + FORCE + leg]
        if by_run[p + LAW_COUPLED_MASS] > 0.0:
            add_coupled_mass(w, by_run[p + LAW_COUPLED_MASS], at, i, n)
        if ahead == 0.0:
            keep_account(w, m, time)
    push_legs(w, at, power, n)


@njit(cache=True, error_model="numpy")
def find_forces(w: Array, by_run: Array, m: int, p: int, law: int, at: int, i: int, n: int, time: float, reach: float) -> None:
    """Forces of the actuators of a run at this stage, N: passive by the law, ideal by its command at once, others by what is held."""
    if by_run[p + LAW_PASSIVE] > 0.0:
        call_law(law, law_arguments(w, by_run, m, p, TRUE_U, TRUE_V, FORCE, time))
    elif by_run[p + LAW_RATE] == 0.0:
        know_exactly(w, by_run, m, p, at, i, n)
        call_law(law, law_arguments(w, by_run, m, p, ESTIMATE, SPEED, LEVEL, time))
        for leg in range(LEGS):
            w[m + LEVEL + leg] = command_of(w[m + LEVEL + leg], w[m + SPEED + leg], by_run, p)
            w[m + FORCE + leg] = force_of(w[m + LEVEL + leg], w[m + TRUE_V + leg], by_run, p)
    else:
        if reach == 0.0:
            begin_step(w, by_run, m, p, law, at, i, n, time)
        lag = by_run[p + LAW_LAG]
        fading = math.exp(-reach / lag) if lag > 0.0 else 0.0
        for leg in range(LEGS):
            level = w[m + HELD + leg] + (w[m + LEVEL + leg] - w[m + HELD + leg]) * fading
            w[m + FORCE + leg] = force_of(level, w[m + TRUE_V + leg], by_run, p)


@njit(cache=True, error_model="numpy")
def law_arguments(w: Array, by_run: Array, m: int, p: int, u: int, v: int, out: int, time: float) -> Any:
    """What a law is called with: time, elongation, speed, theta_z and its rate, the law's memory, its gains, and where its forces go."""
    turn, own, gains = pointer(w, m + TURN), pointer(w, m + OWN), pointer(by_run, p + LAW_GAINS)
    return time, pointer(w, m + u), pointer(w, m + v), turn, own, gains, pointer(w, m + out)


@njit(cache=True, error_model="numpy")
def know_exactly(w: Array, by_run: Array, m: int, p: int, at: int, i: int, n: int) -> None:
    """What an ideal sensor gives the law: the truth, of a camera that part of it which comes from the rotation."""
    if by_run[p + LAW_CAMERA] > 0.0:
        w[m + TURN], w[m + TURN + 1] = 2.0 * math.atan2(w[(TRIAL + 6) * n + i], w[(TRIAL + 3) * n + i]), w[(TRIAL + 12) * n + i]
    for leg in range(LEGS):
        lever = w[at + (CONTROL_AXIS + 6 * leg + 5) * n + i]
        by_camera = by_run[p + LAW_CAMERA] > 0.0
        w[m + ESTIMATE + leg] = lever * w[m + TURN] if by_camera else w[m + TRUE_U + leg]
        w[m + SPEED + leg] = lever * w[m + TURN + 1] if by_camera else w[m + TRUE_V + leg]


@njit(cache=True, error_model="numpy")
def begin_step(w: Array, by_run: Array, m: int, p: int, law: int, at: int, i: int, n: int, time: float) -> None:
    """At the start of a step: actuators carried on, commands that are due taken, and at a sample sensors read and the law computed."""
    lag = by_run[p + LAW_LAG]
    fading = math.exp(-(time - w[m + CLOCK]) / lag) if lag > 0.0 else 0.0
    for leg in range(LEGS):
        w[m + LEVEL + leg] = w[m + HELD + leg] + (w[m + LEVEL + leg] - w[m + HELD + leg]) * fading
    take_due(w, m, time)
    samples = time * by_run[p + LAW_RATE] + _SOON
    if samples >= w[m + COUNTED]:
        turn = 2.0 * math.atan2(w[(TRIAL + 6) * n + i], w[(TRIAL + 3) * n + i])
        read_sensors(w, by_run, m, p, at, i, n, time, turn)
        place = m + QUEUE + 7 * (int(w[m + QUEUED]) % QUEUE_LENGTH)
        call_law(law, law_arguments(w, by_run, m, p, ESTIMATE, SPEED, place + 1 - m, time))
        for leg in range(LEGS):
            w[place + 1 + leg] = command_of(w[place + 1 + leg], w[m + SPEED + leg], by_run, p)
        w[place] = time + by_run[p + LAW_DELAY] - _SOON / by_run[p + LAW_RATE]
        w[m + QUEUED] += 1.0
        w[m + COUNTED] = math.floor(samples) + 1.0
        take_due(w, m, time)


@njit(cache=True, error_model="numpy")
def take_due(w: Array, m: int, time: float) -> None:
    """Commands that have arrived, the last one stays."""
    while w[m + TAKEN] < w[m + QUEUED]:
        place = m + QUEUE + 7 * (int(w[m + TAKEN]) % QUEUE_LENGTH)
        if w[place] > time:
            return
        for leg in range(LEGS):
            w[m + HELD + leg] = w[place + 1 + leg]
        w[m + TAKEN] += 1.0


@njit(cache=True, error_model="numpy")
def command_of(wanted: float, speed: float, by_run: Array, p: int) -> float:
    """Command for a force that the law asks for: of a motor that force, of a brake how hard it presses, where it can give it."""
    limit = by_run[p + LAW_LIMIT]
    if by_run[p + LAW_MOTOR] > 0.0:
        return min(max(wanted, -limit), limit)
    along = 1.0 if by_run[p + LAW_CAMERA] > 0.0 else direction_of(speed, by_run[p + LAW_BRAKE_SPEED])
    return min(max(-along * wanted, 0.0), limit)


@njit(cache=True, error_model="numpy")
def force_of(level: float, speed: float, by_run: Array, p: int) -> float:
    """Force of an actuator on its leg, N: a motor's own, a brake's friction."""
    return level if by_run[p + LAW_MOTOR] > 0.0 else -direction_of(speed, by_run[p + LAW_BRAKE_SPEED]) * level


@njit(cache=True, error_model="numpy")
def direction_of(speed: float, within: float) -> float:
    """tanh(speed / within), which is 1 to the last digit beyond 20; a leg is rarely slower."""
    x = speed / within
    return math.copysign(1.0, x) if abs(x) > 20.0 else math.tanh(x)


@njit(cache=True, error_model="numpy")
def push_legs(w: Array, at: int, power: int, n: int) -> None:
    """The forces of all runs of a block into the right side, along the legs, and their power."""
    for leg in range(LEGS):
        force = at + (CONTROL_FORCE + leg) * n
        for k in range(6):
            along, right = at + (CONTROL_AXIS + 6 * leg + k) * n, (RIGHT + k) * n
            for i in range(n):
                w[right + i] += w[along + i] * w[force + i]
        for i in range(n):
            w[(OUT_FORCE + leg) * n + i] += w[force + i]
        if power >= 0:
            for i in range(n):
                w[power + i] += w[force + i] * w[(OUT_V + leg) * n + i]


@njit(cache=True, error_model="numpy")
def add_coupled_mass(w: Array, mass: float, at: int, i: int, n: int) -> None:
    """A mass that moves with the mean of the legs: m j'j into the mass matrix, j the mean of their J; -m c j into the right side."""
    bias = 0.0
    for leg in range(LEGS):
        bias += w[at + (CONTROL_BIAS + leg) * n + i] / LEGS
    for row in range(6):
        one = mean_of_legs(w, at, row, i, n)
        w[(RIGHT + row) * n + i] -= mass * bias * one
        for column in range(row + 1):
            w[(SYSTEM + row * (row + 1) // 2 + column) * n + i] += mass * one * mean_of_legs(w, at, column, i, n)


@njit(cache=True, error_model="numpy")
def mean_of_legs(w: Array, at: int, k: int, i: int, n: int) -> float:
    """Mean over the legs of one entry of J."""
    total = 0.0
    for leg in range(LEGS):
        total += w[at + (CONTROL_AXIS + 6 * leg + k) * n + i]
    return total / LEGS


@njit(cache=True, error_model="numpy")
def keep_account(w: Array, m: int, time: float) -> None:
    """Largest force of one actuator so far, and the energy taken out, by the trapezoidal rule over the steps."""
    out = 0.0
    for leg in range(LEGS):
        out -= w[m + FORCE + leg] * w[m + TRUE_V + leg]
        w[m + PEAK] = max(w[m + PEAK], abs(w[m + FORCE + leg]))
    w[m + TAKEN_OUT] += 0.5 * (w[m + POWER_BEFORE] + out) * (time - w[m + CLOCK])
    w[m + POWER_BEFORE], w[m + CLOCK] = out, time
