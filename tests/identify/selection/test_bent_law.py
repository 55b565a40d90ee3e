"""Without loops the force law bends to what is missing; every name is weighed from the law of the model file as well."""

from __future__ import annotations

import pytest

from identify.gap.bent_law import is_bent
from identify.selection.evidence import Both
from identify.selection.hypotheses import BUDGETS, log_prior
from identify.selection.promises import promises
from identify.selection.search import Search
from identify.selection.stand import Stand, Weighed
from identify.selection.weighing import stands_of, weighed
from simulate.effects import CATALOGUE, AirDrag, HubInertia

FEW = ("hub-inertia", "leg-mass", "camera-roll")
RUNS = {"loops": (), "deployments": ({}, {"geometry.stowed_height_m": 0.30}), "hold_out": False, "channels": ("z_m",)}


def test_a_drag_is_promised_from_the_law_of_the_model_file_too(campaign, fitted):
    """Where least squares have bent the law to a drag, straight lines are taken from there and from the law as it was given."""
    catalogue = {"air-drag": AirDrag}
    fit = fitted(campaign(AirDrag(1.0), 96, **RUNS))
    bent = Stand.exact(fit)
    stands = stands_of(Weighed(bent, Stand.loose(fit), Both(bent.weighed(), None)))
    law = slice(fit.problem.first_nuisance)
    assert is_bent(fit)
    assert [bool(at.fit.q[law].any()) for at, _ in stands] == [True, True, False]
    found = [one.log_z - reached for at, reached in stands for one in promises(at, catalogue) if one.name == "air-drag"]
    assert found[-1] > 5.0


def test_a_base_that_has_come_close_is_looked_from_up_to_the_first_stop_where_that_is_asked_for(campaign, fitted):
    one = weighed(fitted(campaign(None, 94, loops=((1.0, 0.03),), deployments=({},), hold_out=False)))
    assert not one.stand.misses
    assert stands_of(one) == [(one, one.along_lines)]
    whole, *found = stands_of(one, closely=True)
    assert whole == (one, one.along_lines)
    assert len(found) == 1
    assert all(at.fit.problem.measured < one.fit.problem.measured and reached == at.along_lines for at, reached in found)


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
