"""What a sampled controller sees: readings with noise and steps, from a failed sensor the last one, and the observer behind them.

The observer is the alpha-beta filter with a double pole at z = exp(-2 pi f T), f its bandwidth and T the sample period:

    x' = x + T v,      x = x' + (1 - z^2) (reading - x'),      v = v + (1 - z)^2 (reading - x') / T

Noise is drawn by counting, not from a stream: reading k of sensor c has the same noise whatever the step and whatever else is simulated.
"""

from __future__ import annotations

import math

from numba import njit

from simulate.dispatch.counted_noise import normal
from simulate.dispatch.lanes import Lanes, Mask, Rows, any_of, chosen
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
    OUT,
    READ,
    SPEED,
    TIME_NOW,
    TRUE_TURN,
    TURN,
)
from simulate.law import nearest_whole


@njit(cache=True, error_model="numpy", forceinline=True)
def read_sensors(w: Rows, c: Rows, p: Rows, due: Mask) -> None:
    """Read the sensors of the runs that are due and bring what the law is given up to date.

    c : rows of the controller's memory. p : its parameters.
    """
    z = chosen(p[LAW_OBSERVER] > 0.0, math.exp(-2.0 * math.pi * p[LAW_OBSERVER] / p[LAW_RATE]), 0.0)
    by_camera = p[LAW_CAMERA] > 0.0
    if any_of(by_camera):
        # on from the last reading, so that a full turn is no jump
        turn = c[TRUE_TURN] + 2.0 * math.pi * nearest_whole((c[READ] - c[TRUE_TURN]) / (2.0 * math.pi))
        read_one(w, c, p, due & by_camera, 0, turn, TURN, TURN + 1, p[LAW_NOISE_RAD], p[LAW_STEP_RAD], z)
        for leg in range(LEGS):
            lever = c[CONTROL_AXIS + 6 * leg + 5]
            c[ESTIMATE + leg] = chosen(due & by_camera, lever * c[TURN], c[ESTIMATE + leg])
            c[SPEED + leg] = chosen(due & by_camera, lever * c[TURN + 1], c[SPEED + leg])
    by_legs = due & (p[LAW_CAMERA] < 0.5)
    if any_of(by_legs):
        for leg in range(LEGS):
            read_one(w, c, p, by_legs, leg, w[OUT + leg], ESTIMATE + leg, SPEED + leg, p[LAW_NOISE], p[LAW_STEP], z)


@njit(cache=True, error_model="numpy", forceinline=True)
def read_one(
    w: Rows, c: Rows, p: Rows, due: Mask, channel: int, true: Lanes, value: int, rate: int, noise: Lanes, step: Lanes, z: Lanes
) -> None:
    """One reading, and what the observer makes of it: `value` and `rate` are the rows of that; z is 0 without an observer."""
    reading, before, per_second, later = true, c[READ + channel], p[LAW_RATE], c[COUNTED] > 0.5
    if any_of(noise > 0.0):
        reading = reading + noise * normal(p[LAW_SEED], c[COUNTED], channel)
    if any_of(step > 0.0):
        reading = chosen(step > 0.0, step * nearest_whole(reading / step), reading)
    failed = later & (abs(p[LAW_FAILED_SENSOR] - (channel + 1.0)) < 0.5) & (w[TIME_NOW] >= p[LAW_FAILS_AT])
    reading = chosen(failed, before, reading)
    c[READ + channel] = chosen(due, reading, before)
    observed = z > 0.0
    ahead = c[value] + c[rate] / per_second
    seen = chosen(observed, ahead + (1.0 - z * z) * (reading - ahead), reading)
    faster = c[rate] + (1.0 - z) * (1.0 - z) * (reading - ahead) * per_second
    moving = chosen(observed, faster, (reading - before) * per_second)
    c[value] = chosen(due, chosen(later, seen, reading), c[value])
    c[rate] = chosen(due, chosen(later, moving, 0.0), c[rate])
