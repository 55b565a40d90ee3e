"""One physical claim for each effect of the catalogue, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from simulate import effects as known
from simulate.deployment.deploy import deploy
from simulate.loop import loop_force
from simulate.model.model import EndStop, Release, Simulation

FLAT = np.array([0.0, 2.79, 0.0, 2.89, 400.0])
MASS = 1.6
AMPLITUDE, OMEGA = 0.05, 2 * np.pi
TIME = np.linspace(0.0, 1.0, 20_001)
U = 0.1 + AMPLITUDE * np.sin(OMEGA * TIME)
V, A = AMPLITUDE * OMEGA * np.cos(OMEGA * TIME), -AMPLITUDE * OMEGA**2 * np.sin(OMEGA * TIME)


def added(effect, lines=FLAT):
    return loop_force(lines, TIME, U, V, A, 2.85, (effect,)) - loop_force(lines, TIME, U, V, A, 2.85)


def lost(force):
    return -np.trapezoid(force, U)


def thrown(model, velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0), position=(0.0, 0.0, 0.0)):
    return replace(model, release=Release(position, (0.0, 0.0, 0.0), velocity, spin))


def test_quadratic_hub_loss_takes_eight_thirds_of_a_cubed_omega_squared():
    loss = lost(added(known.PowerLawFriction(0.3, 2.0)))
    assert loss == pytest.approx(0.3 * 8 / 3 * AMPLITUDE**3 * OMEGA**2, rel=1e-4)


def test_power_law_friction_of_a_small_exponent_is_nearly_dry():
    force = added(known.PowerLawFriction(0.3, 0.3))
    assert lost(force) < 0.3 * 4 * AMPLITUDE
    assert force[np.argmin(np.abs(V))] == pytest.approx(0.0, abs=0.01)


def test_stribeck_friction_is_full_at_low_speed_and_gone_at_high():
    at = [added(known.StribeckFriction(0.1, 0.08))[np.argmin(np.abs(V - v))] for v in (0.01, 0.08, 0.3)]
    assert at == pytest.approx([-0.1 * np.exp(-1 / 64), -0.1 / np.e, 0.0], abs=1e-3)


def test_curved_asymptotes_are_followed_with_the_lag_of_beta():
    effect = known.CurvedAsymptotes(3.0, 10.0)
    u = np.linspace(0.0, 0.3, 3001)
    force = loop_force(FLAT, u, u, np.ones_like(u), np.zeros_like(u), 2.79, (effect,))
    slope, bend = 6 * 0.3 + 30 * 0.09, 6 + 60 * 0.3
    assert force[-1] == pytest.approx(2.79 + 3 * 0.09 + 10 * 0.027 - slope / 400 + bend / 400**2, abs=1e-6)


def test_transition_zone_misses_its_force_at_the_start_and_37_percent_of_it_one_length_on(prototype):
    effect = known.TransitionZone(0.2, 0.08)
    u = np.array([-0.01, 0.0, 0.08, 0.6])
    force = loop_force(FLAT, np.arange(4.0), u, np.ones(4), np.zeros(4), 2.79, (effect,))
    without = loop_force(FLAT, np.arange(4.0), u, np.ones(4), np.zeros(4), 2.79)
    assert force - without == pytest.approx([-0.2, -0.2, -0.2 / np.e, -0.2 * np.exp(-7.5)])
    slower, faster = (deploy(model).channels["z_m"] for model in (prototype.with_effect(effect), prototype))
    assert slower[400] < faster[400] - 1e-3


def test_relaxation_takes_its_share_of_the_force_by_the_clock_even_at_rest():
    t = np.array([0.0, 0.5, 50.0])
    force = loop_force(FLAT, t, np.full(3, 0.1), np.zeros(3), np.zeros(3), 2.8, (known.ForceRelaxation(0.2, 0.5),))
    assert force == pytest.approx([2.8, 2.8 * (1 - 0.2 * (1 - 1 / np.e)), 2.8 * 0.8])


def test_backlash_transmits_nothing_within_its_gap_after_a_reversal_and_everything_beyond():
    gap = 0.004
    force = loop_force(FLAT, TIME, U, V, A, 2.85, (known.Backlash(gap),))
    without = loop_force(FLAT, TIME, U, V, A, 2.85)
    top = int(np.argmax(U))
    travel = U[top] - U[top:15_000]
    assert np.all(force[:top] == without[:top]), "there is no play before the first reversal"
    assert np.max(np.abs(force[top:15_000][(travel > 0) & (travel < 0.9 * gap)])) < 1e-12
    np.testing.assert_array_equal(force[top:15_000][travel > gap], without[top:15_000][travel > gap])


def test_backlash_changes_no_digit_of_a_deployment_before_a_leg_turns_back(lopsided):
    # the first step starts from a length that is rounded in another way, which is no reversal
    released = replace(
        lopsided, release=Release((0.003, 0.002, 0.0), (0.02, -0.03, 0.05), (0.0, 0.0, 1.0)), simulation=Simulation(0.1, 200.0)
    )
    loose, tight = deploy(released.with_effect(known.Backlash(0.004))), deploy(released)
    assert np.all(np.diff(tight.elongation_m, axis=0) > 0), "a leg turned back, nothing was tested"
    np.testing.assert_array_equal(loose.elongation_m, tight.elongation_m)


def test_leg_mass_along_the_leg_is_hub_inertia():
    np.testing.assert_array_equal(added(known.LegMass(0.3)), added(known.HubInertia(0.3)))


def test_leg_mass_obeys_lagranges_equations_across_the_legs_too(lopsided):
    # without forces d/dt (dT/dV) = dT/dx, with T written down from the strips' velocities
    mass, law = 0.7, lopsided.actuator
    none = replace(law, a_l_N_per_m=0.0, b_l_N=0.0, a_u_N_per_m=0.0, b_u_N=0.0, initial_force_N=0.0)
    release = replace(lopsided.release, velocity_m_per_s=(0.3, -0.2, 0.4), angular_velocity_rad_per_s=(1.0, -2.0, 1.5))
    brief = Simulation(0.1, 4000.0, 1.25e-4)
    free = replace(lopsided, actuator=none, end_stop=EndStop(0.0, 0.0), release=release)
    model = replace(free, effects=(known.LegMass(mass),), simulation=brief)
    run = deploy(model)
    g = model.geometry
    centre = np.asarray(model.platform.centre_of_mass_m)
    base, joints = np.asarray(g.base_joints_m), np.asarray(g.platform_joints_m) - centre
    full = np.linalg.norm(np.add(g.platform_joints_m, (0.0, 0.0, g.deployed_height_m)) - base, axis=1)

    def strips(place, rotation, velocity, spin):
        arms = joints @ rotation.T
        legs = place + arms - base
        length = np.linalg.norm(legs, axis=1)
        axis = legs / length[:, None]
        moving = velocity + np.cross(spin, arms)
        along = np.einsum("ij,ij->i", axis, moving)
        across = moving - along[:, None] * axis
        g = mass * length / (3 * full)
        momentum = mass * along[:, None] * axis + g[:, None] * across
        return 0.5 * np.einsum("ij,ij->", momentum, moving), momentum.sum(axis=0)

    rotations = Rotation.from_quat(run.samples[:, 3:7], scalar_first=True).as_matrix()
    places = run.samples[:, :3] + rotations @ centre
    spins = run.samples[:, 10:13]
    velocities = run.samples[:, 7:10] + np.cross(spins, rotations @ centre)
    momenta = np.array([MASS * v + strips(x, R, v, w)[1] for x, R, v, w in zip(places, rotations, velocities, spins, strict=True)])
    for i in (50, 200, 350):
        rate = (momenta[i + 1] - momenta[i - 1]) * 2000.0
        steps = 1e-6 * np.eye(3)
        state = rotations[i], velocities[i], spins[i]
        gradient = [(strips(places[i] + h, *state)[0] - strips(places[i] - h, *state)[0]) / 2e-6 for h in steps]
        assert np.max(np.abs(rate)) > 0.1
        assert rate == pytest.approx(gradient, abs=2e-5)


def test_viscous_joints_stop_a_spinning_platform_exponentially(free):
    run = deploy(thrown(free, spin=(0.0, 0.0, 2.0)).with_effect(known.JointFriction(damping_N_m_s=2e-3)))
    decay = 6 * 2e-3 / (2 * 0.00297)
    assert run.channels["theta_z_rad"] == pytest.approx(2.0 / decay * (1 - np.exp(-decay * run.time_s)), abs=1e-9)


def test_dry_joints_stop_a_spinning_platform_for_good(free):
    run = deploy(thrown(free, spin=(0.0, 0.0, 2.0)).with_effect(known.JointFriction(moment_N_m=0.01)))
    stop = 2.0 * 2 * 0.00297 / (6 * 0.01)
    assert run.channels["theta_z_rad"][-1] == pytest.approx(2.0 * stop / 2, rel=0.02)
    assert abs(run.samples[-1, 12]) < 1e-3


def test_joint_friction_only_takes_energy_out(lopsided):
    work = deploy(replace(lopsided, effects=(known.JointFriction(2e-3, 5e-3),))).work_J["by_effects"]
    assert np.all(np.diff(work) < 0)


def test_a_counterweight_over_a_pulley_makes_sideways_motion_lighter_and_leaves_the_vertical(free):
    pendulum = thrown(free, position=(0.01, 0.0, 0.0)).with_effect(known.CablePendulum(40.0)).with_effect(known.GravityImbalance(1.0))
    run = deploy(pendulum.with_effect(known.CounterweightInertia(0.5)))
    assert run.channels["x_m"] == pytest.approx(0.01 * np.cos(np.sqrt(40.0 / (0.5 * MASS)) * run.time_s), abs=1e-9)
    assert run.channels["z_m"] == pytest.approx(0.252 + 0.5 / MASS * run.time_s**2, abs=1e-12)


def test_a_cable_makes_the_platform_a_pendulum(free):
    run = deploy(thrown(free, position=(0.0, 0.01, 0.0)).with_effect(known.CablePendulum(40.0)))
    assert run.channels["y_m"] == pytest.approx(0.01 * np.cos(np.sqrt(40.0 / MASS) * run.time_s), abs=1e-9)


def test_a_pulley_slows_the_vertical_motion_only(free):
    lifted = thrown(free, velocity=(0.1, 0.0, 0.0)).with_effect(known.GravityImbalance(1.0))
    run = deploy(lifted.with_effect(known.PulleyInertia(0.9)))
    assert run.channels["z_m"] == pytest.approx(0.252 + 0.5 / (MASS + 0.9) * run.time_s**2, abs=1e-12)
    assert run.channels["x_m"] == pytest.approx(0.1 * run.time_s, abs=1e-12)


def test_a_rubbing_pulley_takes_its_force_off_the_lift(free):
    run = deploy(free.with_effect(known.GravityImbalance(1.0)).with_effect(known.PulleyFriction(0.4)))
    assert run.channels["z_m"][-1] - 0.252 == pytest.approx(0.5 * 0.6 / MASS * 0.3**2, rel=0.02)


def test_air_slows_a_coasting_platform_hyperbolically(free):
    run = deploy(thrown(free, velocity=(0.0, 0.5, 0.6)).with_effect(known.AirDrag(2.0)))
    speed = np.hypot(0.5, 0.6)
    expected = speed / (1 + 2.0 * speed / MASS * run.time_s)
    assert np.linalg.norm(run.samples[:, 7:10], axis=1) == pytest.approx(expected, abs=1e-9)


def test_handrails_let_the_platform_go_as_far_as_its_energy_compresses_them_and_take_some(free):
    coasting = replace(thrown(free, velocity=(0.3, 0.0, 0.0)), simulation=Simulation(0.25, 1000.0))
    run = deploy(coasting.with_effect(known.HandrailContact(0.02, 2000.0)))
    x = run.channels["x_m"]
    assert 0.02 < x.max() <= 0.02 + 0.3 * np.sqrt(MASS / 2000.0)
    # rho lost on the way in and out: (1 - mu) / (1 + mu) of the energy comes back
    assert run.samples[-1, 7] == pytest.approx(-0.3 * np.sqrt(0.8 / 1.2), rel=0.02)


def test_a_shaking_base_is_seen_as_a_platform_that_shakes_the_other_way(free):
    a, w = 0.8, 2 * np.pi * 6.0
    run = deploy(free.with_effect(known.BaseExcitation(a, 6.0, 0.0, (0.0, 1.0, 0.0))))
    assert run.channels["y_m"] == pytest.approx(a / w**2 * np.sin(w * run.time_s) - a / w * run.time_s, abs=1e-8)


def test_a_platform_spins_about_its_centre_of_mass_wherever_that_is(free):
    d, w = np.array([0.03, 0.0, 0.0]), 2.0
    run = deploy(thrown(free, spin=(0.0, 0.0, w)).with_effect(known.CentreOfMassOffset(tuple(d))))
    angle = w * run.time_s
    assert run.channels["x_m"] == pytest.approx(0.03 * (1 - np.cos(angle)), abs=1e-9)
    assert run.channels["y_m"] == pytest.approx(0.03 * (angle - np.sin(angle)), abs=1e-9)


def test_a_rolled_camera_shows_the_elevation_sideways(prototype):
    run = deploy(prototype)
    seen = known.CameraRoll(0.02).observe(run.time_s, run.channels)
    assert np.ptp(seen["x_m"]) == pytest.approx(np.ptp(run.channels["z_m"]) * np.sin(0.02), rel=1e-6)
    rolled_back = known.CameraRoll(-0.02).observe(run.time_s, seen)
    assert rolled_back["x_m"] == pytest.approx(run.channels["x_m"], abs=1e-12)
    assert rolled_back["z_m"] == pytest.approx(run.channels["z_m"], abs=1e-12)
    assert known.CameraRoll(0.02).observe(run.time_s, {"z_m": run.channels["z_m"]})["z_m"] is run.channels["z_m"]


def test_a_late_load_cell_makes_a_loop_of_a_spring():
    spring = 30.0 * (U - 0.1)
    late = known.SensorLag(0.01).observe_force(TIME, U, spring)
    whole = slice(2000, None)
    expected = 30.0 * (AMPLITUDE * np.sin(OMEGA * (TIME[whole] - 0.01)))
    assert late[whole] == pytest.approx(expected, abs=1e-6)


def test_a_drifting_load_cell_keeps_the_loop_open_by_its_drift():
    force = known.ForceOffset(0.2, 0.05).observe_force(TIME, U, np.ones_like(TIME))
    assert force[0] == pytest.approx(1.2)
    assert force[-1] - force[0] == pytest.approx(0.05)


def test_effects_that_measure_do_not_touch_the_motion(lopsided):
    brief = replace(lopsided, simulation=Simulation(0.2, 100.0))
    measured = brief
    for effect in (
        known.CameraRoll(0.1),
        known.SensorLag(0.01),
        known.ForceOffset(1.0),
        known.ScaleError(0.1),
        known.TimeOffset(0.1),
        known.SensorFilter((0.01, 0.01)),
    ):
        measured = measured.with_effect(effect)
    np.testing.assert_array_equal(deploy(measured).samples, deploy(brief).samples)
