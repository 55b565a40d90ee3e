"""How much of a measurement is noise, read from the measurement itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from identify.campaign.prepared import LoopRun
from identify.campaign.run import Run
from identify.loops.differentiation import noise_of, quantum_of
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array
from measure.tables.trajectory import Trajectory
from simulate.model.model import Model

_ORDER = 4
_GAIN = float(np.sqrt(70.0))  # of the fourth difference for white noise: sqrt(sum of squared binomials)
_PER_SIGMA = 1.4826
_FEW = 16
_FINE_M, _FINE_RAD, _FINE_FORCE = 1e-5, 1e-4, 1e-4  # noise of a fine camera; of a fine load cell, over the largest force
_QUIET_M, _QUIET_RAD, _QUIET_FORCE = 1e-6, 2e-6, 1e-5  # no such instrument is more quiet than this
_SHORT = 1e-9  # of the square of a column: nothing


def channel_noise(trajectory: Trajectory, channel: str) -> Array:
    """One standard deviation of each sample of a channel, (n,).

    The fourth difference takes away whatever moves smoothly from frame to frame and leaves the noise; its median is not
    moved by a few jolts. Where the table carries a sigma, only its course over the film is taken and its size is checked
    against the data; the larger of both counts, for a smaller one would turn a tracker's modesty into a gap. A channel without noise
    counts as one that was measured well.
    """
    values = trajectory.channels[channel]
    stated = trajectory.sigma.get(channel)
    shape = np.ones(len(values)) if stated is None else np.where(np.isfinite(stated), stated, np.nanmedian(stated))
    seen = high_frequency(values, shape)
    if stated is not None:
        return shape * max(seen if np.isfinite(seen) else 1.0, 1.0)
    return shape * max(seen if np.isfinite(seen) else 1e-3 * float(np.nanstd(values)), lacking(channel, values))


def lacking(channel: str, values: Array) -> float:
    """The noise that a channel (n,) of a deployment lacks to be a measurement, m or rad; zero where it has some.

    A channel that often repeats its last value lacks the error of rounding to its quantum q, q / sqrt(12).
    """
    quiet, fine = (_QUIET_M, _FINE_M) if channel.endswith("_m") else (_QUIET_RAD, _FINE_RAD)
    rounded = quantum_of(values[np.isfinite(values)]) / float(np.sqrt(12.0))
    return 0.0 if high_frequency(values, np.ones(len(values))) > quiet else max(fine, rounded)


def lacking_in_force(time_s: Array, force_N: Array) -> float:
    """The noise that a loop's force (n,) lacks to be a measurement, N; zero where it has some."""
    largest = float(np.max(np.abs(force_N)))
    return 0.0 if noise_of(time_s, force_N) > _QUIET_FORCE * largest else _FINE_FORCE * largest


def high_frequency(values: Array, shape: Array) -> float:
    """Standard deviation of the sample-to-sample noise in units of `shape`, robust; NaN where too few samples stand in a row.

    The differences are taken first: a sigma that changes from frame to frame must not shake a large value.
    """
    steps = np.diff(values, n=_ORDER) / shape[_ORDER // 2 : len(shape) - _ORDER // 2]
    steps = steps[np.isfinite(steps)]
    if len(steps) < _FEW:
        return float("nan")
    return float(_PER_SIGMA * np.median(np.abs(steps - np.median(steps))) / _GAIN)


def whitened(gaps: Array, ways: Array) -> Array:
    """Gaps (n,) whose noise is white and of one but for errors along the columns of `ways` (n, k), each of one too: made white.

        (1 + A A')^-1/2 g,   so that its sum of squares is  min over c of |g - A c|^2 + |c|^2

    Along a column that is long the gaps count little; across all of them they stay as they are.
    """
    power, turn = np.linalg.eigh(ways.T @ ways)
    long = power > _SHORT
    along = turn[:, long] * np.sqrt((1.0 - 1.0 / np.sqrt(1.0 + power[long])) / power[long])
    return gaps - ways @ (along @ (along.T @ (ways.T @ gaps)))


def loop_run(run: Run, model: Model, data: LoopData) -> LoopRun:
    """A loop that is ready, its force as noisy as a fine load cell's at least."""
    sigma = max(data.force_sigma_N, lacking_in_force(data.time_s, data.force_N))
    return LoopRun(run, model, replace(data, force_sigma_N=sigma))
