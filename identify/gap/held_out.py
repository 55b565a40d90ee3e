"""Runs that took no part in a fit: what its base and effects leave of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.estimation.horizons import solve_from_afar
from identify.estimation.least_squares import laid_out, solve
from identify.estimation.multistart import released_again
from identify.estimation.problem import Fit
from identify.gap.comparison import Held
from identify.gap.size import NoiseOfChannel


def held_out(run: Run, before: Fit, after: Fit, noise: Sequence[NoiseOfChannel]) -> Held:
    """A run that took no part, under two models, or one; its release is looked for from where it is under the other one, too.

    noise : of the runs that took part.
    """
    without = carried_over(before, run)
    if after is before:
        return Held(without, without, noise=noise)
    having = carried_over(after, run, (without,))
    return Held(_with_release_of(without, having), having, noise=noise)


def carried_over(fit: Fit, run: Run, others: Sequence[Fit] = ()) -> Fit:
    """Base and effects of a fit on a run that took no part, of which only its own release is fitted.

    Parameters
    ----------
    others : fits of the same run under other models; its release may be as they have it.
    """
    of = fit.problem
    alone = problem_of(of.model, [run], of.covariate, own_zeros=of.own_zeros, changes=of.changes)
    problem = replace(alone, forces_differ=of.forces_differ, effects=of.effects)
    free = range(problem.first_nuisance, problem.first_effect)
    found = solve_from_afar(problem, laid_out(fit, problem), free=free)
    for other in others:
        found = _with_release_of(found, other)
    return released_again(found, free) if problem.films else found


def _with_release_of(fit: Fit, other: Fit) -> Fit:
    """A fit of a run that took no part, or a better one from the release that the run has under another model."""
    problem, start = fit.problem, fit.q.copy()
    free = range(problem.first_nuisance, problem.first_effect)
    start[free] = laid_out(other, problem)[free]
    return min(fit, solve(problem, start, free=free), key=lambda one: one.cost)
