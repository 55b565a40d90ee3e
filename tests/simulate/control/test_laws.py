"""What each law must do by physics: brakes take energy out, held legs keep together, couplings keep energy, clutches let no leg back."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simulate.control.eddy_damper import EddyDamper
from simulate.control.mechanical_link import MechanicalLink
from simulate.control.one_way import OneWay
from simulate.control.profile import Profile
from simulate.control.synchronise import Synchronise
from simulate.deployment.deploy import deploy, deploy_many
from simulate.effects import EddyDamping, HubInertia, ViscousFriction
from simulate.model.model import Simulation
from simulate.model.rig import stroke_of
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import factors_of
from simulate.sweeps.sweep import Sweep

REAL: dict[str, Any] = {"sample_rate_Hz": 1000.0, "delay_s": 0.002, "lag_s": 0.005, "sensor_noise_m": 1e-4, "observer_Hz": 40.0}
IDEAL = Synchronise(stiffness_N_per_m=1000.0, damping_N_s_per_m=20.0, force_limit_N=1.0)
STIFF = replace(IDEAL, stiffness_N_per_m=5000.0, damping_N_s_per_m=50.0)
BRAKES = replace(IDEAL, **REAL)
EVERY = {
    "ideal": IDEAL,
    "sampled": BRAKES,
    "profile": Profile(duration_s=1.0, stiffness_N_per_m=500.0, damping_N_s_per_m=20.0, force_limit_N=5.0, **REAL),
    "one-way": OneWay(clutch_force_N=3.0),
    "eddy-damper": EddyDamper(damping_N_s_per_m=2.0, critical_speed_m_per_s=0.8),
    "link": MechanicalLink(stiffness_N_per_m=2000.0, damping_N_s_per_m=5.0, shaft_mass_kg=0.3),
}


def disparate(rig, *, controller, duration=0.5, **changes):
    law = rig.actuator.shifted((0.28, -0.28, 0.28, -0.28, 0.28, -0.28))
    return replace(rig, actuator=law, controller=controller, simulation=Simulation(duration, 1000.0), **changes)


def largest(run):
    return float(np.max(np.abs(np.degrees(run.channels["theta_z_rad"]))))


@pytest.mark.parametrize("name", EVERY)
def test_the_energy_balance_closes_with_a_controller(prototype, name):
    run = deploy(disparate(prototype, controller=EVERY[name], duration=1.0))
    assert run.energy_closure < 1e-3
    assert np.max(np.abs(run.work_J["by_effects"] - sum(run.effects_J.values()))) < 1e-12
    assert "controller" in run.effects_J


@pytest.mark.parametrize("name", ["ideal", "sampled", "profile", "one-way", "eddy-damper"])
def test_what_only_dissipates_never_adds_energy(lopsided, name):
    # let go askew and fast, noisy, late: still no sample in which the actuators have given anything
    run = deploy(replace(lopsided, controller=EVERY[name], simulation=Simulation(0.8, 1000.0)))
    given = np.diff(run.effects_J["controller"])
    assert np.max(given) <= 1e-12
    assert run.effects_J["controller"][-1] < -1e-3


def test_a_motor_can_add_energy(lopsided):
    profile = Profile(duration_s=0.3, stiffness_N_per_m=500.0, damping_N_s_per_m=20.0, force_limit_N=5.0, actuator="motor")
    run = deploy(replace(lopsided, controller=profile, simulation=Simulation(0.4, 1000.0)))
    assert np.max(run.effects_J["controller"]) > 0.1


def test_synchronised_legs_have_the_same_speed_and_the_platform_hardly_turns(prototype):
    free, held = (deploy(disparate(prototype, controller=c, duration=0.45)) for c in (None, STIFF))
    speeds = [np.diff(run.elongation_m, axis=0)[100:] / 1e-3 for run in (free, held)]
    spread = [np.max(np.ptp(v, axis=1)) for v in speeds]
    assert spread[1] < 0.05 * spread[0]
    assert largest(held) < 1.0 < 20.0 < largest(free)


def test_the_brakes_need_the_disparity_and_no_more(prototype):
    # legs 0.56 N apart: the stronger three are braked by about that, the weaker three are free
    run = deploy(disparate(prototype, controller=STIFF, duration=0.45))
    late = np.mean(run.control_force_N[200:], axis=0)
    assert late[::2] == pytest.approx([-0.56] * 3, rel=0.1)
    assert np.max(np.abs(late[1::2])) < 0.01


def test_a_limit_below_the_disparity_is_not_enough(prototype):
    assert largest(deploy(disparate(prototype, controller=replace(IDEAL, force_limit_N=0.2)))) > 15.0
    assert np.max(np.abs(deploy(disparate(prototype, controller=replace(IDEAL, force_limit_N=0.2))).control_force_N)) <= 0.2


def test_a_later_command_holds_the_legs_less_well(prototype):
    turned = [largest(deploy(disparate(prototype, controller=replace(BRAKES, sensor_noise_m=0.0, delay_s=d)))) for d in (0.0, 0.02, 0.05)]
    assert turned[0] < turned[1] < turned[2]


def test_a_profile_is_followed_and_the_stops_are_reached_slowly(prototype):
    law = Profile(duration_s=1.0, stiffness_N_per_m=5000.0, damping_N_s_per_m=50.0, force_limit_N=5.0)
    run = deploy(disparate(prototype, controller=law, duration=0.9))
    x = run.time_s / 1.0
    way = np.outer(10 * x**3 - 15 * x**4 + 6 * x**5, stroke_of(prototype))
    braked = run.time_s > 0.3
    assert np.max(np.abs(run.elongation_m - way)[braked]) < 5e-3


def test_clutches_let_no_leg_back(prototype):
    # in the rebound legs coil; clutches leave of that way what the stops' impact gives
    free, held = (deploy(disparate(prototype, controller=c, duration=1.0)) for c in (None, OneWay(clutch_force_N=50.0)))
    backwards = [np.sum(np.minimum(np.diff(run.elongation_m, axis=0), 0.0)) for run in (free, held)]
    assert backwards[0] < 5 * backwards[1] < 0.0
    gaining = held.control_force_N >= -1e-12
    assert np.all(gaining)


def test_an_eddy_damper_is_the_effect_of_the_catalogue(prototype):
    rig = replace(prototype, effects=(HubInertia(0.487), ViscousFriction(0.513)))
    controlled = deploy(disparate(rig, controller=EVERY["eddy-damper"]))
    effect = deploy(disparate(replace(rig, effects=(*rig.effects, EddyDamping(2.0, 0.8))), controller=None))
    for name, values in controlled.channels.items():
        assert values == pytest.approx(effect.channels[name], abs=1e-10)


def test_a_stiff_link_holds_the_legs_together_and_its_shaft_is_inertia(prototype):
    stiff = MechanicalLink(stiffness_N_per_m=2e4, damping_N_s_per_m=20.0)
    free, linked = (deploy(disparate(prototype, controller=c)) for c in (None, stiff))
    assert np.max(np.ptp(linked.elongation_m, axis=1)) < 0.02 * np.max(np.ptp(free.elongation_m, axis=1))
    # six equal legs moving alike: a shaft of mass m is a hub of m / 6 in each
    even = replace(prototype, controller=replace(stiff, shaft_mass_kg=0.6), simulation=Simulation(0.4, 1000.0))
    hubs = replace(prototype, effects=(HubInertia(0.487 + 0.1), ViscousFriction(0.513)), simulation=even.simulation)
    assert deploy(even).channels["z_m"] == pytest.approx(deploy(hubs).channels["z_m"], abs=1e-9)


def test_a_failed_brake_does_nothing_or_drags(prototype):
    open_, stuck = (
        deploy(disparate(prototype, controller=replace(IDEAL, failed_brake=1, stuck_force_N=f, failure_s=0.1))) for f in (0.0, 0.9)
    )
    assert np.all(open_.control_force_N[101:, 0] == 0.0)
    assert np.any(open_.control_force_N[:99, 0] < -0.1)
    assert stuck.control_force_N[250:400, 0] == pytest.approx(-0.9, rel=1e-6)


def test_noise_is_the_same_at_the_same_seed_and_another_in_each_run_of_a_sweep(prototype):
    rig = disparate(prototype, controller=replace(BRAKES, sensor_noise_m=1e-3), duration=0.3)
    one, same, other = deploy_many([rig, rig, replace(rig, controller=replace(rig.controller, seed=1))])
    assert np.array_equal(one.samples, same.samples)
    assert not np.array_equal(one.samples, other.samples)
    factors = tuple(factors_of(rig, ["platform.mass_kg=+-5%"]))
    sweep = Sweep(rig, factors, design_of("full", 1, None, 0))
    middle = np.zeros((3, 1))
    assert len(set(sweep.responses_at(middle)[:, 0])) == 3
    assert np.array_equal(sweep.responses(0, 2)[1:], sweep.responses(1, 2), equal_nan=True)  # the run decides, not the piece


def test_a_controller_that_does_nothing_changes_no_digit(prototype):
    idle = EddyDamper(damping_N_s_per_m=0.0)
    with_one, without = (deploy(disparate(prototype, controller=c)) for c in (idle, None))
    width = with_one.samples.shape[1] - without.samples.shape[1]
    assert width == 1 + 6  # its work and its forces
    assert np.array_equal(with_one.samples[:, :35], without.samples[:, :35])


def test_width_of_a_block_changes_no_digit(prototype):
    rigs = [disparate(prototype, controller=replace(BRAKES, seed=k), duration=0.2) for k in range(5)]
    together = deploy_many(rigs)
    for rig, run in zip(rigs, together, strict=True):
        assert np.array_equal(run.samples, deploy_many([rig])[0].samples)
