"""Sweeps: the paper's design on the inferred prototype, and what must not depend on how a sweep is run."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from simulate.deployment.deploy import deploy
from simulate.model import responses
from simulate.model.model import EndStop, Simulation
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import factors_of, paper_factors
from simulate.sweeps.regression import coefficients_of, variability_percent
from simulate.sweeps.result import SweepResult
from simulate.sweeps.sweep import Sweep, count_runs, run_on
from simulate.sweeps.tolerance import gradient_deg_per_N, spread_N


def swept(model, words, kind="full", runs=None, seed=0):
    factors = tuple(factors_of(model, words))
    sweep = Sweep(model, factors, design_of(kind, len(factors), runs, seed))
    return sweep, np.concatenate([answers for _, answers in run_on(sweep)])


def stepped(model, step_s):
    return replace(model, simulation=replace(model.simulation, step_s=step_s))


STORED_FORCES = [f"actuator.stored_force_N[{leg}]=+-10%" for leg in range(6)]
ALTERNATING = (1, -1, 1, -1, 1, -1)


@pytest.fixture(scope="module")
def stored_forces(prototype_once):
    return swept(prototype_once, STORED_FORCES)


def test_main_effects_alternate_and_are_what_the_paper_prints_within_two_percent(stored_forces):
    sweep, answers = stored_forces
    found = coefficients_of(sweep.design, "ABCDEF", lambda: iter([np.degrees(answers[:, responses.THETA_Z])]))
    for letter, sign in zip("ABCDEF", ALTERNATING, strict=True):
        assert sign * found[letter] == pytest.approx(86.6, rel=0.02)
    share = variability_percent(found)
    assert sum(share[letter] for letter in "ABCDEF") > 95


def test_all_twenty_triples_have_minus_the_product_of_their_signs(stored_forces):
    # aridon 2009 prints 5.79 to 5.86 for all of them; the inferred rig gives 5.3 to 5.9, and 7.8 for two
    sweep, answers = stored_forces
    found = coefficients_of(sweep.design, "ABCDEF", lambda: iter([np.degrees(answers[:, responses.THETA_Z])]))
    for places in combinations(range(6), 3):
        expected = -np.prod([ALTERNATING[i] for i in places])
        value = found["".join("ABCDEF"[i] for i in places)]
        assert value * expected > 0
        assert 5.2 < abs(value) < 7.9


def test_mirror_symmetry_of_the_rig_leaves_no_constant_and_hardly_any_even_product(stored_forces):
    sweep, answers = stored_forces
    found = coefficients_of(sweep.design, "ABCDEF", lambda: iter([np.degrees(answers[:, responses.THETA_Z])]))
    assert abs(found["1"]) < 1e-6
    assert max(abs(value) for name, value in found.items() if len(name) % 2 == 0) < 3.5


def test_most_combinations_of_the_stored_forces_fail(stored_forces):
    _, answers = stored_forces
    assert count_runs(answers, 30.0).failed_percent > 65


def test_a_sweeps_run_is_the_deployment_of_its_model(prototype):
    sweep, answers = swept(prototype, [*STORED_FORCES[:2], "platform.mass_kg=+-5%"])
    for run in (1, 6):
        deployed = deploy(stepped(sweep.model_at(sweep.design.piece(run, run + 1)[0]), 6.25e-5))
        theta = deployed.channels["theta_z_rad"]
        assert answers[run, responses.THETA_Z] == pytest.approx(theta[np.argmax(np.abs(theta))], abs=np.radians(0.015))
        assert answers[run, responses.FULL_HEIGHT] == deployed.time_to_full_height_s
        lateral = np.hypot(deployed.channels["x_m"], deployed.channels["y_m"])
        assert answers[run, responses.LATERAL] == pytest.approx(lateral.max(), abs=3e-5)
        tilt = np.hypot(deployed.channels["theta_x_rad"], deployed.channels["theta_y_rad"])
        assert answers[run, responses.TILT] == pytest.approx(tilt.max(), abs=np.radians(0.01))


def test_factors_that_bend_the_row_are_not_taken_for_straight_linear_rows(prototype):
    # the stowed lengths of the legs follow the stowed height by a square root
    model = replace(prototype, simulation=Simulation(0.3, 500.0))
    sweep, answers = swept(model, ["geometry.stowed_height_m=0.2..0.3", "actuator.stored_force_N[0]=+-1%"], "sobol", 8)
    assert sweep._linear_rows is None
    for run in range(8):
        theta = deploy(sweep.model_at(sweep.design.piece(run, run + 1)[0])).channels["theta_z_rad"]
        assert answers[run, responses.THETA_Z] == pytest.approx(theta[np.argmax(np.abs(theta))], abs=1e-6)


@pytest.mark.parametrize("workers", [1, 2])
def test_any_number_of_workers_gives_the_same_bytes(prototype, workers):
    model = replace(prototype, simulation=Simulation(0.3, 200.0))
    factors = tuple(paper_factors(model))
    sweep = Sweep(model, factors, design_of("random", 12, 700, 4))
    answers = np.concatenate([part for _, part in run_on(sweep, workers)])
    whole = sweep.responses(0, 700)
    np.testing.assert_array_equal(answers, whole)


def test_diverged_runs_are_counted_and_left_out_of_every_mean(prototype):
    # with the hard stop the step of 4 ms is far too long; with the soft one it is not
    model = replace(prototype, end_stop=EndStop(100.0, 1.0, 1e-3), simulation=Simulation(1.0, 250.0, 4e-3))
    words = ["end_stop.stiffness_N_per_m=100..1e9", "platform.mass_kg=+-1%", "actuator.stored_force_N[0]=+-1%"]
    sweep, answers = swept(model, words)
    result = SweepResult(sweep, [answers], "theta_z_deg", 30.0)
    counted = count_runs(answers, 30.0)
    assert counted.diverged == 4
    (values,) = result.values()
    assert np.all(np.isnan(values[~np.isnan(answers[:, responses.DIVERGED])]))
    assert result.report["diverged"] == 4
    assert counted.failed_percent == 100.0 * counted.failed / 4


def test_failure_probability_has_an_interval_that_narrows_with_the_runs():
    answers = np.zeros((1000, responses.COUNT))
    answers[:, responses.DIVERGED] = np.nan
    answers[:100, responses.THETA_Z] = 1.0
    low, high = count_runs(answers, 30.0).interval_percent()
    assert low < 10.0 < high
    assert high - low < 4.0
    few = count_runs(answers[::10], 30.0).interval_percent()
    assert few[1] - few[0] > 3 * (high - low)


def test_stored_force_turns_the_platform_by_about_365_degrees_a_newton_and_leg_about(prototype):
    slope = gradient_deg_per_N(prototype)
    assert np.abs(slope) == pytest.approx(np.full(6, 365.0), rel=0.05)
    assert np.all(np.sign(slope) == ALTERNATING)
    # a few degrees need a few millinewtons, which is the paper's conclusion
    assert 1e-3 < spread_N(slope, 3.0, 0.95) < 3e-3


def test_a_spread_within_the_tolerance_keeps_the_angle_with_the_stated_probability(prototype):
    spread = spread_N(gradient_deg_per_N(prototype), 5.0, 0.95)
    rng = np.random.default_rng(0)
    rows = [prototype.actuator.shifted(tuple(rng.normal(0.0, spread, 6))) for _ in range(200)]
    angles = [np.max(np.abs(deploy(replace(prototype, actuator=law)).channels["theta_z_rad"])) for law in rows]
    assert 0.90 < np.mean(np.degrees(angles) < 5.0) < 0.99
