"""Runs of a sweep, each in steps of its own: how exact, and what must not depend on the neighbours."""

from dataclasses import replace

import numpy as np
import pytest

from simulate.deployment.deploy import deploy
from simulate.dispatch.formulas import SIGNATURES
from simulate.dispatch.lane_forms import form_for_all
from simulate.effects import (
    CATALOGUE,
    Backlash,
    BaseExcitation,
    CentreOfMassOffset,
    CounterweightInertia,
    CurvedAsymptotes,
    FlexibleBase,
    GravityImbalance,
    HandrailContact,
    JointFriction,
    LegMass,
    PulleyInertia,
    RateDependentAsymptotes,
    Ripple,
    SeriesPlay,
    StribeckFriction,
    TransitionZone,
)
from simulate.kernel.step_size import pace_of
from simulate.model import responses
from simulate.model.model import Simulation
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import factors_of, paper_factors
from simulate.sweeps.sweep import Sweep, responses_of

DEGREE = np.degrees(1.0)


def drawn(model, runs, words=None, seed=3):
    factors = tuple(paper_factors(model) if words is None else factors_of(model, words))
    return Sweep(model, factors, design_of("random", len(factors), runs, seed))


def test_long_steps_in_flight_are_exact_to_a_fortieth_of_a_degree(prototype):
    sweep = drawn(prototype, 48)
    answers = sweep.responses(0, 48)
    fine = replace(sweep, longest_s=sweep.longest_s / 16).responses(0, 48)
    assert sweep.pace.frame == pytest.approx(2e-3)
    assert np.max(np.abs(answers - fine)[:, responses.THETA_Z]) * DEGREE < 0.025
    assert np.max(np.abs(answers - fine)[:, responses.BEFORE_STOP]) * DEGREE < 1e-3
    np.testing.assert_array_equal(answers[:, responses.FULL_HEIGHT], fine[:, responses.FULL_HEIGHT])
    np.testing.assert_allclose(answers[:, responses.STOP_FORCE], fine[:, responses.STOP_FORCE], rtol=0.005)


def test_half_the_longest_step_halves_every_step(prototype):
    whole, half = pace_of(prototype), pace_of(prototype, 1e-3)
    assert [getattr(half, name) for name in ("frame", "at_stops", "part")] == pytest.approx(
        [0.5 * getattr(whole, name) for name in ("frame", "at_stops", "part")]
    )


def test_every_response_is_that_of_the_single_deployment_also_between_two_steps(prototype):
    """Samples lie between the steps; the centre of mass off the axis makes place and swing differ."""
    model = prototype.with_effect(CentreOfMassOffset((4e-3, -2e-3, 1e-3)))
    model = replace(model, actuator=model.actuator.shifted((0.1, 0.0, 0.05, 0.0, 0.0, -0.02)), simulation=Simulation(0.8, 1000.0))
    (found,) = responses_of([model])
    run = deploy(replace(model, simulation=Simulation(0.8, 1000.0, 6.25e-5)))
    x, y, theta = (run.channels[name] for name in ("x_m", "y_m", "theta_z_rad"))
    assert found[responses.THETA_Z] == pytest.approx(theta[np.argmax(np.abs(theta))], abs=0.01 / DEGREE)
    assert found[responses.LATERAL] == pytest.approx(np.max(np.hypot(x, y)), abs=5e-5)
    assert found[responses.FULL_HEIGHT] == run.time_to_full_height_s


@pytest.mark.parametrize("rate", [100.0, 333.0, 1000.0, 4000.0])
def test_the_rate_of_sampling_hardly_moves_what_is_found(prototype, rate):
    model = replace(prototype, actuator=prototype.actuator.shifted((0.05, 0, 0, -0.03, 0, 0)))
    at_rate, exact = (
        responses_of([replace(model, simulation=Simulation(1.0, r))], longest)[0] for r, longest in ((rate, 2e-3), (4000.0, 2.5e-4))
    )
    assert at_rate[responses.THETA_Z] == pytest.approx(exact[responses.THETA_Z], abs=0.02 / DEGREE if rate > 200 else 0.5 / DEGREE)


def test_neighbours_their_number_and_their_order_change_no_digit(prototype):
    model = replace(prototype, effects=(*prototype.effects, StribeckFriction(0.01), TransitionZone(0.05), GravityImbalance(0.01)))
    model = replace(model, simulation=Simulation(0.7, 500.0))
    sweep = drawn(model, 60)
    coded = sweep.design.piece(0, 60)
    together = sweep.responses_at(coded)
    order = np.random.default_rng(0).permutation(60)
    np.testing.assert_array_equal(sweep.responses_at(coded[order]), together[order])
    np.testing.assert_array_equal(sweep.responses_at(coded[7:8], alone=True), together[7:8])
    np.testing.assert_array_equal(sweep.responses_at(coded[20:43], alone=True), together[20:43])


def test_a_run_that_diverges_is_named_with_its_time_and_its_neighbours_are_not_touched(prototype):
    model = replace(prototype, simulation=Simulation(1.0, 250.0, 4e-3))
    sweep = drawn(model, 24, ["end_stop.stiffness_N_per_m=100..1e9", "actuator.stored_force_N[0]=+-1%"])
    answers = sweep.responses(0, 24)
    lost = ~np.isnan(answers[:, responses.DIVERGED])
    assert 0 < lost.sum() < 24
    assert np.all(np.isnan(answers[lost, : responses.DIVERGED]))
    assert np.all((answers[lost, responses.DIVERGED] > 0.2) & (answers[lost, responses.DIVERGED] <= 1.0))
    coded = sweep.design.piece(0, 24)
    np.testing.assert_array_equal(sweep.responses_at(coded[~lost]), answers[~lost])


EVERY_KIND = {
    "leg_force after a reversal": (Backlash(2e-3),),
    "leg_force": (StribeckFriction(0.02, 0.05), TransitionZone(0.1, 0.08), Ripple(0.05, 0.03, 0.4)),
    "leg_asymptotes": (CurvedAsymptotes(2.0, -3.0), RateDependentAsymptotes(b_l=(0.05, 0.02))),
    "leg_mass, leg_transverse": (LegMass(0.2),),
    "joint_resistance": (JointFriction(1e-3, 2e-4),),
    "platform_mass": (CounterweightInertia(0.7), PulleyInertia(0.2)),
    "platform_wrench": (BaseExcitation(0.5, 8.0, 0.3), HandrailContact(1e-4, 500.0)),
    "strip_elongation": (SeriesPlay(1e-3),),
    "base_mass, base_force": (FlexibleBase(8.0, 12.0, 0.05),),
}


@pytest.mark.parametrize("kinds", EVERY_KIND)
def test_formulas_give_the_same_run_side_by_side_as_alone(prototype, kinds):
    """A formula is computed for all runs at once in a sweep, and with the functions of the library in a single deployment."""
    model = replace(prototype, effects=(*prototype.effects, *EVERY_KIND[kinds]), simulation=Simulation(0.25, 1000.0, 2.5e-4))
    model = replace(model, actuator=model.actuator.shifted((0.05, 0, 0, -0.03, 0, 0)))
    theta = deploy(model).channels["theta_z_rad"]
    assert responses_of([model])[0, responses.THETA_Z] == pytest.approx(theta[np.argmax(np.abs(theta))], abs=1e-9)


def test_every_formula_of_the_catalogue_is_computed_for_all_runs_at_once():
    formulas = [(name, kind, getattr(effect, kind)) for name, effect in CATALOGUE.items() for kind in SIGNATURES]
    assert [name for name, kind, formula in formulas if formula is not None and form_for_all(formula, kind) is None] == []
