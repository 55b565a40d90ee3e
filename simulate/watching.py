"""Deployments of which only the responses are kept: a sweep's kernel, with memory for one run at a time."""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange

from measure.tables import Array

from .compiled import Program
from .mechanics import LEG_OUT, LEGS, POWERS, STATES, WORK, stop_force
from .packing import FULL, LEG, LEG_SIZE
from .responses import DIVERGED, FULL_HEIGHT, LATERAL, STOP_FORCE, THETA_Z, TILT
from .six_legs import POSE, SAMPLE, close_step, record, rk4, start_legs, start_state


@njit(cache=True, parallel=True, error_model="numpy")
def respond_kernel(values: Array, called: Program, step: float, stride: int, count: int, full_height: float, answers: Array) -> None:
    """Responses of every row of `values`, on all cores, into answers (runs, COUNT); each run by itself, whatever the cores."""
    for run in prange(values.shape[0]):
        respond(values[run], called, step, stride, count, full_height, answers[run])


@njit(cache=True, error_model="numpy")
def respond(values: Array, called: Program, step: float, stride: int, count: int, full_height: float, answer: Array) -> None:
    """Responses of one deployment, sampled `count` times."""
    state, work, sample = start_state(values), np.zeros(WORK), np.empty(SAMPLE)
    spent, rates = np.zeros(POWERS), np.zeros((3, STATES + POWERS))
    legs, turn = start_legs(values, state, work), np.zeros(2)
    answer[:] = 0.0
    answer[FULL_HEIGHT] = answer[DIVERGED] = np.nan
    for i in range(count):
        time = i * stride * step
        if not record(values, called, state, legs, time, spent, work, rates[0], sample):
            answer[:DIVERGED] = np.nan
            answer[DIVERGED] = time
            return
        watch(values, sample, work, time, full_height, turn, answer)
        if i + 1 < count:
            for j in range(stride):
                rk4(values, called, state, legs, time + j * step, step, spent, work, rates)
                close_step(values, called, state, legs, time + j * step, step, work)


@njit(cache=True, error_model="numpy")
def watch(values: Array, sample: Array, w: Array, time: float, full_height: float, turn: Array, answer: Array) -> None:
    """Work one sample into the responses; turn holds theta_z so far, unwrapped, and its last raw value."""
    qw, qx, qy, qz = sample[POSE + 3], sample[POSE + 4], sample[POSE + 5], sample[POSE + 6]
    raw = 2.0 * math.atan2(qz, qw)
    gained = raw - turn[1]
    turn[0] += gained - 2.0 * math.pi * np.rint(gained / (2.0 * math.pi)) if time > 0.0 else raw
    turn[1] = raw
    if abs(turn[0]) > abs(answer[THETA_Z]):
        answer[THETA_Z] = turn[0]
    answer[LATERAL] = max(answer[LATERAL], math.hypot(sample[POSE], sample[POSE + 1]))
    answer[TILT] = max(answer[TILT], 2.0 * math.atan2(math.hypot(qx, qy), math.hypot(qw, qz)))
    if math.isnan(answer[FULL_HEIGHT]) and sample[POSE + 2] >= full_height:
        answer[FULL_HEIGHT] = time
    for leg in range(LEGS):
        at = LEG + leg * LEG_SIZE
        stop = stop_force(values, w[LEG_OUT + leg] - values[at + FULL], w[LEG_OUT + 6 + leg])
        answer[STOP_FORCE] = max(answer[STOP_FORCE], abs(stop))
