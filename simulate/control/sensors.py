"""What a sampled controller sees: readings with noise and steps, from a failed sensor the last one, and the observer behind them.

The observer is the alpha-beta filter with a double pole at z = exp(-2 pi f T), f its bandwidth and T the sample period:

    x' = x + T v,      x = x' + (1 - z^2) (reading - x'),      v = v + (1 - z)^2 (reading - x') / T

Noise is drawn by counting, not from a stream: reading k of sensor c has the same noise whatever the step and whatever else is simulated.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from measure.common.arrays import Array
from simulate.kernel.layout import (
    CONTROL_AXIS,
    COUNTED,
    ESTIMATE,
    LAW_CAMERA,
    LAW_FAILED_SENSOR,
    LAW_FAILS_AT,
    LAW_NOISE,
    LAW_NOISE_RAD,
    LAW_OBSERVER,
    LAW_RATE,
    LAW_SEED,
    LAW_STEP,
    LAW_STEP_RAD,
    LEGS,
    READ,
    SPEED,
    TRUE_U,
    TURN,
)

# Of the generator splitmix64 (Steele, Lea, Flood, 2014).
_GOLDEN, _MIX_A, _MIX_B = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11, _ONE = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11), np.uint64(1)


@njit(cache=True, error_model="numpy")
def read_sensors(w: Array, by_run: Array, m: int, p: int, at: int, i: int, n: int, time: float, turn: float) -> None:
    """Read the sensors of a run and bring what the law is given up to date; turn is the true theta_z, rad."""
    if by_run[p + LAW_CAMERA] > 0.0:
        # on from the last reading, so that a full turn is no jump
        turn += 2.0 * math.pi * np.rint((w[m + READ] - turn) / (2.0 * math.pi))
        read_one(w, by_run, m, p, 0, turn, TURN, TURN + 1, by_run[p + LAW_NOISE_RAD], by_run[p + LAW_STEP_RAD], time)
        for leg in range(LEGS):
            lever = w[at + (CONTROL_AXIS + 6 * leg + 5) * n + i]
            w[m + ESTIMATE + leg], w[m + SPEED + leg] = lever * w[m + TURN], lever * w[m + TURN + 1]
    else:
        for leg in range(LEGS):
            u = w[m + TRUE_U + leg]
            read_one(w, by_run, m, p, leg, u, ESTIMATE + leg, SPEED + leg, by_run[p + LAW_NOISE], by_run[p + LAW_STEP], time)


@njit(cache=True, error_model="numpy")
def read_one(
    w: Array, by_run: Array, m: int, p: int, channel: int, true: float, value: int, rate: int, noise: float, step: float, time: float
) -> None:
    """One reading, and what the observer makes of it: `value` and `rate` are where that stands in the memory."""
    first, before = w[m + COUNTED] == 0.0, w[m + READ + channel]
    reading = true
    if noise > 0.0:
        reading += noise * normal(by_run[p + LAW_SEED], w[m + COUNTED], channel)
    if step > 0.0:
        reading = step * np.rint(reading / step)
    failed = int(by_run[p + LAW_FAILED_SENSOR]) == channel + 1 and time >= by_run[p + LAW_FAILS_AT]
    if failed and not first:
        reading = before
    w[m + READ + channel] = reading
    per_second, bandwidth = by_run[p + LAW_RATE], by_run[p + LAW_OBSERVER]
    if first:
        w[m + value], w[m + rate] = reading, 0.0
    elif bandwidth > 0.0:
        z = math.exp(-2.0 * math.pi * bandwidth / per_second)
        ahead = w[m + value] + w[m + rate] / per_second
        w[m + value] = ahead + (1.0 - z * z) * (reading - ahead)
        w[m + rate] += (1.0 - z) * (1.0 - z) * (reading - ahead) * per_second
    else:
        w[m + value], w[m + rate] = reading, (reading - before) * per_second


@njit(cache=True, error_model="numpy")
def normal(seed: float, sample: float, channel: int) -> float:
    """A standard normal number for a sample of a channel (Box and Muller), the same at every call."""
    place = ((np.uint64(seed) * np.uint64(1 << 24) + np.uint64(sample)) * np.uint64(8) + np.uint64(channel)) * np.uint64(2)
    radius = math.sqrt(-2.0 * math.log(uniform(place)))
    return radius * math.cos(2.0 * math.pi * uniform(place + _ONE))


@njit(cache=True, error_model="numpy")
def uniform(place: np.uint64) -> float:
    """A number between 0 and 1, neither of them, for a place in the sequence of splitmix64."""
    z = (place + _ONE) * _GOLDEN
    z = (z ^ (z >> _30)) * _MIX_A
    z = (z ^ (z >> _27)) * _MIX_B
    z = z ^ (z >> _31)
    return (np.float64(z >> _11) + 0.5) * 2.0**-53
