"""Effects fitted jointly: from where a fit starts, when releases have swallowed a part of what is missing."""

from __future__ import annotations

import numpy as np

from identify.campaign import read_campaign
from identify.candidates import as_planned, fit_screened
from identify.evidence import GAP_P, gap_test
from identify.fit import before_the_stops, solve
from identify.knobs import POSE
from identify.problem import problem_of
from identify.screening import screen
from simulate.effects import LegDisparity
from simulate.model_file import read_model

LEGS = np.array([0.020, -0.020, 0.0, 0.010, -0.010, 0.0])


def test_releases_that_have_swallowed_an_effect_give_it_back(campaign):
    """Unequal legs leave releases far from the plan; with the effect they are as planned again, and the legs are as they were made."""
    folder = campaign(LegDisparity(tuple(LEGS)), 601)
    runs = [run for run in read_campaign([folder / "campaign.toml"]) if not run.hold_out]
    early = before_the_stops(problem_of(read_model(folder / "model.toml"), runs))
    before = solve(early)
    assert gap_test(before).release_p < GAP_P
    (legs,) = screen(before, [LegDisparity()])
    found = fit_screened(before, legs).fit
    assert gap_test(found).release_p > GAP_P
    assert found.cost < before.cost - 0.8 * legs.promise * before.dilution
    (effect,) = found.problem.effects_at(found.q)
    differences = np.asarray(effect.flat()) - np.mean(effect.flat())
    assert np.corrcoef(differences, LEGS)[0, 1] > 0.8


def test_planned_releases_move_nothing_but_where_the_platform_was_let_go(campaign):
    folder = campaign(None, 602, loops=(), deployments=({},))
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    planned = as_planned(problem, np.ones(len(problem.knobs)))
    moved = {knob.name.rpartition(":")[2] for knob, value in zip(problem.knobs, planned, strict=True) if value == 0.0}
    assert moved == set(POSE)
