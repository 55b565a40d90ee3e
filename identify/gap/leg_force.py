"""Whether a force is missing in every leg that goes with its elongation and has no name.

A ripple of the spool, a drive in the middle of the stroke: the gap that they leave is not slow enough for a test of slow against
fast parts, and it is not a force on the platform. A table along the elongation is as keen on them as such a test can be.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from identify.estimation.fit import Fit
from identify.estimation.problem import Problem
from identify.selection.gap_test import GAP_P
from identify.selection.null_hypothesis import chance_of_columns, gained_by
from measure.common.arrays import Array
from simulate.model.effect import LegEffect, parameter
from simulate.model.rig import stroke_of

PLACES = 24
_LARGER_PART = 0.5
_AS_WELL = 3.0  # times the median standard deviation


@dataclass(frozen=True)
class ForceAlongElongation(LegEffect):
    """A force in every leg at evenly spaced elongations, linear between, steady beyond."""

    name = "missing-force-along-elongation"
    force_N: tuple[float, ...] = parameter((0.0,) * PLACES, low=-1e3, high=1e3, typical=0.01, doc="at the places")
    first_m: float = parameter(0.0, low=-1e3, high=1e3, typical=1.0, doc="elongation at the first place")
    spacing_m: float = parameter(0.01, low=1e-9, high=1e3, typical=1.0, doc="from place to place")

    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """The force at this elongation, N."""
        place = min(max((u - p[24]) / p[25], 0.0), 22.999999)
        left = int(place)
        return p[left] + (place - left) * (p[left + 1] - p[left])


def chance_of_leg_force(fit: Fit) -> float:
    """How likely such a force gains as much as it does if what is left is noise."""
    return chance_of_columns(fit, _free_columns(fit))


def closed_by_leg_force(fit: Fit) -> float:
    """What such a force would take off the sum of squares, along straight lines, beyond what as many places take off white noise."""
    free = _free_columns(fit)
    return max(0.0, float(gained_by(free, fit.gaps[:, None])[0]) - free.shape[1])


@dataclass(frozen=True)
class LegForce:
    """What such a force would have to be: elongation_m, force_N, sigma_N (PLACES,) each, free of what the force law can say itself.

    share : of the gap's excess over noise that it closes, along straight lines.
    """

    elongation_m: Array
    force_N: Array
    sigma_N: Array
    share: float

    @property
    def sentence(self) -> str:
        """Where it is strongest to either side, among the places that are known as well as most."""
        known = np.flatnonzero(self.sigma_N <= _AS_WELL * np.median(self.sigma_N))
        ends = [known[np.argmax(self.force_N[known])], known[np.argmin(self.force_N[known])]]
        said = " and ".join(f"{self.force_N[i]:+.2g} N (sigma {self.sigma_N[i]:.1g}) at {1e3 * self.elongation_m[i]:.0f} mm" for i in ends)
        return f"A force in every leg that goes with its elongation would close {100 * self.share:.0f} % of it: {said}."


def leg_force(fit: Fit) -> LegForce | None:
    """The force that a fit misses in the legs, where it is beyond noise and closes the larger part of the gap."""
    free = _free_columns(fit)
    closed, excess = float(gained_by(free, fit.gaps[:, None])[0]), fit.cost - fit.problem.measured
    if closed < _LARGER_PART * excess or excess <= 0.0 or chance_of_columns(fit, free) > GAP_P:
        return None
    spread = np.linalg.pinv(free.T @ free, rcond=1e-8, hermitian=True)
    typical = ForceAlongElongation.typical()[:PLACES]
    first, last = _reach(fit.problem)
    sigma = typical * np.sqrt(np.diag(spread) * fit.variance_inflation)
    return LegForce(np.linspace(first, last, PLACES), -typical * (spread @ (free.T @ fit.gaps)), sigma, min(1.0, closed / excess))


def _free_columns(fit: Fit) -> Array:
    """What the table can do to the gaps, (m, PLACES), freed of what the parameters can do themselves."""
    first, last = _reach(fit.problem)
    table = ForceAlongElongation(first_m=first, spacing_m=(last - first) / (PLACES - 1))
    problem = fit.problem.with_another(table)
    old = len(fit.q)
    start = np.concatenate([fit.q, np.zeros(len(table.flat()))])
    return fit.free_of_parameters(problem.jacobian(start, range(old, old + PLACES), fit.gaps)[1])


def _reach(problem: Problem) -> tuple[float, float]:
    """Smallest and largest elongation that a leg has in any run, m."""
    ends = [float(end) for loop in problem.loops for end in (loop.data.elongation_m.min(), loop.data.elongation_m.max())]
    for film in problem.films:
        ends += [0.0, float(np.max(stroke_of(film.model)))]
    return min(ends), max(ends)
