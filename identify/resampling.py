"""Two other ways to the uncertainty of a fit: the profile of beta, and a bootstrap by whole cycles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from measure.tables import Array

from .actuator import ActuatorFit
from .loop_problem import LoopProblem, beta_bounds, minimise
from .loops import LoopData

_REACH = 4.0  # standard deviations of log beta, to each side
_POINTS = 13
_CHI2_95 = 3.841  # of one degree of freedom


@dataclass(frozen=True)
class Profile:
    """Rise of the misfit along beta, everything else fitted anew; in units in which 3.84 bounds the 95 % interval.

    beta_per_m, rise : (k,). interval : where the rise crosses 3.84; infinite or zero where it does not within what was tried.
    """

    beta_per_m: Array
    rise: Array
    interval: tuple[float, float]


def profile_of_beta(fit: ActuatorFit, loops: Sequence[LoopData]) -> Profile:
    """Hold beta at values around the best one and fit all the rest.

    The sum of squares is divided by the variance that makes its curvature at the best beta that of the fit's covariance, so that the
    profile knows of coloured noise too, and shows what the covariance cannot: an interval that is not symmetric.
    """
    shape, at = fit.layout, fit.layout.line_values
    value, error = float(fit.lines[4]), fit.estimates["beta_per_m"].stderr
    width = min(max(error / value, 1e-4), 1.5)
    logs = np.log(value) + width * np.linspace(-_REACH, _REACH, _POINTS)
    squares = []
    for log_beta in logs:
        held = LoopProblem(
            shape, tuple(loops), any(fit.tares_N), (float(np.exp(log_beta)) * (1 - 1e-9), float(np.exp(log_beta)) * (1 + 1e-9))
        )
        start = fit.theta.copy()
        start[at] = log_beta
        theta, _ = minimise(held, start, roughly=True)
        squares.append(sum(float(r @ r) for r in held.residuals(theta)))
    rise = np.array(squares) - sum(float(r @ r) for r in fit.residuals)
    x = (logs - np.log(value)) / width
    near = np.abs(x) <= 1.01
    unit = max(float(np.sum(rise[near] * x[near] ** 2) / np.sum(x[near] ** 4)), 1e-300)
    rise = np.maximum(rise / unit, 0.0)
    return Profile(np.exp(logs), rise, _crossings(logs, rise))


def _crossings(logs: Array, rise: Array) -> tuple[float, float]:
    middle = len(logs) // 2
    low = np.interp(_CHI2_95, rise[middle::-1], logs[middle::-1], right=-np.inf)
    high = np.interp(_CHI2_95, rise[middle:], logs[middle:], right=np.inf)
    return float(np.exp(low)), float(np.exp(high))


def bootstrap(
    fit: ActuatorFit, loops: Sequence[LoopData], repeats: int, seed: int, watch: Callable[[int], object] = lambda _: None
) -> dict[str, tuple[float, float]]:
    """95 % intervals of every parameter from fits to cycles drawn with replacement.

    In each loop the residual of whole cycles is drawn, with replacement, and put onto the modelled force of the cycles there; what
    is no part of a full cycle keeps its own. Samples are never drawn one by one: neighbours are not independent.

    Parameters
    ----------
    repeats : how many fits; 200 are enough for an interval.
    watch : told after every fit how many have been made.
    """
    rng = np.random.default_rng(seed)
    bounds = beta_bounds(loops)
    drawn = []
    for made in range(repeats):
        again = tuple(_redrawn(data, left, rng) for data, left in zip(loops, fit.residuals, strict=True))
        theta, _ = minimise(LoopProblem(fit.layout, again, any(fit.tares_N), bounds), fit.theta)
        drawn.append(fit.layout.values(theta))
        watch(made + 1)
    low, high = np.quantile(np.array(drawn), [0.025, 0.975], axis=0)
    return {name: (float(a), float(b)) for name, a, b in zip(fit.names, low, high, strict=True)}


def _redrawn(data: LoopData, left: Array, rng: np.random.Generator) -> LoopData:
    """The loop with the residuals of its full cycles exchanged among them."""
    residual = np.zeros(len(data.force_N))
    residual[data.used] = left
    new = residual.copy()
    spans = [(a, b - 1) for a, b in data.cycles.spans]
    for (a, b), which in zip(spans, rng.integers(0, max(len(spans), 1), len(spans)), strict=True):
        c, d = spans[which]
        new[a:b] = np.interp(np.linspace(0.0, 1.0, b - a), np.linspace(0.0, 1.0, d - c), residual[c:d])
    return replace(data, force_N=data.force_N - residual + new)
