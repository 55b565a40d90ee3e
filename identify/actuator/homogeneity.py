"""Whether loops agree before they are averaged: what each loop alone would want, parameter by parameter, against the noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import chi2

from identify.actuator.actuator_fit import Disagreement
from identify.actuator.rounding import rounded_only
from identify.criteria import DISAGREE
from identify.estimation.covariance import inverse_of, scaled, scatter
from identify.estimation.problem import Fit
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array

_KINDS = ("beta", "height", "slope")
_KNOWN = 0.05  # share of a loop's own signature that the common parameters cannot imitate


def disagreements(fit: Fit) -> tuple[Disagreement, ...]:
    """The quantities in which loops differ by more than their noise, the surest first.

    To the parameters of the fit one is added for each loop but one, by which this loop differs, and its score is tested with the
    covariance that knows the noise's spectrum. What is common to all is freed of first, so that a loop that cannot tell a quantity says
    nothing about it.
    """
    if len(fit.problem.loops) < 2 or fit.problem.rate.order or rounded_only(fit):
        return ()
    found = [_of(fit, what) for what in _KINDS]
    return tuple(sorted((one for one in found if one is not None and one.p_value < DISAGREE), key=lambda one: one.p_value))


def _of(fit: Fit, what: str) -> Disagreement | None:
    signature = _signature(fit, what)
    own = np.zeros((len(fit.gaps), len(fit.problem.loops)))
    for k, block in enumerate(fit.problem.blocks):
        own[block.rows, k] = signature[block.rows]
    common, _ = scaled(fit.jacobian[:, fit.clear_of_bounds])
    free = own - common @ (inverse_of(common.T @ common) @ (common.T @ own))
    told = np.linalg.norm(free, axis=0) > _KNOWN * np.linalg.norm(own, axis=0)
    if np.count_nonzero(told) < 2:
        return None
    table, size = scaled(free)
    middle = sum(scatter(table[block.rows], fit.gaps[block.rows]) for block in fit.problem.blocks)
    inverse = np.linalg.pinv(table.T @ table, rcond=1e-8, hermitian=True)
    covariance = inverse @ middle @ inverse
    offset = -inverse @ (table.T @ fit.gaps)
    rank = np.linalg.matrix_rank(table.T @ table, tol=1e-8 * len(size), hermitian=True)
    rise = float(offset @ np.linalg.pinv(covariance, rcond=1e-8, hermitian=True) @ offset)
    values = _value(fit, what, offset / size)
    errors = _slope(fit, what) * np.sqrt(np.maximum(np.diag(covariance), 0.0)) / size
    fall = float(fit.gaps @ fit.gaps - np.sum((fit.gaps + table @ offset) ** 2))
    return Disagreement(what, np.where(told, values, np.nan), errors, float(chi2.sf(rise, max(int(rank), 1))), fall)


def _signature(fit: Fit, what: str) -> Array:
    """What a quantity does to the gaps, (m,), a unit of its parameter's scale each."""
    problem = fit.problem
    a_l, b_l, a_u, b_u, beta = (fit.jacobian[:, k] for k in range(5))
    if what == "beta":
        return beta
    if what == "height":
        return b_u / problem.scales[3] - b_l / problem.scales[1]
    turn = _centre([run.data for run in problem.loops])
    return (a_l / problem.scales[0] + a_u / problem.scales[2]) - turn * (b_l / problem.scales[1] + b_u / problem.scales[3])


def _value(fit: Fit, what: str, offset: Array) -> Array:
    """The quantity as each loop wants it."""
    a_l, b_l, a_u, b_u, beta = fit.problem.lines_at(fit.q)
    if what == "beta":
        return beta * np.exp(np.clip(_slope(fit, what) * offset / beta, -5.0, 5.0))
    turn = _centre([run.data for run in fit.problem.loops])
    return (a_u - a_l) * turn + b_u - b_l + 2.0 * offset if what == "height" else (a_l + a_u) / 2.0 + offset


def _slope(fit: Fit, what: str) -> float:
    if what == "beta":
        return float(fit.problem.slopes_at(fit.q)[4])
    return 2.0 if what == "height" else 1.0


def _centre(loops: Sequence[LoopData]) -> float:
    everywhere = np.concatenate([data.elongation_m[data.used] for data in loops])
    return float((everywhere.min() + everywhere.max()) / 2.0)
