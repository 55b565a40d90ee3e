"""Without loops the force law bends to what is missing; every name is weighed from the law of the model file as well."""

from __future__ import annotations

import pytest

from identify.gap.bent_law import is_bent
from identify.selection.evidence import Both, Evidence
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


@pytest.mark.parametrize(("prior_p", "stands"), [(0.4, 1), (0.01, 2)])
def test_where_an_improbable_base_has_come_close_names_are_weighed_up_to_the_first_stop_as_well(
    campaign, fitted, monkeypatch, prior_p, stands
):
    """Joints bent by up to two tolerances followed a cable: of it straight lines promised -2 there, and 31 up to the first stop."""
    one = weighed(fitted(campaign(None, 94, loops=((1.0, 0.03),), deployments=({},), hold_out=False)))
    assert not one.stand.misses
    monkeypatch.setattr(Evidence, "prior_p", prior_p)
    found = stands_of(one)
    assert len(found) == stands
    assert found[0] == (one, one.along_lines)
    assert len(stands_of(one, closely=True)) == 2
    assert all(at.fit.problem.measured < one.fit.problem.measured and reached == at.along_lines for at, reached in found[1:])


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
