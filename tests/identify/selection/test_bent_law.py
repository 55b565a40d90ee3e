"""Without loops the force law bends to what is missing; every name is tried from the law of the model file as well."""

from __future__ import annotations

import pytest

from identify.estimation.horizons import before_the_stops
from identify.estimation.least_squares import solve
from identify.gap.bent_law import with_law_as_given
from identify.selection.promises import nearly_as_good, promises
from identify.selection.weighing import along_lines
from simulate.effects import CATALOGUE, HubInertia

FEW = ("hub-inertia", "leg-mass", "viscous-friction", "camera-roll", "counterweight-inertia")


@pytest.fixture
def from_the_file(campaign, fitted, prototype):
    """Two elevations of a rig whose hub is 10 g heavier: whole, and up to the first stop with the law as the model file has it."""
    runs = {"loops": (), "deployments": ({}, {"geometry.stowed_height_m": 0.30}), "hold_out": False, "channels": ("z_m",)}
    hub = HubInertia(prototype.effect(HubInertia).mass_kg + 0.01)
    base = fitted(campaign(hub, 95, **runs))
    return base.problem, along_lines(with_law_as_given(solve(before_the_stops(base.problem), base.q)))


def test_a_name_is_found_by_a_few_steps_where_straight_lines_say_little_of_it(from_the_file):
    whole, early = from_the_file
    found = list(promises(early, {name: CATALOGUE[name] for name in FEW}))
    by_lines = {one.name: one.log_z for one in found}
    tried = {one.name: one for one in nearly_as_good(early, whole, found)}
    assert next(iter(tried)) == "hub-inertia"
    assert tried["hub-inertia"].log_z > by_lines["hub-inertia"] + 2.0
    assert tried["hub-inertia"].sizes[0] > 0.0
    assert "camera-roll" not in tried


def test_longer_films_tell_apart_what_films_up_to_the_first_stop_do_not(from_the_file):
    whole, early = from_the_file
    found = list(promises(early, {name: CATALOGUE[name] for name in FEW}))
    assert {"hub-inertia", "leg-mass"} <= {one.name for one in nearly_as_good(early, before_the_stops(whole), found)}
    assert [one.name for one in nearly_as_good(early, whole, found)] == ["hub-inertia"]
