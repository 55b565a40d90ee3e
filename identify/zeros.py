"""Loops whose load cell was set to zero for each anew: whether it was, and what the zeros are."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from .fit import Fit, solve

Tare = Literal["auto", "common", "each"]
_DIFFERENT = 3.0  # standard errors, root mean square


def zeros_differ(fit: Fit) -> bool:
    """Whether the loops' force levels scatter by more than three standard errors once each may have its own."""
    if fit.problem.own_zeros or len(fit.problem.loops) < 2:
        return False
    problem = replace(fit.problem, own_zeros=True)
    loops = len(problem.loops)
    start = np.insert(fit.q, np.full(loops, fit.problem.first_effect), 0.0)
    freed = solve(problem, start)
    own = slice(problem.first_zero, problem.first_effect)
    centred = (np.eye(loops) - 1.0 / loops) * problem.scales[own]
    variances = np.diag(centred @ freed.covariance[own, own] @ centred.T)
    return bool(np.mean((centred @ freed.q[own]) ** 2 / variances) > _DIFFERENT**2)


def zeros_of(fit: Fit) -> dict[str, float]:
    """The zero of each loop, N, by the name of its run; none where all have the same."""
    if not fit.problem.own_zeros:
        return {}
    return {loop.run.name: float(zero) for loop, zero in zip(fit.problem.loops, fit.problem.zeros_at(fit.q), strict=True)}
