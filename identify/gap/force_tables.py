"""Tables of nothing over what runs pass through: the places at which a force without a name is estimated."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from identify.campaign.prepared import Film
from identify.estimation.problem import Problem
from identify.gap.leg_force import ForceAlongElongation, LegTable
from identify.gap.platform_force import KNOTS, MOVES, Along, ForceAlongHeight, ForceAlongTime, ForceTable
from simulate.model.rig import stroke_of


def leg_table_over(problem: Problem, kind: type[LegTable]) -> LegTable:
    """A table of nothing over what the legs pass through in any run."""
    if kind is ForceAlongElongation:
        ends = [float(end) for loop in problem.loops for end in (loop.data.elongation_m.min(), loop.data.elongation_m.max())]
        for film in problem.films:
            ends += [0.0, float(np.max(stroke_of(film.model)))]
        return kind.over(min(ends), max(ends))
    fastest = [float(np.max(np.abs(loop.data.speed_m_per_s))) for loop in problem.loops]
    fastest += [_fastest_m_per_s(film) for film in problem.films if "z_m" in film.channels]
    top = max(fastest, default=1.0)
    return kind.over(-top, top)


def _fastest_m_per_s(film: Any) -> float:
    """Largest speed of the elevation over a twentieth of a film; a leg is not faster than the platform."""
    z = film.values[film.channels.index("z_m")]
    good = np.isfinite(z)
    time, z = film.time_s[good], z[good]
    apart = max(len(z) // 20, 1)
    return float(np.max(np.abs(z[apart:] - z[:-apart]) / (time[apart:] - time[:-apart]), initial=1e-3))


def table_over(problem: Problem, along: Along) -> ForceTable:
    """A table of nothing over what the films of a problem pass through."""
    if along is ForceAlongTime:
        return along.over(0.0, max(float(film.time_s[-1]) - film.expected_s for film in problem.films))
    heights = [film.model.geometry for film in problem.films if film.model.geometry is not None]
    low, high = min(g.stowed_height_m for g in heights), max(g.deployed_height_m for g in heights)
    if along is ForceAlongHeight:
        return along.over(low, high)
    return along.over(0.0, max([_fastest(film) for film in problem.films if "z_m" in film.channels], default=4.0 * (high - low)))


def _fastest(film: Film) -> float:
    """Largest upward speed over a twentieth of the film, m/s."""
    z = film.values[film.channels.index("z_m")]
    good = np.isfinite(z)
    time, z = film.time_s[good], z[good]
    apart = max(len(z) // 20, 1)
    return float(np.max((z[apart:] - z[:-apart]) / (time[apart:] - time[:-apart]), initial=1e-3))


def seen_places(problem: Problem) -> NDArray[np.intp]:
    """Of a table's parameters those of the axes along which films tell the motion.

    A moment moves the platform sideways as a lateral force does; without its rotation the two would only stand against each other.
    """
    seen = {channel for film in problem.films for channel in film.channels}
    axes = np.array([channel in seen for channel in MOVES])
    return np.flatnonzero(np.repeat(axes, KNOTS))
