"""Whether a force is missing in every leg that goes with its elongation and has no name.

A ripple of the spool, a drive in the middle of the stroke: the gap that they leave is not slow enough for a test of slow against
fast parts, and it is not a force on the platform. A table along the elongation is as keen on them as such a test can be.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from measure.tables import Array
from simulate.effect import LegEffect, parameter
from simulate.packing import leg_lengths

from .chance import chance_of_columns, gained_by
from .fit import Fit
from .problem import Problem

PLACES = 24


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
    """What such a force would take off the sum of squares, along straight lines."""
    return float(gained_by(_free_columns(fit), fit.gaps[:, None])[0])


def _free_columns(fit: Fit) -> Array:
    """What the table can do to the gaps, (m, PLACES), freed of what the knobs can do themselves."""
    first, last = _reach(fit.problem)
    table = ForceAlongElongation(first_m=first, spacing_m=(last - first) / (PLACES - 1))
    problem = fit.problem.with_effects((*fit.problem.effects, table))
    old = len(fit.q)
    start = np.concatenate([fit.q, np.zeros(len(table.flat()))])
    return fit.free_of_knobs(problem.jacobian(start, range(old, old + PLACES), fit.gaps)[1])


def _reach(problem: Problem) -> tuple[float, float]:
    """Smallest and largest elongation that a leg has in any run, m."""
    ends = [float(end) for loop in problem.loops for end in (loop.data.elongation_m.min(), loop.data.elongation_m.max())]
    for film in problem.films:
        ends += [0.0, float(np.max(_full_elongation(film.model)))]
    return min(ends), max(ends)


def _full_elongation(model: Any) -> Array:
    g = model.geometry
    base, joints = np.asarray(g.base_joints_m), np.asarray(g.platform_joints_m)
    return leg_lengths(base, joints, g.deployed_height_m) - leg_lengths(base, joints, g.stowed_height_m)
