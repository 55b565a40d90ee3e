"""A deployment, compiled: RK4 steps through the mechanics, rows of numbers in, samples out.

The hysteretic force of each leg is no state: it is the exact function of the path since the last step, which takes the
stiffness of beta out of the integration and leaves 13 states. Runs stand side by side in blocks; each is by itself, so the
block's size and the number of cores change no digit.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from measure.tables import Array

from .calls import Calls, calls_of
from .compiled import Program
from .hooks import SCRATCH
from .intrinsics import uncounted
from .law import NEVER
from .layout import (
    ELONGATION as AT_ELONGATION,
)
from .layout import (
    HEADING,
    KINETIC,
    LEGS,
    OUT,
    OUT_FORCE,
    OUT_R,
    POWERS,
    RATE,
    ROTATION,
    ROWS,
    SPENT,
    STATE,
    STATES,
    TOTAL,
    TRIAL,
    TURNED,
)
from .layout import STORED as AT_STORED
from .mechanics import derivative, rotate
from .packing import CENTRE, JOINT, LEG, LEG_SIZE, PARAMETERS, POSITION, START_FORCE, STOWED

# Columns of a sample: pose (7), twist (6), elongation (6), hysteretic force (6), leg force (6), energies (5).
POSE, TWIST, ELONGATION, STORED, FORCE, ENERGY = 0, 7, 13, 19, 25, 31
BY_LEGS, BY_STOPS, BY_WEIGHT, BY_EFFECTS = 1, 2, 3, 4
SAMPLE = ENERGY + 5
Views = tuple[Array, Array, Array]  # memory of a block, its parameters as rows, and run after run
BEYOND = 1e6  # a state outside of this has diverged


@njit(cache=True, parallel=True, error_model="numpy")
def deploy_kernel(values: Array, called: Program, step: float, stride: int, samples: Array, good: NDArray[np.int64], lanes: Any) -> None:
    """Integrate every row of `values`, block by block on all cores.

    samples : (runs, n, SAMPLE), filled with one sample every `stride` steps, NaN from the one on that is not finite.
    good : (runs,) number of good samples.
    """
    n = len(lanes)
    for block in prange((values.shape[0] + n - 1) // n):
        deploy_block(values, block * n, called, step, stride, samples, good, lanes)


@njit(cache=True, error_model="numpy")
def deploy_block(
    values: Array, first: int, called: Program, step: float, stride: int, samples: Array, good: NDArray[np.int64], lanes: Any
) -> None:
    """One block of deployments, from run `first` on."""
    n = len(lanes)
    runs = min(n, values.shape[0] - first)
    mine = rows_of_block(values, first, n)
    fixed = transposed(mine, n)
    w = start(fixed, n)
    views = uncounted(w), uncounted(fixed), uncounted(mine)
    deploy_runs(views, calls_of(called), step, stride, samples[first : first + runs], good[first : first + runs], lanes)
    w[0], fixed[0], mine[0] = 0.0, 0.0, 0.0  # kept alive until here


@njit(cache=True, error_model="numpy")
def deploy_runs(views: Views, calls: Calls, step: float, stride: int, samples: Array, good: NDArray[np.int64], lanes: Any) -> None:
    """The deployments of one block, from the release on."""
    w, fixed, mine = views
    n, count, runs = len(lanes), samples.shape[1], samples.shape[0]
    good[:] = count
    for sample in range(count):
        for j in range(stride):
            time = (sample * stride + j) * step
            begin_step(w, fixed, mine, calls, time, step, lanes)
            if j == 0:
                for i in range(runs):
                    if good[i] == count and not record(w, fixed, i, n, samples[i, sample]):
                        samples[i, sample:, :] = np.nan
                        good[i] = sample
                if sample + 1 == count:
                    return
            end_step(w, fixed, mine, calls, time, step, lanes)


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
def start(fixed: Array, n: int) -> Array:
    """Memory of a block at the release."""
    w = np.zeros(ROWS * n + SCRATCH)
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
def begin_step(w: Array, fixed: Array, mine: Array, calls: Calls, time: float, step: float, lanes: Any) -> None:
    """Rates at the start of a step; and the legs are carried to it: elongation, hysteretic force, last reversal."""
    n = len(lanes)
    for k in range(STATES * n):
        w[TRIAL * n + k] = w[STATE * n + k]
    derivative(w, fixed, mine, calls, max(time - step, 0.0), time, lanes)
    for k in range(LEGS * n):
        before, turned, heading = w[AT_ELONGATION * n + k], w[TURNED * n + k], w[HEADING * n + k]
        travel = w[OUT * n + k] - before
        w[TURNED * n + k] = before if travel * heading < 0.0 else turned
        w[HEADING * n + k] = travel if travel != 0.0 else heading
        w[AT_ELONGATION * n + k] = w[OUT * n + k]
        w[AT_STORED * n + k] = w[OUT_R * n + k]


@njit(cache=True, error_model="numpy")
def end_step(w: Array, fixed: Array, mine: Array, calls: Calls, time: float, step: float, lanes: Any) -> None:
    """The other three stages of the classical Runge-Kutta method, and the step itself, of states and work done."""
    n = len(lanes)
    for k in range((STATES + POWERS) * n):
        w[TOTAL * n + k] = w[RATE * n + k]
    for stage in range(3):
        reach = step if stage == 2 else 0.5 * step
        weight = 1.0 if stage == 2 else 2.0
        for k in range(STATES * n):
            w[TRIAL * n + k] = w[STATE * n + k] + reach * w[RATE * n + k]
        derivative(w, fixed, mine, calls, time, time + reach, lanes)
        for k in range((STATES + POWERS) * n):
            w[TOTAL * n + k] += weight * w[RATE * n + k]
    for k in range((STATES + POWERS) * n):
        w[STATE * n + k] += step / 6.0 * w[TOTAL * n + k]
    for i in range(n):
        a, b, c, d = w[(STATE + 3) * n + i], w[(STATE + 4) * n + i], w[(STATE + 5) * n + i], w[(STATE + 6) * n + i]
        per = 1.0 / math.sqrt(a * a + b * b + c * c + d * d)
        w[(STATE + 3) * n + i], w[(STATE + 4) * n + i] = a * per, b * per
        w[(STATE + 5) * n + i], w[(STATE + 6) * n + i] = c * per, d * per


@njit(cache=True, error_model="numpy")
def bounded(w: Array, i: int, n: int) -> bool:
    """Whether the state of a run is finite and within all reason."""
    within = True
    for k in range(STATES):
        within &= abs(w[(STATE + k) * n + i]) < BEYOND
    return within


@njit(cache=True, error_model="numpy")
def record(w: Array, fixed: Array, i: int, n: int, sample: Array) -> bool:
    """Fill one sample of a run at the start of a step; false where it has diverged."""
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
        sample[ENERGY + BY_LEGS + k] = w[(SPENT + k) * n + i]
    for leg in range(LEGS):
        sample[ELONGATION + leg] = w[(OUT + leg) * n + i]
        sample[STORED + leg] = w[(OUT_R + leg) * n + i]
        sample[FORCE + leg] = w[(OUT_FORCE + leg) * n + i]
    sample[ENERGY] = w[KINETIC * n + i]
    return True
