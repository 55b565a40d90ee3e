"""Every number that sections 4 and 5 of Aridon 2009 print and that the shipped prototype can show."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from simulate.deployment.deploy import deploy
from simulate.files.model_file import read_model
from simulate.model import responses
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import paper_factors
from simulate.sweeps.regression import coefficients_of
from simulate.sweeps.step_search import choose_step
from simulate.sweeps.sweep import Sweep, count_runs, run_on
from simulate.sweeps.tolerance import gradient_deg_per_N, spread_N

LETTERS = "ABCDEFGHJKLM"
STORED, SLOPES = LETTERS[::2], LETTERS[1::2]
SIGNS = dict(zip(STORED, (1, -1, 1, -1, 1, -1), strict=True))


@pytest.fixture(scope="module")
def shipped():
    return read_model(Path(__file__).resolve().parents[3] / "datasets" / "prototype.toml")


@pytest.fixture(scope="module")
def full(shipped):
    sweep = choose_step(Sweep(shipped, tuple(paper_factors(shipped)), design_of("full", 12, None, 0)), 30.0).sweep
    answers = np.concatenate([part for _, part in run_on(sweep)])
    theta = np.degrees(answers[:, responses.THETA_Z])
    return sweep, answers, coefficients_of(sweep.design, LETTERS, lambda: iter([theta]))


def test_the_rig_of_the_other_tests_is_the_shipped_one(shipped, prototype):
    ours = replace(shipped, geometry=prototype.geometry)
    assert ours == prototype
    assert np.allclose(shipped.geometry.base_joints_m, prototype.geometry.base_joints_m, atol=1e-6)
    assert np.allclose(shipped.geometry.platform_joints_m, prototype.geometry.platform_joints_m, atol=1e-6)


def test_heights_mass_force_and_duration_are_the_printed_ones(shipped):
    assert shipped.geometry.deployed_height_m == 0.652
    assert shipped.geometry.deployed_height_m - shipped.geometry.stowed_height_m == pytest.approx(0.400)
    assert shipped.platform.mass_kg == 0.8
    assert shipped.platform.mass_kg * shipped.gravity.mass_factor == 1.6
    assert shipped.actuator.initial_force_N == 2.987
    assert shipped.actuator.b_u_N - shipped.actuator.b_l_N == pytest.approx(0.1)
    assert (shipped.simulation.duration_s, shipped.simulation.sample_rate_Hz) == (1.0, 1000.0)
    stored = paper_factors(shipped)[0]
    assert (round(stored.low, 2), round(stored.high, 2)) == (2.51, 3.07)


def test_the_platform_is_a_body_that_can_be(shipped):
    x, y, z = shipped.platform.inertia_kg_m2
    assert z <= x + y
    assert x <= y + z


@pytest.mark.slow
def test_none_of_the_4096_runs_diverges_and_69_percent_of_them_fail(full):
    _, answers, _ = full
    counted = count_runs(answers, 30.0)
    assert counted.runs == 4096
    assert counted.diverged == 0
    assert round(counted.failed_percent) == 69


@pytest.mark.slow
def test_main_effects_are_86_point_6_with_alternating_signs_to_a_tenth_of_a_degree(full):
    _, _, found = full
    for letter, sign in SIGNS.items():
        assert sign * found[letter] == pytest.approx(86.6, abs=0.1)


@pytest.mark.slow
def test_triples_have_the_printed_signs_and_eighteen_of_twenty_the_printed_size_within_ten_percent(full):
    _, _, found = full
    triples = list(combinations(STORED, 3))
    sizes = [-found["".join(letters)] * np.prod([SIGNS[letter] for letter in letters]) for letters in triples]
    assert min(sizes) > 0
    assert sum(abs(size - 5.83) < 0.583 for size in sizes) == 18
    assert max(sizes) < 8.0


@pytest.mark.slow
def test_slopes_have_no_influence(full):
    _, _, found = full
    assert max(abs(found[letter]) for letter in SLOPES) < 0.1


@pytest.mark.slow
def test_no_run_of_the_design_is_sensitive_and_all_are_exact_to_a_tenth_of_a_degree(full):
    sweep, answers, _ = full
    assert choose_step(sweep, 30.0).report["sensitive_probes"] == 0
    fine = replace(sweep, longest_s=sweep.longest_s / 8)
    drawn = np.random.default_rng(1).permutation(4096)[:192]
    exact = fine.responses_at(np.vstack([sweep.design.piece(run, run + 1) for run in drawn]))
    assert np.max(np.degrees(np.abs(exact - answers[drawn])[:, responses.THETA_Z])) < 0.1


def test_one_leg_turns_the_platform_by_365_degrees_a_newton_within_five_percent(shipped):
    assert np.abs(gradient_deg_per_N(shipped)) == pytest.approx(np.full(6, 365.0), rel=0.05)


def test_a_millinewton_holds_the_rotation_within_a_few_degrees(shipped):
    # printed: the stored forces must agree within 1e-3 N
    assert 1.0 < 1e-3 / spread_N(gradient_deg_per_N(shipped), 1.0, 0.95) < 3.0


def test_full_height_is_reached_within_the_five_frames_of_144_milliseconds(shipped):
    assert 0.45 < (deploy(shipped).time_to_full_height_s or np.inf) < 4 * 0.144


def test_the_initial_force_does_not_lift_the_weight_and_four_times_it_does(shipped):
    g = shipped.geometry
    legs = np.add(g.platform_joints_m, (0.0, 0.0, g.stowed_height_m)) - np.asarray(g.base_joints_m)
    lift = np.sum(2.987 * legs[:, 2] / np.linalg.norm(legs, axis=1))
    assert lift < 0.8 * 9.81 < 4 * lift
