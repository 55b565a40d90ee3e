"""Films fitted up to their stops first, and then ever further: behind the stops errors grow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from identify.campaign.prepared import Film
from identify.criteria import ROUGHLY
from identify.estimation.least_squares import off_the_mirror, solve, to_the_end
from identify.estimation.problem import Fit, Problem
from measure.common.arrays import Array

_EARLY_SPREAD = 30.0  # typical sizes
_FIRST_LEG, _NEXT_LEG = 12, 6
_UP = 0.98  # of the way to the deployed height
_SPANS = 20  # of a film, over which its rise is a mean
_SPIKES = 5  # frames, of which less than half may be spikes


def solve_from_afar(problem: Problem, start: Array | None = None, *, free: Sequence[int] | None = None, most_steps: int = 20) -> Fit:
    """Fit the films up to the stops first, then ever further, and whole at last.

    Behind the stops errors grow, so a start that is far off can lead into a wrong local minimum. What does not show yet is held
    near its start meanwhile.
    """
    q = start
    for i, horizon in enumerate(horizons(problem)):
        shorter = replace(problem.until(horizon), effect_spread=_EARLY_SPREAD)
        q = solve(shorter, q, free=free, most_steps=_FIRST_LEG if i == 0 else _NEXT_LEG, enough=ROUGHLY).q
    return off_the_mirror(to_the_end(solve(problem, q, free=free, most_steps=most_steps), free))


def horizons(problem: Problem) -> list[float]:
    """Times up to which the films are fitted one after the other: the first stop, and on in thirds of what is behind it, s."""
    stop = first_stop_s(problem)
    if not problem.films or stop >= min(problem.until_s, _last_frame_s(problem)):
        return []
    return [stop + part * (_last_frame_s(problem) - stop) for part in (0.0, 1 / 3, 2 / 3)]


def stretches(problem: Problem) -> list[tuple[float, float]]:
    """The same times and at last that of the whole films, each with the middle of what it adds, s."""
    ends = [*horizons(problem), problem.until_s]
    half = 0.5 * (ends[1] - ends[0]) if len(ends) > 1 else 0.0
    return [(end, before + half) for before, end in zip([ends[0], *ends], ends, strict=False)]


def before_the_stops(problem: Problem) -> Problem:
    """The films cut where the first of them reaches the stops; the same problem where none does."""
    found = horizons(problem)
    return problem.until(found[0]) if found else problem


def _last_frame_s(problem: Problem) -> float:
    return max(float(film.time_s[-1]) for film in problem.films)


def first_stop_s(problem: Problem) -> float:
    """When the first film reaches its stops, s; infinite where no elevation was seen or none ever does."""
    return min([np.inf, *(_stop_s(film) for film in problem.films if "z_m" in film.channels and film.model.geometry is not None)])


def _stop_s(film: Film) -> float:
    """When a film reaches 98 % of the deployed height, s.

    A platform that tilts meets the stops of single legs lower down: where it stays below, the time at which it rises fastest counts, if
    its rise falls to half of that later on.
    """
    geometry, channel = film.model.geometry, film.channels.index("z_m")
    assert geometry is not None
    seen = film.counts[channel]
    time, height = film.time_s[seen], median_filter(film.values[channel, seen], _SPIKES, mode="nearest")
    up = np.flatnonzero(height >= geometry.stowed_height_m + _UP * (geometry.deployed_height_m - geometry.stowed_height_m))
    if len(up):
        return float(time[up[0]])
    apart = max(1, len(time) // _SPANS)
    rise = (height[apart:] - height[:-apart]) / (time[apart:] - time[:-apart])
    fastest = int(np.argmax(rise)) if len(rise) else 0
    slows = len(rise) > 0 and bool(np.any(rise[fastest:] < 0.5 * rise[fastest]))
    return float(time[fastest + apart // 2]) if slows else np.inf
