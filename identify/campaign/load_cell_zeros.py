"""Loops whose load cell was set to zero for each anew: whether it was, and what the zeros are."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from identify.criteria import ZEROS_DIFFER
from identify.estimation.least_squares import solve
from identify.estimation.problem import Fit
from measure.common.arrays import Array

Tare = Literal["auto", "common", "each"]


def zeros_differ(fit: Fit) -> bool:
    """Whether the zeros of the loops scatter by more than three standard errors once each may have its own, or their drifts do."""
    if fit.problem.own_zeros or len(fit.problem.loops) < 2:
        return False
    problem = replace(fit.problem, own_zeros=True)
    loops, first = len(problem.loops), fit.problem.first_effect
    freed = solve(problem, np.insert(fit.q, np.full(2 * loops, first), 0.0), robust=fit.robust)
    return any(_scatter(freed, slice(start, start + loops)) > ZEROS_DIFFER for start in (first, first + loops))


def _scatter(fit: Fit, own: slice) -> float:
    """Root mean square of parameters about their mean, in standard errors."""
    count = own.stop - own.start
    centred = (np.eye(count) - 1.0 / count) * fit.problem.scales[own]
    variances = np.diag(centred @ fit.covariance[own, own] @ centred.T)
    return float(np.sqrt(np.mean((centred @ fit.q[own]) ** 2 / variances)))


def zeros_of(fit: Fit) -> dict[str, float]:
    """The zero of each loop in the middle of its record, N, by the name of its run; none where all have the same."""
    return _by_run(fit, fit.problem.zeros_at(fit.q)[0])


def drifts_of(fit: Fit) -> dict[str, float]:
    """By how much the zero of each loop drifted, N/s, by the name of its run; none where all have the same."""
    return _by_run(fit, fit.problem.zeros_at(fit.q)[1])


def _by_run(fit: Fit, values: Array) -> dict[str, float]:
    return {loop.run.name: float(value) for loop, value in zip(fit.problem.loops, values, strict=True)} if fit.problem.own_zeros else {}
