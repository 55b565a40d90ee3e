"""A force in every leg that goes with its elongation and has no name: seen where it is, and not where it is not."""

from __future__ import annotations

import numpy as np
import pytest
from board.outside import CoilRipple

from identify.campaign.runs import read_campaign
from identify.gap.leg_force import chance_of_leg_force, closed_by_leg_force, leg_force
from identify.report.result import result_of
from identify.selection.comparison import BUDGETS
from identify.selection.explain import explain
from identify.selection.gap_test import GAP_P
from simulate.effects import CATALOGUE, ViscousFriction
from simulate.files.model_file import read_model

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


def _explained(folder):
    """Without the catalogue's own ripple, so that the one that is hidden has no name."""
    kinds = {name: kind for name, kind in CATALOGUE.items() if name != "ripple"}
    return explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]), kinds, budget=BUDGETS["quick"])


@pytest.mark.slow
def test_loops_with_a_ripple_are_unknown_and_it_is_said_what_they_lack(campaign):
    found = _explained(campaign(CoilRipple(0.004), 637, deployments=()))
    assert found.verdict == "unknown"
    assert "in every leg that goes with its elongation" in str(result_of(found)["missing_force"])


@pytest.mark.slow
def test_loops_with_a_friction_are_named_and_lack_no_force_in_the_legs(campaign):
    found = _explained(campaign(ViscousFriction(0.05), 638, deployments=()))
    assert found.verdict == "named"
    assert chance_of_leg_force(found.after) > GAP_P


def test_the_ripple_is_drawn_as_it_was(campaign, fitted):
    """Up to what the force law can say itself, a level and a slope."""
    found = leg_force(fitted(campaign(CoilRipple(0.01), 639, deployments=())))
    assert found is not None
    u = found.elongation_m
    known = found.sigma_N < 3.0 * np.median(found.sigma_N)
    ripple = 0.01 * np.sin(2.0 * np.pi * u / 0.06)
    level = np.linalg.lstsq(np.stack([np.ones(known.sum()), u[known]], axis=1), (found.force_N - ripple)[known], rcond=None)[0]
    off = (found.force_N - ripple)[known] - level[0] - level[1] * u[known]
    assert np.sqrt(np.mean(off**2)) < 0.002
    assert np.sqrt(np.mean(ripple[known] ** 2)) > 0.005
