"""Another way to the uncertainty of a fit of loops: a bootstrap by whole cycles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from identify.estimation.least_squares import solve
from identify.estimation.problem import Fit
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array


def bootstrap(
    fit: Fit, names: Sequence[str], repeats: int, seed: int, watch: Callable[[int], object] = lambda _: None
) -> dict[str, tuple[float, float]]:
    """95 % intervals of parameters from fits to cycles drawn with replacement.

    In each loop the residual of whole cycles is drawn, with replacement, and put onto the modelled force of the cycles there; what
    is no part of a full cycle keeps its own. Samples are never drawn one by one: neighbours are not independent.

    Parameters
    ----------
    names : of the parameters. repeats : how many fits; 200 are enough for an interval.
    watch : told after every fit how many have been made.
    """
    rng, problem = np.random.default_rng(seed), fit.problem
    left = fit.residuals_N
    drawn = []
    for made in range(repeats):
        again = tuple(replace(loop, data=_redrawn(loop.data, own, rng)) for loop, own in zip(problem.loops, left, strict=True))
        found = solve(replace(problem, loops=again), fit.q, robust=fit.robust)
        drawn.append([found.value(name) for name in names])
        watch(made + 1)
    low, high = np.quantile(np.array(drawn), [0.025, 0.975], axis=0)
    return {name: (float(a), float(b)) for name, a, b in zip(names, low, high, strict=True)}


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
