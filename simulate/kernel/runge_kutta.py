"""The classical Runge-Kutta method on the memory of a block, stage by stage, for states and work done alike."""

from __future__ import annotations

import math

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.effect_calls import worked, workers
from simulate.dispatch.programs import Calls
from simulate.kernel.layout import (
    ELONGATION,
    HEADING,
    LEGS,
    OUT,
    OUT_R,
    POWERS,
    RATE,
    STATE,
    STATES,
    STORED,
    TOTAL,
    TRIAL,
    TURNED,
)


@njit(cache=True, error_model="numpy", forceinline=True)
def end_step(w: Array, calls: Calls, step: float, n: int, ledger: bool) -> None:
    """Add what the stages of the step before gathered (nothing at the release), and take the state for the trial state."""
    for k in range((STATES + POWERS) * n):
        w[STATE * n + k] += step / 6.0 * w[TOTAL * n + k]
    if ledger:
        for k in range(worked(workers(calls), n) - worked(0, n)):
            w[worked(2 * workers(calls), n) + k] += step / 6.0 * w[worked(workers(calls), n) + k]
    for i in range(n):
        a, b, c, d = w[(STATE + 3) * n + i], w[(STATE + 4) * n + i], w[(STATE + 5) * n + i], w[(STATE + 6) * n + i]
        per = 1.0 / math.sqrt(a * a + b * b + c * c + d * d)
        w[(STATE + 3) * n + i], w[(STATE + 4) * n + i] = a * per, b * per
        w[(STATE + 5) * n + i], w[(STATE + 6) * n + i] = c * per, d * per
    for k in range(STATES * n):
        w[TRIAL * n + k] = w[STATE * n + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def carry_legs(w: Array, n: int) -> None:
    """Carry the legs to the start of the step: elongation, hysteretic force, last reversal."""
    for k in range(LEGS * n):
        before, turned, heading = w[ELONGATION * n + k], w[TURNED * n + k], w[HEADING * n + k]
        travel = w[OUT * n + k] - before
        w[TURNED * n + k] = before if travel * heading < 0.0 else turned
        w[HEADING * n + k] = travel if travel != 0.0 else heading
        w[ELONGATION * n + k] = w[OUT * n + k]
        w[STORED * n + k] = w[OUT_R * n + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def look_ahead(w: Array, reach: float, n: int) -> None:
    """The trial state along the rates of the last stage."""
    for k in range(STATES * n):
        w[TRIAL * n + k] = w[STATE * n + k] + reach * w[RATE * n + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def gather(w: Array, calls: Calls, reach: float, step: float, n: int, ledger: bool) -> None:
    """Weigh the rates of a stage into the sums of the step: 1, 2, 2, 1."""
    keep = 0.0 if reach == 0.0 else 1.0
    weight = 1.0 if reach == 0.0 or reach == step else 2.0
    for k in range((STATES + POWERS) * n):
        w[TOTAL * n + k] = keep * w[TOTAL * n + k] + weight * w[RATE * n + k]
    if ledger:
        for k in range(worked(workers(calls), n) - worked(0, n)):
            summed = worked(workers(calls), n) + k
            w[summed] = keep * w[summed] + weight * w[worked(0, n) + k]
