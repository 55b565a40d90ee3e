"""A deployment, compiled: RK4 steps through the mechanics, one row of numbers in, samples out.

The hysteretic force of each leg is no state: it is the exact function of the path since the last step, which takes the
stiffness of beta out of the integration and leaves 13 states.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from measure.tables import Array

from .compiled import Program
from .crosswise import ARM, AXIS, ROTATION
from .law import NEVER
from .mechanics import (
    LEG_OUT,
    LEGS,
    POWERS,
    STATES,
    WORK,
    Legs,
    derivative,
    kinetic_energy,
    leg_axis,
    rotate,
    stored_force,
)
from .packing import ANGULAR, CENTRE, LEG, LEG_SIZE, POSITION, QUATERNION, START_FORCE, STOWED, VELOCITY

# Columns of a sample: pose (7), twist (6), elongation (6), hysteretic force (6), leg force (6), energies (5).
POSE, TWIST, ELONGATION, STORED, FORCE, ENERGY = 0, 7, 13, 19, 25, 31
KINETIC, BY_LEGS, BY_STOPS, BY_WEIGHT, BY_EFFECTS = 0, 1, 2, 3, 4
SAMPLE = ENERGY + 5


@njit(cache=True, error_model="numpy")
def deploy_kernel(values: Array, called: Program, step: float, stride: int, samples: Array) -> int:
    """Integrate one deployment and fill `samples`, (n, SAMPLE), one row every `stride` steps.

    Returns the number of good rows: less than n where the run went non-finite. Rows behind are NaN.
    """
    state, work = start_state(values), np.zeros(WORK)
    spent, rates = np.zeros(POWERS), np.zeros((3, STATES + POWERS))
    legs = start_legs(values, state, work)
    for i in range(samples.shape[0]):
        time = i * stride * step
        if not record(values, called, state, legs, time, spent, work, rates[0], samples[i]):
            samples[i:, :] = np.nan
            return i
        if i + 1 < samples.shape[0]:
            for j in range(stride):
                rk4(values, called, state, legs, time + j * step, step, spent, work, rates)
                close_step(values, called, state, legs, time + j * step, step, work)
    return samples.shape[0]


@njit(cache=True, parallel=True, error_model="numpy")
def deploy_many_kernel(values: Array, called: Program, step: float, stride: int, samples: Array, good: NDArray[np.int64]) -> None:
    """`deploy_kernel` for every row of `values`, on all cores; samples is (runs, n, SAMPLE), good (runs,)."""
    for run in prange(values.shape[0]):
        good[run] = deploy_kernel(values[run], called, step, stride, samples[run])


@njit(cache=True)
def start_state(values: Array) -> Array:
    """State at the release."""
    state = np.empty(STATES)
    state[0:3] = values[POSITION : POSITION + 3]
    state[3:7] = values[QUATERNION : QUATERNION + 4]
    state[7:10] = values[VELOCITY : VELOCITY + 3]
    state[10:13] = values[ANGULAR : ANGULAR + 3]
    return state


@njit(cache=True)
def start_legs(values: Array, state: Array, w: Array) -> Legs:
    """Elongation and force of each leg at the release."""
    legs = Legs(np.empty(LEGS), np.empty(LEGS), np.empty(LEGS), np.zeros(LEGS))
    rotate(state, w)
    for leg in range(LEGS):
        at = LEG + leg * LEG_SIZE
        legs.elongation[leg] = leg_axis(values, at, state, w, ROTATION, w, ARM, w, AXIS) - values[at + STOWED]
        legs.stored[leg] = values[at + START_FORCE]
        legs.turned[leg] = NEVER
    return legs


@njit(cache=True, error_model="numpy")
def rk4(values: Array, called: Program, state: Array, legs: Legs, t: float, step: float, spent: Array, w: Array, rates: Array) -> None:
    """One step of the classical Runge-Kutta method for the state and for the work done (spent)."""
    slope, total, trial = rates[0], rates[1], rates[2, :STATES]
    total[:] = 0.0
    for stage in range(4):
        reach = 0.0 if stage == 0 else (step if stage == 3 else 0.5 * step)
        weight = step / 6.0 if stage in (0, 3) else step / 3.0
        for k in range(STATES):
            trial[k] = state[k] + reach * slope[k] if stage > 0 else state[k]
        derivative(values, called, trial, legs, t, t + reach, w, slope)
        for k in range(STATES + POWERS):
            total[k] += weight * slope[k]
    for k in range(STATES):
        state[k] += total[k]
    for k in range(POWERS):
        spent[k] += total[STATES + k]
    norm = math.sqrt(state[3] ** 2 + state[4] ** 2 + state[5] ** 2 + state[6] ** 2)
    for k in range(3, 7):
        state[k] /= norm


@njit(cache=True, error_model="numpy")
def close_step(values: Array, called: Program, state: Array, legs: Legs, t: float, step: float, w: Array) -> None:
    """Carry elongation, hysteretic force and last reversal of each leg to the end of the step."""
    rotate(state, w)
    for leg in range(LEGS):
        at = LEG + leg * LEG_SIZE
        u = leg_axis(values, at, state, w, ROTATION, w, ARM, w, AXIS) - values[at + STOWED]
        travel = u - legs.elongation[leg]
        legs.stored[leg] = stored_force(values, called, at, legs.elongation[leg], legs.stored[leg], u, travel / step, t, t + step, w)
        if travel * legs.heading[leg] < 0.0:
            legs.turned[leg] = legs.elongation[leg]
        if travel != 0.0:
            legs.heading[leg] = travel
        legs.elongation[leg] = u


@njit(cache=True, error_model="numpy")
def record(values: Array, called: Program, state: Array, legs: Legs, t: float, spent: Array, w: Array, slope: Array, sample: Array) -> bool:
    """Fill one sample; false where the state is no longer finite."""
    for k in range(STATES):
        if not math.isfinite(state[k]) or abs(state[k]) > 1e6:
            return False
    derivative(values, called, state, legs, t, t, w, slope)
    for k in range(3):
        w[ARM + k] = w[3 * k] * values[CENTRE] + w[3 * k + 1] * values[CENTRE + 1] + w[3 * k + 2] * values[CENTRE + 2]
        sample[POSE + k] = state[k] - w[ARM + k]
    sample[POSE + 3 : POSE + 7] = state[3:7]
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        sample[TWIST + k] = state[7 + k] - (state[10 + i] * w[ARM + j] - state[10 + j] * w[ARM + i])
        sample[TWIST + 3 + k] = state[10 + k]
    sample[ELONGATION : ELONGATION + LEGS] = w[LEG_OUT : LEG_OUT + 6]
    sample[STORED : STORED + LEGS] = w[LEG_OUT + 12 : LEG_OUT + 18]
    sample[FORCE : FORCE + LEGS] = w[LEG_OUT + 18 : LEG_OUT + 24]
    sample[ENERGY + KINETIC] = kinetic_energy(values, called, state, w)
    sample[ENERGY + BY_LEGS : ENERGY + BY_LEGS + POWERS] = spent
    return True
