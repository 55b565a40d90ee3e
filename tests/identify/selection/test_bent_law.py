"""Without loops the force law bends to what is missing; every name is weighed from the law of the model file as well."""

from __future__ import annotations

import pytest

from identify.selection.hypotheses import BUDGETS, log_prior
from identify.selection.promises import promises
from identify.selection.search import Search
from identify.selection.weighing import stands_of, weighed
from simulate.effects import CATALOGUE, AirDrag, HubInertia

FEW = ("hub-inertia", "leg-mass", "camera-roll")
RUNS = {"loops": (), "deployments": ({}, {"geometry.stowed_height_m": 0.30}), "hold_out": False, "channels": ("z_m",)}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [96, 98])
def test_a_drag_to_which_the_law_has_bent_promises_far_more_from_the_law_of_the_model_file(campaign, fitted, seed):
    catalogue = {"air-drag": AirDrag}
    stands = stands_of(weighed(fitted(campaign(AirDrag(1.0), seed, **RUNS))))
    found = [one.log_z - reached for at, reached in stands for one in promises(at, catalogue) if one.name == "air-drag"]
    assert max(found) == found[-1]
    assert found[-1] > found[0] + 10.0


@pytest.mark.slow
def test_a_hub_is_found_behind_a_law_that_has_bent_to_it(campaign, fitted, prototype):
    """Two elevations of a rig whose hub is 10 g heavier, and no loop that holds the law."""
    hub = HubInertia(prototype.effect(HubInertia).mass_kg + 0.01)
    catalogue = {name: CATALOGUE[name] for name in FEW}
    search = Search(catalogue, log_prior(catalogue), BUDGETS["normal"], lambda text: None)
    search.run(fitted(campaign(hub, 95, **RUNS)))
    found = search.settled()
    assert "hub-inertia" in found.names
    assert found.weighed.leaves_noise
