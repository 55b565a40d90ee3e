"""How the misfit rises where beta is held at other values and all the rest fitted anew: what a covariance cannot show."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from identify.actuator.loop_problem import LoopProblem, minimise
from measure.common.arrays import Array

_REACH = 4.0  # standard deviations of log beta, to each side
_POINTS = 13
_CHI2_95 = 3.841  # of one degree of freedom
_WIDEST = 1.5  # a standard deviation of log beta for which the misfit is looked at
_SURE, _UNSURE = 0.15, 1.0  # standard deviations of log beta, between which its misfit may be no parabola
_FAR = 3.0  # of log beta, a factor of twenty: three standard deviations of the largest that counts as known
_THREE_SIGMA = 9.0


@dataclass(frozen=True)
class Profile:
    """Rise of the misfit along beta, everything else fitted anew; in units in which 3.84 bounds the 95 % interval.

    beta_per_m, rise : (k,). interval : where the rise crosses 3.84; infinite or zero where it does not within what was tried.
    """

    beta_per_m: Array
    rise: Array
    interval: tuple[float, float]


def profile_of_beta(problem: LoopProblem, theta: Array, error: float) -> Profile:
    """Hold beta at values around the best one and fit all the rest.

    The sum of squares is divided by the variance that makes its curvature at the best beta that of the fit's covariance, so that the
    profile knows of coloured noise too, and shows what the covariance cannot: an interval that is not symmetric.

    Parameters
    ----------
    theta : (p,) the vector at the best fit. error : one standard deviation of log beta by the covariance.
    """
    width, best = min(max(error, 1e-4), _WIDEST), float(theta[problem.shape.line_values])
    x = np.linspace(-_REACH, _REACH, _POINTS)
    rise = _rises(problem, theta, best + width * x)
    near = np.abs(x) <= 1.01
    unit = max(float(np.sum(rise[near] * x[near] ** 2) / np.sum(x[near] ** 4)), 1e-300)
    rise = np.maximum(rise / unit, 0.0)
    return Profile(np.exp(best + width * x), rise, _crossings(best + width * x, rise))


def is_open(problem: LoopProblem, theta: Array, error: float) -> bool:
    """Whether a beta twenty times larger or smaller would fit these loops nearly as well, within three standard deviations.

    Not asked where the covariance knows beta to 15 %: there a parabola is near enough.

    Parameters
    ----------
    theta : (p,) the vector at the best fit. error : one standard deviation of log beta by the covariance.
    """
    if not _SURE < error < _UNSURE:
        return error >= _UNSURE
    best = float(theta[problem.shape.line_values])
    rise = _rises(problem, theta, best + np.array([-error, error, -_FAR, _FAR]))
    return bool(np.min(rise[2:]) < _THREE_SIGMA * np.mean(rise[:2]))


def _rises(problem: LoopProblem, theta: Array, logs: Array) -> Array:
    """Rise of the sum of squares over that of the best fit with log beta held at each of these values."""
    best = sum(float(r @ r) for r in problem.residuals(theta))
    squares = []
    for log_beta in logs:
        held = replace(problem, beta=(float(np.exp(log_beta)) * (1 - 1e-9), float(np.exp(log_beta)) * (1 + 1e-9)))
        start = theta.copy()
        start[problem.shape.line_values] = log_beta
        found, _ = minimise(held, start, roughly=True)
        squares.append(sum(float(r @ r) for r in held.residuals(found)))
    return np.array(squares) - best


def _crossings(logs: Array, rise: Array) -> tuple[float, float]:
    middle = len(logs) // 2
    low = np.interp(_CHI2_95, rise[middle::-1], logs[middle::-1], right=-np.inf)
    high = np.interp(_CHI2_95, rise[middle:], logs[middle:], right=np.inf)
    return float(np.exp(low)), float(np.exp(high))
