"""Further tests that would split a class: how likely they do, and what no test can."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.criteria import LIKELY, RIVAL_P, STRONG_BIC
from identify.design.further_test import Condition, NextTest
from identify.design.next_test import (
    apart,
    chance_of_split,
    left_over,
    likely_parameters,
    likely_releases,
    worth_a_closer_look,
)
from identify.estimation.horizons import solve_from_afar
from identify.estimation.least_squares import laid_out, solve
from identify.estimation.problem import Fit
from identify.report.sentences import next_experiment
from simulate.effects import AirDrag, GeometryError, HubInertia, PowerLawFriction, ViscousFriction
from simulate.files.model_file import read_model

DEMO = Path(__file__).resolve().parents[3] / "datasets" / "demo"


@pytest.mark.parametrize(("before", "shown"), [(1.0, 9.0), (4.0, 16.0), (8.0, 5.0), (2.0, 40.0)])
def test_the_predicted_chance_is_how_often_the_test_splits(before, shown):
    """Gaussian noise on what two rivals say, either of them true: what is predicted before the test against what happens."""
    chance, runs, predicted, split = np.random.default_rng(7), 4000, [], []
    for _ in range(runs):
        side = 1.0 if chance.random() < 0.5 else -1.0
        lead = side * before + 2.0 * np.sqrt(before) * chance.normal()
        side, lead = (side, lead) if lead > 0 else (-side, -lead)  # the foremost is the one that leads
        if lead > _excluding(before):
            continue  # a rival that is led by so much is none any more
        predicted.append(chance_of_split(lead, before, _both(shown)))
        split.append(abs(lead + side * shown + 2.0 * np.sqrt(shown) * chance.normal()) > _excluding(before + shown))
    assert RIVAL_P == 0.01
    assert np.mean(predicted) == pytest.approx(np.mean(split), abs=4.0 * np.std(split) / np.sqrt(len(split)))


def _excluding(whole):
    """The lead that excludes a rival where all that was measured shows so much."""
    return max(STRONG_BIC, 2.0 * np.sqrt(whole) * 2.3263 - whole)


def _both(shown):
    """delta^2 of a test, the same whichever of the two is true."""
    return np.array([shown]), np.array([shown])


def test_a_test_that_shows_nothing_splits_nothing():
    assert chance_of_split(3.0, 2.0, _both(0.0)) < 1e-6
    assert chance_of_split(0.0, 0.0, _both(1e4)) > 0.999


def test_a_lead_that_has_not_excluded_a_rival_lets_no_test_exclude_it_that_shows_nothing():
    assert chance_of_split(40.0, 60.0, (np.array([0.0]), np.array([0.0]))) < 1e-6
    assert chance_of_split(40.0, 60.0, (np.array([100.0]), np.array([100.0]))) > 0.99


def test_a_test_that_shows_only_if_one_of_the_two_is_true_is_half_as_likely_to_split():
    assert chance_of_split(0.0, 0.0, (np.array([1e4]), np.array([0.0]))) == pytest.approx(0.5, abs=1e-3)
    # here the rival is hardly the true one any more
    assert chance_of_split(8.0, 0.0, (np.array([0.0]), np.array([1e4]))) < 0.05


def test_a_test_that_shows_only_with_some_of_the_parameters_that_may_be_true_splits_as_seldom():
    shown = np.array([1e4, 1e4, 1e4, 0.0])
    assert chance_of_split(0.0, 0.0, (shown, shown)) == pytest.approx(0.75, abs=1e-3)


def refitted(fit, effects):
    """The same measurements with these effects, fitted from where a fit stands."""
    problem = fit.problem.with_effects(effects)
    return solve(problem, laid_out(fit, problem))


@pytest.fixture(scope="module")
def on_the_shaker():
    """The demonstration's loops and the inertia that is hidden in them, fitted with one effect more."""
    base = solve_from_afar(problem_of(read_model(DEMO / "rig.toml"), read_campaign(sorted((DEMO / "loops").glob("*.csv")))))
    hub = refitted(base, [HubInertia()])
    return lambda effect: refitted(hub, [HubInertia(), effect])


def test_parameters_are_likely_as_far_as_the_measurements_bear_them_out(on_the_shaker):
    straight, bends = on_the_shaker(ViscousFriction()), on_the_shaker(PowerLawFriction(0.0, 1.5))
    assert straight.rms == pytest.approx(1.0, abs=0.02)
    assert len(likely_parameters(straight)) == 12
    kept = likely_parameters(bends)
    assert 0 < len(kept) < 12
    for q in kept:
        parabola = float(np.sum((bends.gaps + bends.jacobian @ (q - bends.q)) ** 2))
        assert float(np.sum(bends.problem.gaps(q) ** 2)) < parabola + 12.0  # kept once in 400 times there


def test_a_platform_is_not_predicted_to_be_let_go_just_as_it_should_be(prototype):
    problem = problem_of(prototype, [])
    assert not likely_releases(problem, Condition("a loop", frequency_Hz=1.0, amplitude_m=0.01), 6).any()
    turned = Condition("turned", {"release": {"theta_rad": [0.0, 0.0, 0.15]}})
    drawn = likely_releases(problem, turned, 400)
    assert drawn.shape[0] == 400
    assert np.std(drawn, axis=0) == pytest.approx(np.ones(drawn.shape[1]), abs=0.15)


@pytest.mark.parametrize("runs", [1, 2, 4])
def test_several_runs_alike_show_as_much_as_if_each_were_fitted_with_a_release_of_its_own(runs):
    chance = np.random.default_rng(4)
    shared, own, root, gaps = (chance.normal(size=size) for size in ((30, 3), (30, 2), (3, 3), (30, 5)))
    prior = np.hstack([np.zeros((2, 3)), np.eye(2)])
    rows = np.vstack([np.hstack([shared, own]), np.hstack([root, np.zeros((3, 2))]), prior])
    padded = np.vstack([gaps, np.zeros((5, 5))])
    further = np.array([True] * 30 + [False] * 3 + [True] * 2)
    whole = np.zeros((30 * runs + 3 + 2 * runs, 3 + 2 * runs))
    for i in range(runs):
        whole[30 * i : 30 * (i + 1), :3] = shared
        whole[30 * i : 30 * (i + 1), 3 + 2 * i : 5 + 2 * i] = own
    whole[30 * runs : 30 * runs + 3, :3] = root
    whole[30 * runs + 3 :, 3:] = np.eye(2 * runs)
    stacked = np.vstack([np.tile(gaps, (runs, 1)), np.zeros((3 + 2 * runs, 5))])
    left = np.sum((stacked - whole @ np.linalg.lstsq(whole, stacked)[0]) ** 2, axis=0)
    assert left_over(rows, padded, further, runs) == pytest.approx(left, rel=1e-9)


def test_no_loop_is_recommended_where_none_tells_the_rivals_apart(shaken):
    """On a shaker the inertia of the hub and that of the leg are one and the same, whatever the stroke and the frequency."""
    assert shaken.verdict == "class"
    on_shaker = [test for test in shaken.next_tests if test.condition.frequency_Hz]
    assert on_shaker
    assert all(chance < 0.05 for test in on_shaker for chance in test.chances.values())
    deployments = [test for test in shaken.next_tests if not test.condition.frequency_Hz]
    assert not any("film" in test.condition.words for test in deployments)
    assert shaken.next_tests[0].condition.words.startswith("a deployment")
    told = next_experiment(shaken)
    assert told is not None
    assert shaken.next_tests[0].surest >= LIKELY
    assert told.startswith(f"To tell {shaken.findings[0].name} from its rivals, add a deployment")
    assert shaken.findings[0].name in ("hub-inertia", "leg-mass")


def test_a_guess_is_looked_at_closely_if_it_promises_more_and_longer_where_nothing_is_likely():
    def guess(chance):
        return NextTest(Condition("a loop"), {"hub-inertia": chance})

    assert worth_a_closer_look(guess(0.1), [])
    assert not worth_a_closer_look(guess(0.1), [guess(0.5)])
    assert worth_a_closer_look(guess(0.6), [guess(0.5)] * 5)
    assert not worth_a_closer_look(guess(0.6), [guess(0.5)] * 6)
    assert worth_a_closer_look(guess(0.95), [guess(0.85)] * 2)
    assert not worth_a_closer_look(guess(0.95), [guess(0.85)] * 3)


def test_joints_that_are_off_and_a_drag_are_told_apart_by_what_both_say_of_the_same_measurements(campaign, fitted):
    """Each coordinate of a joint has a tolerance of its own, which the drag has not: that is no measurement."""
    base = fitted(campaign(None, 96, loops=(), deployments=({},), hold_out=False))
    drag, joints = (at_rest(base, effect) for effect in (AirDrag(), GeometryError()))
    assert len(joints.gaps) == len(drag.gaps) + 36
    for best, rival in ((drag, joints), (joints, drag)):
        found = apart(best, rival)
        assert len(found) == len(rival.gaps)
        assert np.abs(found).max() < 0.02  # both are the base


def at_rest(base, effect):
    """A fit with one effect more, at nought."""
    problem = base.problem.with_another(effect)
    q = np.concatenate([base.q, np.zeros(len(problem.parameters) - len(base.q))])
    gaps, slopes = problem.jacobian(q)
    return Fit(problem, q, gaps, slopes, True)
