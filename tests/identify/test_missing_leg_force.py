"""A force in every leg that goes with its elongation and has no name: seen where it is, and not where it is not."""

from __future__ import annotations

import pytest
from board.outside import CoilRipple

from identify.campaign import read_campaign
from identify.evidence import GAP_P
from identify.explain import explain
from identify.missing_leg_force import chance_of_leg_force, closed_by_leg_force
from simulate.effects import ViscousFriction
from simulate.model_file import read_model

ONE_FILM = ({},)


def test_a_ripple_too_quick_for_slow_against_fast_is_seen(campaign, fitted):
    """By loops and by a film, each alone."""
    by_film = {"loops": (), "deployments": ONE_FILM, "hold_out": False}
    for size, seed, runs in ((0.004, 631, {"deployments": ()}), (0.02, 632, by_film)):
        before = fitted(campaign(CoilRipple(size), seed, **runs))
        assert chance_of_leg_force(before) < 1e-6
        assert closed_by_leg_force(before) > 0.5 * (before.cost - before.problem.measured)


@pytest.mark.parametrize("seed", [633, 634, 635])
def test_noise_is_no_force_in_the_legs(campaign, fitted, seed):
    assert chance_of_leg_force(fitted(campaign(None, seed, deployments=ONE_FILM, hold_out=False))) > 1e-2


def test_loops_with_a_ripple_are_unknown_and_with_a_friction_named(campaign):
    for hidden, seed, verdict in ((CoilRipple(0.004), 637, "unknown"), (ViscousFriction(0.05), 638, "named")):
        folder = campaign(hidden, seed, deployments=())
        found = explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
        assert found.verdict == verdict
    assert chance_of_leg_force(found.after) > GAP_P
