"""Behind the stops a release has several valleys; the right one is found again from a wrong one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from identify.campaign import Run
from identify.evidence import GAP_P, gap_test
from identify.fit import before_the_stops, solve
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


def test_a_release_in_a_wrong_valley_is_brought_into_the_right_one(made_by):
    """The second deployment of the demonstration, with the very model that it was made with."""
    start = {"geometry": {"stowed_height_m": 0.30}}
    problem = problem_of(
        replace(made_by.truth(), simulation=made_by.rig().simulation), [Run(read_measurement(DEMO / "deployment-2.csv"), start)]
    )
    own = list(range(problem.first_nuisance, problem.first_effect))
    wrong = list(wrong_valleys(problem, own, 12))
    assert len(wrong) >= 3
    for fit in wrong:
        again = released_again(fit, own)
        assert gap_test(again).p_value > GAP_P
        assert again.cost < 0.95 * fit.cost
