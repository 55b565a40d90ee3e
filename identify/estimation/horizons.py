"""Films fitted up to their stops first, and then ever further: behind the stops errors grow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identify.criteria import ROUGHLY
from identify.estimation.least_squares import solve, to_the_end
from identify.estimation.problem import Fit, Problem
from measure.common.arrays import Array

_EARLY_SPREAD = 30.0  # typical sizes
_FIRST_LEG, _NEXT_LEG = 12, 6


def solve_from_afar(problem: Problem, start: Array | None = None, *, free: Sequence[int] | None = None, most_steps: int = 20) -> Fit:
    """Fit the films up to the stops first, then ever further, and whole at last.

    Behind the stops errors grow, so a start that is far off can lead into a wrong local minimum. What does not show yet is held
    near its start meanwhile.
    """
    q = start
    for i, horizon in enumerate(horizons(problem)):
        shorter = replace(problem.until(horizon), effect_spread=_EARLY_SPREAD)
        q = solve(shorter, q, free=free, most_steps=_FIRST_LEG if i == 0 else _NEXT_LEG, enough=ROUGHLY).q
    return to_the_end(solve(problem, q, free=free, most_steps=most_steps), free)


def horizons(problem: Problem) -> list[float]:
    """Times up to which the films are fitted one after the other: the first stop, and on in thirds of what is behind it, s."""
    stop = first_stop_s(problem)
    if not problem.films or stop >= min(problem.until_s, _last_frame_s(problem)):
        return []
    return [stop + part * (_last_frame_s(problem) - stop) for part in (0.0, 1 / 3, 2 / 3)]


def before_the_stops(problem: Problem) -> Problem:
    """The films cut where the first of them reaches the stops; the same problem where none does."""
    found = horizons(problem)
    return problem.until(found[0]) if found else problem


def _last_frame_s(problem: Problem) -> float:
    return max(float(film.time_s[-1]) for film in problem.films)


def first_stop_s(problem: Problem) -> float:
    """When the first film reaches 98 % of the deployed height, s; infinite where no elevation was seen or it never did."""
    times = [np.inf]
    for film in problem.films:
        if "z_m" not in film.channels or film.model.geometry is None:
            continue
        geometry = film.model.geometry
        height = geometry.stowed_height_m + 0.98 * (geometry.deployed_height_m - geometry.stowed_height_m)
        up = np.flatnonzero(film.values[film.channels.index("z_m")] >= height)
        times += [float(film.time_s[up[0]])] if len(up) else []
    return min(times)
