"""Without loops the force law bends to what is missing; every name is weighed from the law of the model file as well."""

from __future__ import annotations

import pytest

from identify.selection.hypotheses import BUDGETS, log_prior
from identify.selection.search import Search
from simulate.effects import CATALOGUE, HubInertia

FEW = ("hub-inertia", "leg-mass", "camera-roll")


@pytest.mark.slow
def test_a_hub_is_found_behind_a_law_that_has_bent_to_it(campaign, fitted, prototype):
    """Two elevations of a rig whose hub is 10 g heavier, and no loop that holds the law."""
    runs = {"loops": (), "deployments": ({}, {"geometry.stowed_height_m": 0.30}), "hold_out": False, "channels": ("z_m",)}
    hub = HubInertia(prototype.effect(HubInertia).mass_kg + 0.01)
    catalogue = {name: CATALOGUE[name] for name in FEW}
    search = Search(catalogue, log_prior(catalogue), BUDGETS["normal"], lambda text: None)
    search.run(fitted(campaign(hub, 95, **runs)))
    found = search.settled()
    assert "hub-inertia" in found.names
    assert found.weighed.leaves_noise
