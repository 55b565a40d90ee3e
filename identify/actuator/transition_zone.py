"""The force level against the length that is unrolled: where the strip's transition zone is complete (Aridon 2009, section 3.2).

The zone between the flat coil and the curved strip needs length to form; until it has, the leg pushes less. In loops it shows
as a level, the mean of both branches, that leaves the straight line of longer elongations.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from identify.loops.loop_data import LoopData, inertia
from measure.common.arrays import Array
from simulate.model.effect import Effect

_BINS = 24  # over the elongations of all loops
_FADED = 5.0  # 1 / beta behind a reversal from which on a branch is on its asymptote
_MOST, _UNKNOWN = 0.3, 0.1  # of a stroke: the most that is left out behind a reversal, and what is where beta is not known
_LEAST_BINS = 9
_LONGER = 1.0 / 3.0  # of the elongations seen, over which the strip is taken to be out far enough
_MATTERS = 0.1  # of the loops' height: a smaller departure is no transition
_SURE = 3.0  # standard errors


@dataclass(frozen=True)
class Level:
    """Level of the force by elongation, and what it says.

    elongation_m, level_N, stderr_N : (k,), of bins that were passed in both directions. departure_N : (k,) from the straight line
    of the longest third. complete_from_m : elongation from which on the level follows that line, NaN where that cannot be told.
    """

    elongation_m: Array
    level_N: Array
    stderr_N: Array
    departure_N: Array
    complete_from_m: float
    sentence: str


def level_against_length(
    loops: Sequence[LoopData], beta_per_m: float, effects: Sequence[Effect] = (), tares_N: Sequence[float] = ()
) -> Level:
    """Mean of both branches by elongation, inertia subtracted, what lies behind a reversal left out.

    In the mean of both directions dry and viscous friction cancel. Its standard error is that of the mean over strokes, because
    samples of one stroke share its errors.

    Parameters
    ----------
    beta_per_m : how soon a branch is on its asymptote, 1/m; NaN where no fit tells it.
    """
    edges = _edges(loops)
    strokes = [s for k, data in enumerate(loops) for s in _strokes(data, edges, beta_per_m, tuple(effects), tares_N[k] if tares_N else 0.0)]
    branch = [np.array([means for direction, means in strokes if direction == sign]).reshape(-1, _BINS) for sign in (1, -1)]
    counted = [np.sum(np.isfinite(table), axis=0) for table in branch]
    seen = (counted[0] > 0) & (counted[1] > 0)
    centre = ((edges[1:] + edges[:-1]) / 2.0)[seen]
    lower, upper = (np.nanmean(table[:, seen], axis=0) for table in branch)
    noise = max(data.force_sigma_N for data in loops)
    stderr = np.sqrt(sum(_variance(table[:, seen], noise) for table in branch)) / 2.0
    return _judged(centre, (lower + upper) / 2.0, stderr, float(np.median(upper - lower)) if np.any(seen) else float("nan"))


def _edges(loops: Sequence[LoopData]) -> Array:
    everywhere = np.concatenate([data.elongation_m[data.used] for data in loops])
    return np.linspace(everywhere.min(), everywhere.max(), _BINS + 1)


def _strokes(data: LoopData, edges: Array, beta: float, effects: tuple[Effect, ...], tare: float) -> Iterator[tuple[int, Array]]:
    """Direction and mean force by bin of each stroke from reversal to reversal; NaN where it did not pass."""
    force = data.force_N + inertia(data, effects) - tare
    for a, b in pairwise(data.cycles.reversals):
        here = np.arange(a, b + 1)
        way = np.abs(data.elongation_m[here] - data.elongation_m[a])
        fresh = min(_FADED / beta, _MOST * way[-1]) if np.isfinite(beta) else _UNKNOWN * way[-1]
        here = here[data.used[here] & (way > fresh)]
        place = np.clip(np.searchsorted(edges, data.elongation_m[here], side="right") - 1, 0, _BINS - 1)
        count = np.bincount(place, minlength=_BINS)
        total = np.bincount(place, force[here], minlength=_BINS)
        yield (1 if data.elongation_m[b] > data.elongation_m[a] else -1), np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _variance(table: Array, noise: float) -> Array:
    """Variance of the mean over strokes; of a single stroke that of the noise stands in for it."""
    many = np.sum(np.isfinite(table), axis=0)
    spread = np.array([np.nanvar(column, ddof=1) if n > 1 else noise**2 for column, n in zip(table.T, many, strict=True)])
    return np.maximum(spread, noise**2 / 25.0) / np.maximum(many, 1)


def _judged(u: Array, level: Array, stderr: Array, height: float) -> Level:
    if len(u) < _LEAST_BINS:
        nothing = np.full(len(u), np.nan)
        return Level(
            u, level, stderr, nothing, float("nan"), "cannot tell: no length of strip was passed in both directions far from a reversal"
        )
    longer = u >= u[-1] - (u[-1] - u[0]) * _LONGER
    slope, at_end = np.polyfit(u[longer] - u[-1], level[longer], 1, w=1.0 / stderr[longer])
    departure = level - (at_end + slope * (u - u[-1]))
    limit = np.maximum(_MATTERS * abs(height), _SURE * stderr)
    off = np.flatnonzero((np.abs(departure) > limit) & ~longer)
    said = f"the level is {at_end:.4g} N at {u[-1]:.3g} m, slope {slope:.3g} N/m"
    if not len(off):
        return Level(
            u, level, stderr, departure, float(u[0]), f"complete from {u[0]:.3g} m on, the shortest seen: {said}, nowhere off that line"
        )
    last = float(u[off[-1] + 1])
    if departure[0] > 0.0:
        bent = f"no transition zone, where force would be missing, but a bend: {departure[0]:.2g} N above that line at {u[0]:.3g} m"
        return Level(u, level, stderr, departure, last, f"straight from about {last:.3g} m on: {said}; {bent}")
    first = f"{abs(departure[0]):.2g} N below that line at {u[0]:.3g} m"
    tail = "fit --effect transition-zone, or leave shorter elongations out"
    return Level(u, level, stderr, departure, last, f"complete from about {last:.3g} m on: {said}, and {first}; {tail}")
