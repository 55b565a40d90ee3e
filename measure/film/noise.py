"""Noise of a film's channels, and how much of it is kept from frame to frame: apart from a motion that is smooth.

Neighbouring frames often err alike: compression carries errors on, sub-pixel errors follow the place, hot air moves slowly.
Whoever takes such noise for white believes a track far too much.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from measure.tables.trajectory import Trajectory

Array = NDArray[np.float64]

_KEPT = np.array([-0.4, -0.2, 0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9])
"""Correlations from frame to frame that are tried."""

_JERK = 10.0 ** np.arange(-8.0, 8.1, 0.8)
"""Densities of the jerk that are tried, in variances of the noise per (time from frame to frame)^5."""

_FEWEST, _MOST = 40, 600
"""Frames from which a correlation is known to a fifth, and those that are used at most: a stretch around the fastest motion."""

_SEEN_SHARE = 0.8
"""Share of these frames that must have a pose."""

_FREEDOM = 4.0
"""Degrees of freedom of Student's distribution of the innovations: an impact at the stops must not pass for noise."""

_BLOCK = 60
"""Frames in a block; each has a density of the jerk of its own, because a stroke, an impact and a rest differ in it."""

_BEGIN = 8
"""Frames at the beginning of a block to which a parabola is laid, from which the filter starts, and whose innovations do not count."""

_AT_FIRST = 10.0
"""Standard deviation of what the filter starts from, in those of the noise: per step for the speed, per step^2 for the acceleration."""


@dataclass(frozen=True)
class FilmNoise:
    """Noise of one channel.

    Attributes
    ----------
    channel : str
    sigma : float
        Standard deviation of the noise, in the unit of the channel.
    lag1 : float
        Its correlation from one frame to the next.
    lag1_sigma : float
        Standard deviation of `lag1`.
    stated_sigma : float
        Median of the standard deviations in the table, for comparison.
    frames : int
        Frames that it was measured in.
    """

    channel: str
    sigma: float
    lag1: float
    lag1_sigma: float
    stated_sigma: float
    frames: int


def noise_table(trajectory: Trajectory | None) -> list[dict[str, Any]]:
    """The noise of all channels, as `--json` and the provenance hold it.

    Parameters
    ----------
    trajectory : Trajectory or None

    Returns
    -------
    list of dict
        The fields of `FilmNoise` for each channel; empty without a trajectory or with fewer than 40 frames.
    """
    return [] if trajectory is None else [asdict(one) for one in channel_noises(trajectory)]


def channel_noises(trajectory: Trajectory) -> list[FilmNoise]:
    """Measure the noise of every channel that was observed in 40 frames or more.

    A channel is taken to be a motion whose jerk is white, and noise of one memory:

        y_t = x_t + n_t,    d^3 x / dt^3 white with density q,    n_t = rho n_(t-1) + e_t

    rho, and in each block of 60 frames q and the variance of n, are those of largest likelihood, by a Kalman filter on a grid
    of rho and q. The innovations are of Student's distribution, so that an impact weighs little. Where the motion is too
    fast for its frames, nothing is known of the noise: NaN.

    Parameters
    ----------
    trajectory : Trajectory

    Returns
    -------
    list of FilmNoise
    """
    channels = [channel for channel, values in trajectory.channels.items() if np.isfinite(values).sum() >= _FEWEST]
    if not channels:
        return []
    all_rows = np.column_stack([trajectory.channels[channel] for channel in channels]).astype(np.float64)
    rows = _stretch(all_rows)
    seen = np.flatnonzero(np.isfinite(all_rows[rows]).all(axis=1))
    if len(seen) < max(_FEWEST, _SEEN_SHARE * len(all_rows[rows])):
        return []
    values = CubicSpline(seen, all_rows[rows][seen])(np.arange(seen[0], seen[-1] + 1))  # over the few frames without a pose
    units = np.array([_rough_noise(one) for one in values.T])
    count = max(1, len(values) // _BLOCK)
    blocks = (values[: len(values) // count * count] / units).reshape(count, -1, len(channels))
    likelihood, scale = _likelihoods(blocks)
    found = []
    for c, channel in enumerate(channels):
        factor, lag1, lag1_sigma = _highest(likelihood[:, c], scale[:, c])
        stated = float(np.nanmedian(trajectory.sigma[channel])) if channel in trajectory.sigma else np.nan
        found.append(FilmNoise(channel, factor * float(units[c]), lag1, lag1_sigma, stated, len(seen)))
    return found


def _stretch(values: Array) -> slice:
    """All frames, or as many as are used at most, around the fastest motion; values (frames, channels)."""
    if len(values) <= _MOST:
        return slice(0, len(values))
    steps = np.abs(np.diff(values, axis=0))
    fastest = int((steps / (np.nanmedian(steps, axis=0) + 1e-300)).sum(axis=1).argsort(kind="stable")[::-1][0])
    first = min(max(0, fastest - _MOST // 2), len(values) - _MOST)
    return slice(first, first + _MOST)


def _rough_noise(values: Array) -> float:
    """A first guess of the noise, by which a channel is made of order one."""
    guess = float(np.median(np.abs(np.diff(values, 3)))) / (0.6745 * np.sqrt(20.0))
    return max(guess, 1e-9 * float(np.ptp(values)), 1e-300)


def _highest(likelihood: Array, scale: Array) -> tuple[float, float, float]:
    """Standard deviation of the noise, its correlation from frame to frame, and that one's standard deviation.

    likelihood, scale : (blocks, kept, jerk). A block that likes the largest density of the jerk best says nothing of the noise.
    """
    tells = np.argmax(likelihood.max(axis=1), axis=1) < likelihood.shape[2] - 1
    along = likelihood[tells].max(axis=2).sum(axis=0)
    top = int(np.clip(along.argmax(), 1, len(_KEPT) - 2))
    around = slice(top - 1, top + 2)
    bend, slope, _ = np.polyfit(_KEPT[around] - _KEPT[top], along[around], 2)
    if not tells.any() or bend >= 0:
        return np.nan, np.nan, np.nan
    lag1 = float(np.clip(_KEPT[top] - slope / (2.0 * bend), _KEPT[0], _KEPT[-1]))
    best = likelihood[tells].argmax(axis=2)
    scales = np.median(np.take_along_axis(scale[tells], best[..., None], axis=2)[..., 0], axis=0)
    return float(np.interp(lag1, _KEPT, scales)), lag1, float(1.0 / np.sqrt(-2.0 * bend))


def _likelihoods(blocks: Array) -> tuple[Array, Array]:
    """Log likelihood and standard deviation of the noise, (blocks, channels, kept, jerk), all at once.

    blocks : (blocks, frames, channels), evenly spaced. What the filter knows of the state is the same for all of them.
    """
    count, frames, channels = blocks.shape
    values = blocks.transpose(1, 0, 2).reshape(frames, -1)
    kept, jerk = (grid.ravel() for grid in np.meshgrid(_KEPT, _JERK, indexing="ij"))
    begin = np.polynomial.polynomial.polyfit(np.arange(_BEGIN), values[:_BEGIN], 2)
    state = np.zeros((values.shape[1], len(kept), 4))
    state[..., :3] = (begin * np.array([1.0, 1.0, 2.0])[:, None]).T[:, None, :]
    spread = np.zeros((len(kept), 4, 4))
    spread[:, [0, 1, 2], [0, 1, 2]] = _AT_FIRST**2
    spread[:, 3, 3] = 1.0
    innovations, variances = [], []
    for t, value in enumerate(values):
        if t:
            state, spread = _predicted(state, spread, kept, jerk)
        innovation = value[:, None] - state[..., 0] - state[..., 3]
        seen = spread[:, 0] + spread[:, 3]
        variance = seen[:, 0] + seen[:, 3]
        gain = seen / variance[:, None]
        state = state + gain * innovation[..., None]
        spread = spread - gain[:, :, None] * seen[:, None, :]
        if t >= _BEGIN:
            innovations.append(innovation)
            variances.append(variance)
    found = _student(np.array(innovations), np.array(variances)[:, None, :])
    return tuple(one.reshape(count, channels, len(_KEPT), len(_JERK)) for one in found)  # type: ignore[return-value]


def _predicted(state: Array, spread: Array, kept: Array, jerk: Array) -> tuple[Array, Array]:
    """State and covariance one step on: three integrations of white jerk, and noise that keeps a part of itself."""
    move = np.zeros((len(kept), 4, 4))
    move[:, :3, :3] = [[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]
    move[:, 3, 3] = kept
    added = np.zeros_like(spread)
    added[:, :3, :3] = jerk[:, None, None] * np.array([[1 / 20, 1 / 8, 1 / 6], [1 / 8, 1 / 3, 1 / 2], [1 / 6, 1 / 2, 1.0]])
    added[:, 3, 3] = 1.0 - kept**2
    return np.einsum("gij,cgj->cgi", move, state), move @ spread @ move.transpose(0, 2, 1) + added


def _student(innovations: Array, variances: Array) -> tuple[Array, Array]:
    """Likelihood of innovations of Student's distribution, of one unknown scale, and that scale as of normal noise; (channels, grid) each.

    innovations : (frames, channels, grid). variances : (frames, 1, grid).
    """
    u2 = innovations**2 / variances
    scale2 = np.median(u2, axis=0) / 0.455 + 1e-300
    for _ in range(30):
        scale2 = np.mean((_FREEDOM + 1.0) * u2 / (_FREEDOM + u2 / scale2), axis=0) + 1e-300
    count = len(u2)
    likelihood = -0.5 * np.log(variances).sum(axis=0) - 0.5 * count * np.log(scale2)
    likelihood -= 0.5 * (_FREEDOM + 1.0) * np.log1p(u2 / (_FREEDOM * scale2)).sum(axis=0)
    return likelihood, np.sqrt(scale2) / _STUDENT_OF_NORMAL


def _scale_of_normal() -> float:
    """Scale of Student's distribution that fits normal noise of variance one best."""
    z = np.linspace(-8.0, 8.0, 1601)
    weight = np.exp(-0.5 * z * z)
    weight /= weight.sum()
    scale2 = 1.0
    for _ in range(60):
        scale2 = float(np.sum(weight * (_FREEDOM + 1.0) * z * z / (_FREEDOM + z * z / scale2)))
    return float(np.sqrt(scale2))


_STUDENT_OF_NORMAL = _scale_of_normal()
