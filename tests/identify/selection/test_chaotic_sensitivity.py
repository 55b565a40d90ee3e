"""Films that hang on a nanometre of their release: known for what they are, and no obstacle to what the loops say."""

from __future__ import annotations

import json

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.commands import explain_gap
from identify.estimation.problem import Problem, problem_of
from identify.selection.chaotic_sensitivity import unforeseen
from simulate.effects import Backlash, GravityImbalance, HubInertia, LegDisparity, StribeckFriction
from simulate.files.model_file import read_model

UNEQUAL = LegDisparity((0.03, -0.02, 0.01, -0.03, 0.02, -0.01))


@pytest.fixture
def films(campaign) -> Problem:
    folder = campaign(None, 901, loops=(), hold_out=False)
    return problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))


def test_with_a_play_no_film_can_be_foreseen(films):
    played = films.with_effects((Backlash(1e-4),))
    assert unforeseen(played, np.zeros(len(played.parameters))) == ("deployment-1.csv", "deployment-2.csv", "deployment-3.csv")


@pytest.mark.parametrize("effect", [HubInertia(0.1), GravityImbalance(0.3), UNEQUAL, StribeckFriction(0.02, 0.01)], ids=lambda e: e.name)
def test_with_other_effects_every_film_can(films, effect):
    acting = films.with_effects((effect,))
    assert unforeseen(acting, np.zeros(len(acting.parameters))) == ()


@pytest.mark.slow
def test_a_play_is_named_from_the_loops_where_films_jump_from_course_to_course(campaign, unseal, tmp_path):
    folder = campaign(Backlash(1.2e-4), 902, deployments=({}, {"platform.mass_kg": 1.0}), loop_steps=480_000)
    assert explain_gap.main([str(folder / "model.toml"), str(folder / "campaign.toml"), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert result["verdict"] == "named"
    finding, truth = result["effects"][0], unseal(902)
    assert finding["name"] == truth["name"]
    size = finding["parameters"]["gap_m"]
    assert abs(size["value"] - truth["values"]["gap_m"]) < 4.0 * size["stderr"]
    assert result["unforeseen_runs"] == ["deployment-1.csv", "deployment-2.csv"]
    assert "told by the loops alone" in result["sentence"]
    assert result["gap"]["after"]["rms_over_noise"] < 1.1
