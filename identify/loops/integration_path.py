"""The motion along which the force law is integrated: the samples and, between them, the turning points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from identify.loops.corners import Corner
from identify.loops.differentiation import Motion, one_way
from identify.loops.loop_data import Path
from measure.common.arrays import Array


def path_of(time_s: Array, smooth: Motion, turns: tuple[int, ...], corners: Sequence[Corner]) -> tuple[Path, NDArray[np.intp]]:
    """The samples with each turning point put in between two of them: a corner, or the vertex of the local parabola.

    Parameters
    ----------
    turns : indices of the reversals. corners : the sharp ones, as `corners.sharpened` found them.

    Returns
    -------
    The path, (m,) each, and (n,) the index of each sample in it.
    """
    columns = np.stack([time_s, one_way(smooth.elongation_m, turns), smooth.speed_m_per_s, smooth.acceleration_m_per_s2])
    instants = np.array([corner.time_s for corner in corners])
    known = np.isin(instants, time_s)
    sharp = [(corner.time_s, corner.elongation_m, 0.0, 0.0) for corner, there in zip(corners, known, strict=True) if not there]
    vertices = sharp + [vertex for k in _without_corner(time_s, turns, instants) if (vertex := _vertex(columns, k)) is not None]
    if vertices:
        columns = np.concatenate([columns, np.array(vertices).T], axis=1)
        columns = columns[:, np.argsort(columns[0], kind="stable")]
    at = np.searchsorted(columns[0], time_s)
    return Path(*(np.ascontiguousarray(row) for row in columns)), at


def _without_corner(time_s: Array, turns: tuple[int, ...], instants: Array) -> list[int]:
    """The turns with no corner within the samples before and behind them. instants : of the corners, increasing."""
    if not len(instants):
        return list(turns)
    at = np.array(turns, dtype=np.intp)
    ahead = np.searchsorted(instants, time_s[at])
    either_side = instants[np.clip([ahead - 1, ahead], 0, len(instants) - 1)]
    nearest = np.abs(either_side - time_s[at]).min(axis=0)
    reach = time_s[np.minimum(at + 1, len(time_s) - 1)] - time_s[np.maximum(at - 1, 0)]
    return [int(k) for k in at[nearest > reach]]


def _vertex(columns: Array, k: int) -> tuple[float, float, float, float] | None:
    t, u, v, a = (float(x) for x in columns[:, k])
    if a == 0.0 or not 0 < k < columns.shape[1] - 1:
        return None
    late = -v / a
    neighbour = columns[0, k + 1] if late > 0 else columns[0, k - 1]
    if not 1e-6 < late / (neighbour - t) < 1.0:
        return None
    return t + late, u + v * late / 2.0, 0.0, a
