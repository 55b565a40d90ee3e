"""Rows of a picture that are read one after the other: every mark brought to the instant at which the middle row is read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from measure.correlation.marks import Marks

Array = NDArray[np.float64]
_POINTS = 4
"""Positions of a mark, in time, through which a cubic is laid."""


def at_one_instant(marks: Marks, readout_s: float, height: int) -> Marks:
    """The marks where they were when the middle row of each picture was read.

        tau = t + (y / (height - 1) - 1/2) readout,    x(t) = sum_j w_j(t) x(tau_j)

    A mark is seen at the instant tau of its own row. Between its positions in four frames, a cubic gives the one at t; the
    covariances follow with the squares of the weights w_j of Lagrange's polynomials. Where fewer than four frames stand
    together, the polynomial is of a lower degree; a single one moves by no known speed and is kept.

    Parameters
    ----------
    marks : Marks
    readout_s : float
        Time from the first row to the last one, s.
    height : int
        Rows of the picture.

    Returns
    -------
    Marks
    """
    if not readout_s:
        return marks
    x, y, covariance = marks.x_px.copy(), marks.y_px.copy(), marks.covariance_px2.copy()
    seen_s = marks.time_s[:, None] + (marks.y_px / (height - 1) - 0.5) * readout_s
    for i in range(len(marks.names)):
        for run in _runs(marks.observed[:, i]):
            first, weights = _weights(seen_s[run, i], marks.time_s[run])
            near = run[first[:, None] + np.arange(weights.shape[1])]
            x[run, i] = (weights * marks.x_px[near, i]).sum(axis=1)
            y[run, i] = (weights * marks.y_px[near, i]).sum(axis=1)
            covariance[run, i] = np.einsum("tk,tkab->tab", weights**2, marks.covariance_px2[near, i])
    return replace(marks, x_px=x, y_px=y, covariance_px2=covariance)


def _runs(observed: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Frames without a gap between them."""
    frames = np.flatnonzero(observed)
    return np.split(frames, np.flatnonzero(np.diff(frames) > 1) + 1) if len(frames) else []


def _weights(seen_s: Array, wanted_s: Array) -> tuple[NDArray[np.intp], Array]:
    """Lagrange's weights at each wanted instant: place of the first of the positions, and a weight for each, (frames, positions)."""
    points = min(_POINTS, len(seen_s))
    first = np.clip(np.searchsorted(seen_s, wanted_s) - points // 2, 0, len(seen_s) - points)
    at = seen_s[first[:, None] + np.arange(points)]
    weights = np.ones((len(wanted_s), points))
    for j in range(points):
        for k in range(points):
            if k != j:
                weights[:, j] *= (wanted_s - at[:, k]) / (at[:, j] - at[:, k])
    return first, weights
