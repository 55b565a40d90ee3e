"""Dwells: the drive stands still at its turning points, and leaves them as sharply as it came.

A polynomial through a corner swings to and fro beside it, and the force law takes that for a reversal. In a dwell nothing moves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from identify.criteria import BENT_DWELL, STANDS_STILL
from identify.loops.corners import SIDE, Corner
from identify.loops.differentiation import Motion
from measure.common.arrays import Array

_LEAST = 2 * SIDE  # samples
_ALIKE = 0.5  # the slower of two speeds beside a corner is more than this part of the faster


def dwells_of(measured_m: Array, noise_m: float) -> list[tuple[int, int]]:
    """Stretches (first, last + 1) inside a record in which the elongation stays within its noise of one level.

    A stretch counts where it is level to within its noise, and where the motion beside it ends and begins at its full speed. The crest
    of a slow wave is bent, and its speed grows.
    """
    if len(measured_m) < 3 * _LEAST:
        return []
    near = sliding_window_view(measured_m, _LEAST)
    calm = np.concatenate([[False], near.max(axis=1) - near.min(axis=1) < 2.0 * STANDS_STILL * noise_m, [False]])
    edges = np.flatnonzero(np.diff(calm.astype(int)))
    stretches = [(int(a), int(b) - 1 + _LEAST) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    trimmed = [_trimmed(measured_m, a, b, STANDS_STILL * noise_m) for a, b in stretches]
    return [(a, b) for a, b in trimmed if b - a >= _LEAST and _abrupt(measured_m, a, b) and not _bent(measured_m[a:b], noise_m)]


def _trimmed(u: Array, first: int, last: int, band_m: float) -> tuple[int, int]:
    """The stretch without the moving samples at its ends."""
    inside = np.flatnonzero(np.abs(u[first:last] - np.median(u[first:last])) <= band_m)
    return first + int(inside[0]), first + int(inside[-1]) + 1


def _abrupt(u: Array, first: int, last: int) -> bool:
    """Whether the motion ends and begins at its full speed, as the ways over the next samples and over those behind say."""
    if first < _LEAST or last > len(u) - _LEAST:
        return False
    ahead = abs(u[last + SIDE - 1] - u[last - 1]), abs(u[last + 2 * SIDE - 1] - u[last + SIDE - 1])
    behind = abs(u[first] - u[first - SIDE]), abs(u[first - SIDE] - u[first - 2 * SIDE])
    return all(min(ways) > _ALIKE * max(ways) for ways in (ahead, behind))


def _bent(u: Array, noise_m: float) -> bool:
    """Whether a parabola says a stretch far better than its mean."""
    x = np.linspace(-1.0, 1.0, len(u))
    left = u - np.polyval(np.polyfit(x, u, 2), x)
    return float(np.sum((u - u.mean()) ** 2) - left @ left) > BENT_DWELL * noise_m**2


def with_dwells(time_s: Array, measured_m: Array, smooth: Motion, dwells: list[tuple[int, int]]) -> tuple[Motion, list[Corner]]:
    """The motion at rest in each dwell, straight beside it, and the corners between; lines are fitted to samples outside only."""
    columns = np.stack([smooth.elongation_m, smooth.speed_m_per_s, smooth.acceleration_m_per_s2])
    corners: list[Corner] = []
    for first, last in dwells:
        level = float(np.mean(measured_m[first + 1 : last - 1]))
        columns[:, first:last] = [[level], [0.0], [0.0]]
        corners += _joined(time_s, measured_m, columns, (first - SIDE, first, first + SIDE), level, smooth.noise_m)
        corners += _joined(time_s, measured_m, columns, (last + SIDE - 1, last - 1, last - SIDE - 1), level, smooth.noise_m)
    return replace(smooth, elongation_m=columns[0], speed_m_per_s=columns[1], acceleration_m_per_s2=columns[2]), corners


def _joined(time_s: Array, u: Array, columns: Array, ends: tuple[int, int, int], level: float, noise_m: float) -> list[Corner]:
    """The corner of a line beside a dwell with its level; the motion near it follows one or the other.

    ends : the outermost sample of the line, the first one of the dwell, and how far into the dwell the line may reach.
    """
    way = 1 if ends[2] > ends[0] else -1
    outside, near = np.arange(ends[0], ends[1], way), np.arange(ends[0], ends[2], way)
    slope, at = np.polyfit(time_s[outside] - time_s[ends[1]], u[outside], 1)
    instant = time_s[ends[1]] + (level - at) / slope if slope else float(time_s[ends[1]])
    if not min(time_s[near]) < instant < max(time_s[near]):
        return []
    moving = (instant - time_s[near]) * way > 0.0
    line = at + slope * (time_s[near] - time_s[ends[1]])
    columns[:, near] = np.where(moving, [line, np.full(len(near), slope), np.zeros(len(near))], [[level], [0.0], [0.0]])
    return [Corner(float(instant), level, noise_m)]
