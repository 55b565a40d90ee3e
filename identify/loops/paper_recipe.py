"""The paper's own recipe: lines through the straight parts of the loops, beta from their area.

It is shown beside the joint fit, because colleagues know it, and because where it fails says something about the loops.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from identify.criteria import STRAIGHT_FROM
from identify.loops.loop_data import LoopData, area, free_start
from measure.common.arrays import Array


@dataclass(frozen=True)
class Recipe:
    """Lines and beta by the paper's recipe; beta is NaN, and `statement` says why, where no beta gives the area.

    straight : slope and level-at-zero of the straight parts as they were fitted, lower then upper, before the shift.
    """

    lines: Array
    straight: Array
    statement: str

    @property
    def beta_per_m(self) -> float:
        """1/m, or NaN."""
        return float(self.lines[4])


def paper_recipe(loops: Sequence[LoopData], beta_bounds: tuple[float, float]) -> Recipe | None:
    """The recipe on all loops at once; None where no stroke has a straight part on both sides.

    The straight part of a branch is h_s - s a_s / beta, so the lines are shifted back by s a_s / beta, and beta is the
    one with which the modelled loops enclose the measured area, in sum. Source: Aridon 2009, section 3.2. The area hardly
    depends on beta once a stroke is many times 1 / beta, so this beta is poorly determined; it is not used for anything.
    """
    straight = straight_lines(loops)
    measured = sum(area(d, d.force_N) for d in loops)
    if straight is None or not any(d.cycles.spans for d in loops):
        return None

    def excess(log_beta: float) -> float:
        lines = shifted(straight, float(np.exp(log_beta)))
        return sum(area(d, free_start(lines, d)[1]) for d in loops) - measured

    low, high = (float(np.log(b)) for b in beta_bounds)
    at_low, at_high = excess(low), excess(high)
    if at_low * at_high > 0.0:
        more = "more" if at_high < 0.0 else "less"
        reached = measured + (at_high if at_high < 0.0 else at_low)
        statement = f"no beta gives the measured area: the loops enclose {measured:.4g} J, {more} than the {reached:.4g} J of these lines"
        return Recipe(np.append(shifted(straight, np.inf)[:4], np.nan), straight, statement)
    beta = float(np.exp(brentq(excess, low, high, xtol=1e-6)))  # type: ignore[arg-type]
    return Recipe(shifted(straight, beta), straight, f"equal areas at beta = {beta:.4g} 1/m")


def shifted(straight: Array, beta: float) -> Array:
    """a_l, b_l, a_u, b_u, beta from the straight parts: h_s = straight part + s a_s / beta."""
    a_l, b_l, a_u, b_u = straight
    return np.array([a_l, b_l + a_l / beta, a_u, b_u - a_u / beta, beta])


def straight_lines(loops: Sequence[LoopData]) -> Array | None:
    """Slope and level of the straight parts, lower then upper, by least squares; None if one of them was not seen."""
    found = []
    for direction in (1.0, -1.0):
        parts = [part for d in loops for part in _straight_parts(d, direction)]
        if sum(len(u) for u, _ in parts) < 4:
            return None
        u, force = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        slope, level = np.polyfit(u - u.mean(), force, 1)
        found += [slope, level - slope * u.mean()]
    return np.array(found)


def _straight_parts(data: LoopData, direction: float) -> Iterator[tuple[Array, Array]]:
    u = data.elongation_m
    for a, b in pairwise(data.cycles.reversals):
        if (u[b] - u[a]) * direction <= 0.0:
            continue
        travelled = np.abs(u[a : b + 1] - u[a]) / abs(u[b] - u[a])
        here = (travelled > STRAIGHT_FROM) & (travelled < 0.98)
        yield u[a : b + 1][here], data.force_N[a : b + 1][here]
