"""What could have been seen is seen, nine times out of ten; and which test would split a class."""

from __future__ import annotations

import json

import numpy as np
import pytest

from identify.campaign import read_campaign
from identify.commands.explain_gap import main
from identify.explain import explain
from simulate.effects import HubInertia
from simulate.model_file import read_model

LOOPS = ((1.0, 0.02), (3.0, 0.02))


def explained(folder):
    return explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))


def smallest(found, name):
    return next(one for one in found.sights if one.effect.name == name).sizes


@pytest.mark.slow
def test_an_effect_of_the_smallest_size_that_could_be_seen_is_seen_about_nine_times_in_ten(campaign):
    known = smallest(explained(campaign(None, 600, loops=LOOPS, deployments=())), "hub-inertia")["mass_kg"]
    gaps = [explained(campaign(HubInertia(0.746 + known), 601 + i, loops=LOOPS, deployments=())).verdict for i in range(20)]
    assert sum(verdict != "no-gap" for verdict in gaps) >= 14
    less = [explained(campaign(HubInertia(0.746 + 0.2 * known), 651 + i, loops=LOOPS, deployments=())).verdict for i in range(10)]
    assert sum(verdict != "no-gap" for verdict in less) <= 2


def test_loops_say_nothing_of_the_platform(campaign):
    sights = {one.effect.name: one.sizes for one in explained(campaign(None, 700, loops=LOOPS, deployments=())).sights}
    assert np.isnan(sights["gravity-imbalance"]["force_N"]) if "gravity-imbalance" in sights else True
    assert sights["viscous-friction"]["damping_N_s_per_m"] < 0.02
    assert not any(
        np.isfinite(list(sights[name].values())).any() for name in sights if name in ("pulley-inertia", "air-drag", "camera-roll")
    )


@pytest.mark.slow
def test_a_loop_is_foreseen_to_split_what_one_deployment_cannot(campaign):
    """On the platform the inertia of a pulley and of six hubs look alike; a shaker has no pulley. (`leg-mass` is one with the hubs.)"""
    heights = ({}, {"geometry.stowed_height_m": 0.30})
    folder = campaign(HubInertia(0.746 + 0.002), 710, loops=(), deployments=heights, hold_out=False)
    assert main([str(folder / "model.toml"), str(folder / "campaign.toml"), "-o", str(folder / "out"), "--quiet"]) == 0
    result = json.loads((folder / "out" / "result.json").read_text())
    assert result["verdict"] == "class"
    loops = [test for test in result["next_experiments"] if test["kind"] == "loop"]
    (effect,) = result["effects"]
    assert {"hub-inertia", "pulley-inertia"} <= {effect["name"], *effect["equivalents"]}
    assert max(min(test["splits"].values()) for test in loops) > 0.9
    assert result["next_experiment"].startswith("To tell")
