"""Films that depend on a nanometre of their release are known for what they are; a play in the legs is none of them."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.commands import explain_gap
from identify.estimation.problem import Problem, problem_of
from identify.selection.chaotic_sensitivity import unpredictable
from simulate.effects import Backlash, GravityImbalance, HubInertia, LegDisparity, StribeckFriction
from simulate.files.model_file import read_model
from simulate.model.effect import LegEffect, parameter

UNEQUAL = LegDisparity((0.03, -0.02, 0.01, -0.03, 0.02, -0.01))


@pytest.fixture
def films(campaign) -> Problem:
    folder = campaign(None, 901, loops=(), hold_out=False)
    return problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))


@dataclass(frozen=True)
class Grain(LegEffect):
    """A force that changes its sign within a nanometre of elongation."""

    name = "grain"
    force_N: float = parameter(0.0, low=0.0, high=10.0, typical=0.1, doc="its size")

    @staticmethod
    def leg_force(u, v, t, R, travel, p):
        return p[0] * math.sin(1e10 * u)


def test_with_a_force_that_changes_within_a_nanometre_no_film_can_be_predicted(films):
    grained = films.with_effects((Grain(1.0),))
    assert unpredictable(grained, np.zeros(len(grained.parameters))) == ("deployment-1.csv", "deployment-2.csv", "deployment-3.csv")


@pytest.mark.parametrize(
    "effect", [HubInertia(0.1), GravityImbalance(0.3), UNEQUAL, StribeckFriction(0.02, 0.01), Backlash(1e-4)], ids=lambda e: e.name
)
def test_with_effects_of_the_catalogue_every_film_can(films, effect):
    acting = films.with_effects((effect,))
    assert unpredictable(acting, np.zeros(len(acting.parameters))) == ()


@pytest.mark.slow
def test_a_play_is_named_with_its_size(campaign, unseal, tmp_path):
    folder = campaign(Backlash(1.2e-4), 902, deployments=({}, {"platform.mass_kg": 1.0}), loop_steps=480_000)
    assert explain_gap.main([str(folder / "model.toml"), str(folder / "campaign.toml"), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert result["verdict"] == "named"
    finding, truth = result["effects"][0], unseal(902)
    assert finding["name"] == truth["name"]
    size = finding["parameters"]["gap_m"]
    assert abs(size["value"] - truth["values"]["gap_m"]) < 4.0 * size["stderr"]
    assert result["gap"]["after"]["rms_over_noise"] < 1.1
