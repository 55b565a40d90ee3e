"""A model against measurements, in numbers: run by run and channel by channel."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from identify.campaign.noiseless import with_noise_where_none
from identify.campaign.posing import problem_of
from identify.campaign.prepared import Film
from identify.campaign.run import Run
from identify.estimation.least_squares import off_the_mirror, solve
from identify.estimation.multistart import released_again
from identify.estimation.parameters import Change
from identify.estimation.problem import Fit
from identify.gap.comparison import Comparison, curves_of
from identify.gap.gap_test import gap_test
from simulate.model.model import Model


def compare(model: Model, runs: Sequence[Run], *, fit_release: bool = True, changes: Sequence[Change] = ()) -> Comparison:
    """Compare a model with what was measured.

    Parameters
    ----------
    model : Model
        The model file's.
    runs : Sequence of Run
        Loops and deployments, see `read_campaign`.
    fit_release : whether each run's own release (pose and instant, within the spreads of the model file) is fitted first;
        it differs from run to run without meaning anything. Otherwise the model is taken to the letter.
    changes : parameters that are held, bounded, or begin elsewhere.

    Returns
    -------
    Comparison
        Curves of every run and channel with their numbers, and whether the gap is noise.

    Raises
    ------
    InputError
        A run cannot be used with this model.
    """
    fit = _fitted(model, runs, fit_release, changes)
    noisy, added = with_noise_where_none(runs)
    test = gap_test(_fitted(model, noisy, fit_release, changes) if added else fit)
    return Comparison(fit, curves_of(fit), test, dispersion_percent(fit.problem.films))


def _fitted(model: Model, runs: Sequence[Run], fit_release: bool, changes: Sequence[Change]) -> Fit:
    problem = problem_of(model, runs, changes=changes)
    if not fit_release:
        return solve(problem, free=())
    releases = range(problem.first_nuisance, problem.first_effect)
    return released_again(off_the_mirror(solve(problem, free=releases)), releases)


def dispersion_percent(films: Sequence[Film]) -> float:
    """How much repeated deployments differ in elevation: rms over the measured range, the largest of all pairs, NaN without a pair."""
    found = [
        _difference_percent(a, b)
        for a, b in combinations(films, 2)
        if a.run.changes == b.run.changes and "z_m" in a.channels and "z_m" in b.channels
    ]
    return max(found, default=float("nan"))


def _difference_percent(a: Film, b: Film) -> float:
    curves = []
    for film in (a, b):
        values = film.values[film.channels.index("z_m")]
        good = np.isfinite(values)
        curves.append((film.time_s[good], values[good]))
    (ta, za), (tb, zb) = curves
    common = ta[(ta >= tb[0]) & (ta <= tb[-1])]
    if not len(common):
        return float("nan")
    difference = np.interp(common, ta, za) - np.interp(common, tb, zb)
    return 100.0 * float(np.sqrt(np.mean(difference**2))) / float(np.ptp(za))
