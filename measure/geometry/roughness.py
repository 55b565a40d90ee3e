"""How much a pose scatters from frame to frame, beside its standard deviations: noise that the marks share cannot be seen in their misfit.

A platform moves smoothly. High differences of the pose remove the motion and keep the noise, and from some order on they
agree. What compression, pixels' steps along an edge or heated air add to all marks alike is found so, and no other way.
"""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ORDERS = range(3, 9)
"""Orders of the differences."""

_SMALLEST = 3
"""The orders that count are those with the smallest scatter, because what is left of the motion only adds to it."""

_FEWEST = 24
"""Differences from which their scatter is known to a fifth."""


def scatter(values: Array, sigma: Array) -> float:
    """Scatter of a course from frame to frame, over its standard deviations.

        s = mean over the three orders n where it is least of  median |D^n x| / (0.6745 sqrt(sum_i binom(n, i)^2 sigma_i^2))

    Parameters
    ----------
    values, sigma : (frames,) arrays
        At even spacing, NaN where there is none; a difference over a gap is left out.

    Returns
    -------
    float
        One for white noise of the stated standard deviations; less where part of these is common to all frames; NaN
        where the course is too short.
    """
    found = []
    for order in _ORDERS:
        taps = np.array([(-1) ** i * comb(order, i) for i in range(order + 1)], float)
        if len(values) < len(taps) + _FEWEST:
            break
        ratio = np.convolve(values, taps, "valid") / np.sqrt(np.convolve(sigma**2, taps**2, "valid"))
        ratio = np.abs(ratio[np.isfinite(ratio)])
        if len(ratio) >= _FEWEST:
            found.append(float(np.median(ratio)) / 0.6745)
    return float(np.mean(sorted(found)[:_SMALLEST])) if found else np.nan


def roughness(values: Array, sigma: Array) -> float:
    """Factor by which standard deviations fall short of a course's scatter from frame to frame.

        k^2 = max(1, s^2 + (s^2 - 1))

    What is not of the marks' own noise is in the reference image as much as in each frame, therefore twice.

    Parameters
    ----------
    values, sigma
        As in `scatter`.

    Returns
    -------
    float
        One where they do not fall short, or where the course is too short to tell.
    """
    s = scatter(values, sigma)
    return float(np.sqrt(max(1.0, 2.0 * s**2 - 1.0))) if np.isfinite(s) else 1.0
