"""The step of a model against its stiffest time constant, worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate import effects as known
from simulate.control.synchronise import Synchronise
from simulate.deployment.deploy import deploy
from simulate.kernel.response_kernel import Pace
from simulate.kernel.step_size import finest, grid, longest_flight, pace_of, step_of, unhurried_step
from simulate.model.model import EndStop, Gravity, Platform, Simulation

MASS = 1.6  # 0.8 kg, doubled by the counterweight


@pytest.fixture
def rig(prototype):
    """A heavy drum whose inertia at the joints is more than its mass, without effects and with a stop that is no spring and no damper."""
    plain = replace(prototype, effects=(), gravity=Gravity(0.0, 2.0), end_stop=EndStop(0.0, 0.0, 1e-3))
    return replace(plain, platform=Platform(0.8, (0.5, 0.5, 0.5)))


def stopped(rig, stiffness, damping=0.0):
    return replace(rig, end_stop=EndStop(stiffness, damping, 1e-3))


def test_nothing_stiff_takes_half_a_millisecond(rig):
    assert step_of(rig) == unhurried_step() == 5e-4
    assert step_of(rig, 2e-3) == longest_flight() == 2e-3


def test_a_stop_takes_a_fifth_of_its_radian_as_a_spring_of_six_legs(rig):
    assert step_of(stopped(rig, 1e6)) == pytest.approx(1 / (5 * np.sqrt(6 * 1e6 / MASS)))


def test_a_stop_takes_a_fifth_of_its_time_constant_as_a_damper_of_six_legs(rig):
    assert step_of(stopped(rig, 0.0, 500.0)) == pytest.approx(MASS / (5 * 6 * 500.0))


def test_a_small_inertia_seen_at_the_joints_counts_where_it_is_less_than_the_mass(rig):
    arm = max(np.linalg.norm(joint) for joint in rig.geometry.platform_joints_m)
    light = replace(rig, platform=Platform(0.8, (1e-5, 2e-5, 2e-5)))
    assert 1e-5 / arm**2 < 0.8
    assert step_of(stopped(light, 1e6)) == pytest.approx(1 / (5 * np.sqrt(6 * 1e6 / (2 * 1e-5 / arm**2))))


def test_friction_on_the_legs_counts_by_its_slope_six_times(rig):
    assert step_of(rig.with_effect(known.ViscousFriction(900.0))) == pytest.approx(MASS / (5 * 6 * 900.0), rel=1e-3)


def test_a_spring_on_the_platform_counts_once(rig):
    pendulum = rig.with_effect(known.CablePendulum(2e6))
    assert step_of(pendulum) == pytest.approx(1 / (5 * np.sqrt(2e6 / MASS)), rel=0.45)
    assert step_of(pendulum) < step_of(rig.with_effect(known.CablePendulum(1e6)))


def test_a_step_that_is_given_is_taken(rig):
    given = replace(stopped(rig, 1e9), simulation=Simulation(1.0, 1000.0, 7e-4))
    assert step_of(given) == 7e-4


def test_a_stop_without_end_has_a_step_without_length(rig):
    assert step_of(stopped(rig, 1e300)) < 1e-100


def test_a_grid_meets_every_sample(rig):
    """Steps of half a millisecond at most, a whole number between two samples, the first and the last sample kept."""
    for rate, duration, expected in ((1000.0, 1.0, (5e-4, 2, 1001)), (3000.0, 0.5, (1 / 3000, 1, 1501)), (300.0, 0.1, (1 / 2100, 7, 31))):
        step, stride, count = grid(replace(rig, simulation=Simulation(duration, rate)))
        assert (step, stride, count) == (pytest.approx(expected[0]), expected[1], expected[2])


def test_more_steps_or_samples_than_anybody_waits_for_are_refused(rig):
    with pytest.raises(InputError, match=r"1e\+07 steps of 1e-07 s; at most 5e\+06 are run"):
        grid(replace(rig, simulation=Simulation(1.0, 1000.0, 1e-7)))
    with pytest.raises(InputError, match=r"simulation.duration_s \(4000 s\)"):
        grid(replace(rig, simulation=Simulation(4000.0, 10.0)))
    with pytest.raises(InputError, match=r"end_stop\.stiffness_N_per_m"):
        grid(stopped(rig, 1e15))
    with pytest.raises(InputError, match=r"end_stop\.damping_N_s_per_m"):
        grid(stopped(rig, 1.0, 1e8))
    with pytest.raises(InputError, match="the parameters of viscous-friction"):
        grid(rig.with_effect(known.ViscousFriction(1e8)))
    assert grid(replace(rig, simulation=Simulation(2000.0, 10.0)))[2] == 20_001


def test_a_sweep_flies_in_long_steps_and_is_shorter_at_its_stops(rig):
    pace = pace_of(stopped(rig, 1e6))
    assert pace.frame == 2e-3
    assert pace.at_stops == pytest.approx(2.0 / (5 * np.sqrt(6 * 1e6 / MASS)))
    assert (pace.part, pace.between, pace.samples, pace.stages) == (0.35, 1e-3, 1001, 4)
    halved = pace_of(stopped(rig, 1e6), 1e-3)
    for name in ("frame", "at_stops", "part"):
        assert getattr(halved, name) == pytest.approx(getattr(pace, name) / 2), name


@pytest.mark.parametrize(("given", "taken"), [(1e-3, 1e-3), (2.5e-3, 2e-3), (0.9e-3, 0.5e-3), (0.3e-3, 0.25e-3)])
def test_a_given_step_is_shortened_to_the_rhythm_of_the_samples(rig, given, taken):
    pace = pace_of(replace(rig, simulation=Simulation(1.0, 1000.0, given)))
    assert pace.frame == pytest.approx(taken)
    assert pace.at_stops == given
    assert pace.part == pytest.approx(0.35 * min(1.0, given / 2e-3))


@pytest.mark.parametrize(("rate", "stages"), [(None, 4), (500.0, 4), (999.0, 4), (1000.0, 3), (4000.0, 3)])
def test_a_controller_that_samples_every_millisecond_has_three_stages(rig, rate, stages):
    law = Synchronise(stiffness_N_per_m=100.0, damping_N_s_per_m=5.0, force_limit_N=1.0, sample_rate_Hz=rate)
    assert pace_of(replace(rig, controller=law)).stages == stages


def test_dry_friction_of_brakes_shortens_steps_near_rest_alone(rig):
    law = Synchronise(stiffness_N_per_m=100.0, damping_N_s_per_m=5.0, force_limit_N=4.0, sample_rate_Hz=1000.0)
    pace, force, speed = pace_of(replace(rig, controller=law)), *law.dry_friction()
    assert force == 4.0
    assert pace.near_rest == pytest.approx(min(MASS / (5 * 6 * 0.125 * force / speed), 2e-3))
    assert pace.near_rest < pace.frame
    assert pace.slow == pytest.approx(3.0 * speed)
    assert pace.per_braking == pytest.approx(MASS / (6 * force))


def test_the_finest_of_paces_serves_all():
    one, other = Pace(1.0, 2.0, 0.3, 1e-3, 11, 0.5, 0.1, 7.0, 3), Pace(2.0, 1.0, 0.2, 1e-3, 11, 0.6, 0.2, 6.0, 4)
    assert finest([one, other]) == Pace(1.0, 1.0, 0.2, 1e-3, 11, 0.5, 0.2, 6.0, 4)


@pytest.mark.parametrize(
    ("rate_Hz", "delay_s", "steps"), [(1000.0, 0.002, 2), (400.0, 0.0, 2), (300.0, 0.0, 3), (700.0, 0.0, 7), (250.0, 0.0013, 10)]
)
def test_a_controllers_samples_and_commands_fall_on_steps(prototype, rate_Hz, delay_s, steps):
    law = Synchronise(stiffness_N_per_m=1000.0, damping_N_s_per_m=20.0, force_limit_N=1.0, sample_rate_Hz=rate_Hz, delay_s=delay_s)
    model = replace(prototype, controller=law, simulation=Simulation(0.5, 1000.0))
    assert grid(model)[:2] == (pytest.approx(1e-3 / steps), steps)
    assert grid(replace(model, controller=replace(law, sample_rate_Hz=1000.0 / np.pi)))[1] == 2
    coarse, fine = (deploy(replace(model, simulation=Simulation(0.5, 1000.0, step))) for step in (None, 1e-5))
    assert np.max(np.abs(coarse.channels["z_m"] - fine.channels["z_m"])) < 1e-6
