"""A push at a few places: found where there was one, and no match for an effect where there was that."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from board.outside import Gust, SideWind

from identify.campaign.runs import read_campaign
from identify.estimation.fit import Fit
from identify.estimation.least_squares import bic, solve_from_afar
from identify.gap.platform_force import ForceAlongTime, at_once
from identify.gap.sparse_force import chance_of_push, is_bent, push
from identify.report.result import sentence
from identify.selection.explain import explain
from identify.selection.gap_test import GAP_P, gap_test
from simulate.effects import GravityImbalance, LegDisparity, ReleasePose
from simulate.files.model_file import read_model

UNEQUAL = LegDisparity((3e-4, -2e-4, 1e-4, -3e-4, 2e-4, -1e-4))
TWO_HEIGHTS = ({}, {"geometry.stowed_height_m": 0.35})
BESIDE_ITS_LEVEL = "the chance of a sparse force is 0.008 with one engine for loops and deployments, beside a level of 0.01"


def test_a_gust_is_a_push_at_its_time(campaign, fitted):
    found = push(fitted(campaign(Gust(0.1), 611, deployments=TWO_HEIGHTS, hold_out=False)), np.inf)
    assert found is not None
    assert found.force.along is ForceAlongTime
    peak = int(np.argmax(np.abs(found.force.force_N[:, 0])))
    assert found.force.places[peak] == pytest.approx(0.20)
    assert found.force.force_N[peak, 0] == pytest.approx(0.1, abs=0.03)
    assert gap_test(found.force.fit).p_value > GAP_P
    assert "upwards" in found.force.sentence


def test_noise_is_no_push(campaign, fitted):
    assert push(fitted(campaign(None, 612, deployments=TWO_HEIGHTS, hold_out=False)), np.inf) is None


def test_a_steady_weight_is_said_in_fewer_words_than_pushes_need(campaign, fitted):
    """A weight acts at every instant; a few places say less, and a BIC that the weight reaches is not even tried for."""
    before = fitted(campaign(GravityImbalance(0.05), 613, deployments=TWO_HEIGHTS, hold_out=False))
    weighed = solve_from_afar(before.problem.with_effects((GravityImbalance(),)), np.append(before.q, 0.0))
    found = push(before, np.inf)
    assert found is not None
    assert found.bic > bic(weighed)


def with_legs(before: Fit) -> Fit:
    return solve_from_afar(before.problem.with_effects((LegDisparity(),)), np.concatenate([before.q, np.zeros(6)]))


@pytest.mark.slow
@pytest.mark.xfail(reason=BESIDE_ITS_LEVEL)
def test_legs_that_differ_may_look_like_a_push_and_stay_what_they_are(campaign, fitted):
    """What six constant forces can do to a film is nearly a constant force and moment, which two or three places follow."""
    before = fitted(campaign(UNEQUAL, 617, deployments=TWO_HEIGHTS, hold_out=False))
    found = push(before, np.inf)
    assert found is not None
    assert chance_of_push(before, with_legs(before), found) > 0.01


@pytest.mark.slow
def test_legs_bent_around_a_gust_would_hardly_ever_look_so_like_a_push(campaign, fitted):
    before = fitted(campaign(Gust(0.1), 611, deployments=TWO_HEIGHTS, hold_out=False))
    found = push(before, np.inf)
    assert found is not None
    assert chance_of_push(before, with_legs(before), found) < 0.01


@pytest.mark.slow
@pytest.mark.xfail(reason=BESIDE_ITS_LEVEL)
def test_a_push_says_nothing_against_rivals_of_which_one_would_often_look_like_it(campaign, fitted):
    before = fitted(campaign(UNEQUAL, 617, deployments=TWO_HEIGHTS, hold_out=False))
    found = push(before, np.inf)
    assert found is not None
    few_words = replace(found, bic=-np.inf)
    released = solve_from_afar(before.problem.with_effects((ReleasePose(),)), np.concatenate([before.q, np.zeros(9)]))
    assert is_bent(before, [released], few_words)
    assert not is_bent(before, [released, with_legs(before)], few_words)


def test_a_moment_shows_as_one(campaign, fitted):
    """A draught that twists the platform with an arm of 50 mm: the estimate has force and moment in that proportion."""
    found = at_once(fitted(campaign(SideWind(0.02), 614, deployments=TWO_HEIGHTS, hold_out=False)))
    lateral, moment = found.force_N[:, 1], found.force_N[:, 2]
    known = found.sigma_N[:, 2] < 0.3 * np.abs(moment).max()
    assert known.sum() >= 3
    arm_m = moment[known] @ lateral[known] / (lateral[known] @ lateral[known])
    assert arm_m == pytest.approx(0.05, rel=0.5)


@pytest.mark.calibrate
def test_six_legs_that_leave_a_force_behind_are_not_named(campaign):
    """Six legs can push the platform any way there is: a draught too faint for pushes is theirs but for a swell."""
    folder = campaign(SideWind(0.003), 618)
    found = explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]), {"leg-disparity": LegDisparity})
    assert found.verdict == "unknown"
    assert found.nearest is not None
    assert found.nearest[0] == "leg-disparity"
    assert 0.99 < found.nearest[1] < 1.0
    assert re.search(r"leg-disparity comes nearest, closing 99\.\d % of it", sentence(found))


@pytest.mark.calibrate
@pytest.mark.parametrize(("force", "seed"), [(Gust(0.1), 615), (SideWind(0.03), 616)])
def test_a_force_outside_the_catalogue_is_not_given_the_name_of_an_effect_that_bends_itself_around_it(campaign, force, seed):
    folder = campaign(force, seed, deployments=({}, {"geometry.stowed_height_m": 0.30}, {"platform.mass_kg": 1.0}, {}))
    found = explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    assert found.verdict == "unknown"
    assert found.missing is not None
    assert "No missing force" not in found.missing.sentence
