"""Behind the stops a release has several valleys; the right one is found again from a wrong one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from identify.campaign import Run
from identify.evidence import GAP_P, gap_test
from identify.fit import Fit, before_the_stops, solve
from identify.problem import problem_of
from identify.valleys import released_again
from measure.measurement import read_measurement

DEMO = Path(__file__).resolve().parents[2] / "datasets" / "demo"


def wrong_valleys(problem, own, draws):
    """Fits that end in a wrong valley, from releases drawn as the motion before the stops allows; base as it is."""
    early = solve(before_the_stops(problem), free=own)
    chance = np.random.default_rng(1)
    for _ in range(draws):
        start = early.q.copy()
        start[own] = chance.multivariate_normal(early.q[own], early.covariance)
        fit = solve(problem, start, free=own, most_steps=60)
        if gap_test(fit).p_value < GAP_P:
            yield fit


def second_deployment(made_by):
    """Of the demonstration, with the very model that it was made with."""
    start = {"geometry": {"stowed_height_m": 0.30}}
    model = replace(made_by.truth(), simulation=made_by.rig().simulation)
    return problem_of(model, [Run(read_measurement(DEMO / "deployment-2.csv"), start)])


def test_a_release_in_a_wrong_valley_is_brought_into_the_right_one(made_by):
    problem = second_deployment(made_by)
    own = list(range(problem.first_nuisance, problem.first_effect))
    wrong = list(wrong_valleys(problem, own, 12))
    assert len(wrong) >= 3
    for fit in wrong:
        again = released_again(fit, own)
        assert gap_test(again).p_value > GAP_P
        assert again.cost < 0.95 * fit.cost


def test_a_film_that_a_fit_misses_before_its_stops_too_is_looked_for_again(made_by):
    """Runs fitted together can leave one of them far off from its release on; alone, up to the stops, it would be met."""
    problem = second_deployment(made_by)
    own = list(range(problem.first_nuisance, problem.first_effect))
    q = solve(before_the_stops(problem), free=own).q
    q[own] += 0.5
    gaps, slopes = problem.jacobian(q, own, problem.gaps(q))
    far_off = Fit(problem, q, gaps, slopes, converged=True)
    early = np.concatenate([far_off.part(block)[: len(far_off.part(block)) // 2] for block in problem.blocks])
    assert np.sqrt(np.mean(early**2)) > 2.0
    assert gap_test(released_again(far_off, own)).p_value > GAP_P
