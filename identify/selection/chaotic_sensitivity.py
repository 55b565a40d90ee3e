"""Films whose course nobody can predict, because it hangs on less than anyone knows of their release.

Behind a reversal a play takes a leg's force away for some milliseconds; whether a leg reverses at all then decides what comes after, and
a release that is moved by a nanometre gives another film. Such films neither speak for an effect nor against it.
"""

from __future__ import annotations

import numpy as np

from identify.estimation.problem import Problem
from identify.selection.null_hypothesis import SEED
from measure.common.arrays import Array

_HAIRS = (1e-6, 1e-5, 1e-4, 1e-3)  # of the spreads of a release
_DRAWS = 3  # of each
_RELEASES = 5  # within the spreads, that are looked at; one, where it is regular in every film
_MOST = 1e4  # noises for each spread; where the motion is regular it is some tens to some hundreds


def unpredictable(problem: Problem, q: Array) -> tuple[str, ...]:
    """Names of the films that a thousandth of what a release may differ by, or less, moves by more than ten times their noise.

    Parameters
    ----------
    q : (k,) parameters; those of the releases are drawn anew, as the spreads of the model have them.
    """
    chance, own = np.random.default_rng(SEED), slice(problem.first_nuisance, problem.first_zero)
    seen = []
    for _ in range(_RELEASES):
        here = q.copy()
        here[own] = chance.standard_normal(own.stop - own.start)
        seen.append(_sensitivity(problem, here, own, chance))
        if max(seen[0]) < _MOST:
            return ()
    films = [film.run.name for film in problem.films]
    return tuple(name for name, worst in zip(films, np.median(seen, axis=0), strict=True) if worst > _MOST)


def _sensitivity(problem: Problem, q: Array, own: slice, chance: np.random.Generator) -> list[float]:
    """For each film the largest root mean square change over the noise, for each spread that its release was moved by."""
    hairs = np.repeat(_HAIRS, _DRAWS)
    points = [q]
    for hair in hairs:
        moved = q.copy()
        moved[own] += hair * chance.standard_normal(own.stop - own.start)
        points.append(moved)
    first, *others = problem.gaps_beside(points)
    changes = np.abs(np.array(others) - first) / hairs[:, None]
    rows = [np.concatenate([np.r_[b.rows] for b in problem.blocks if b.run == film.run.name]) for film in problem.films]
    return [float(np.sqrt(np.mean(changes[:, of] ** 2, axis=1)).max()) for of in rows]
