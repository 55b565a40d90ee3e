"""The six-leg platform: energy, order of the integrator, and everything that must not matter."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from measure.common.errors import InputError
from measure.tables.trajectory import CHANNELS
from simulate.deployment.deploy import deploy, deploy_many, step_of
from simulate.effects import (
    GravityImbalance,
    HandrailContact,
    JointFriction,
    LegMass,
    PulleyFriction,
    StribeckFriction,
    TransitionZone,
)
from simulate.kernel.model_rows import without_idle
from simulate.model.model import (
    Actuator,
    EndStop,
    Geometry,
    Model,
    Platform,
    Simulation,
)

LONG = Simulation(duration_s=0.6, sample_rate_Hz=250.0, step_s=5e-4)


def turned(vectors, angle):
    """Vectors turned about the vertical."""
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(vectors) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def nested(array) -> Any:
    return tuple(tuple(float(v) for v in row) for row in array)


def mapped(model, place, axial):
    """The model with `place` applied to all its places and polar vectors, and `axial` to its axial ones."""
    g, r = model.geometry, model.release
    return replace(
        model,
        geometry=replace(g, base_joints_m=nested(place(g.base_joints_m)), platform_joints_m=nested(place(g.platform_joints_m))),
        platform=replace(model.platform, centre_of_mass_m=tuple(place([model.platform.centre_of_mass_m])[0])),
        release=replace(
            r,
            position_m=tuple(place([r.position_m])[0]),
            velocity_m_per_s=tuple(place([r.velocity_m_per_s])[0]),
            theta_rad=tuple(axial([r.theta_rad])[0]),
            angular_velocity_rad_per_s=tuple(axial([r.angular_velocity_rad_per_s])[0]),
        ),
    )


def stacked(deployment):
    """Channels as position (n, 3) and rotation (n, 3)."""
    columns = np.column_stack([deployment.channels[name] for name in CHANNELS])
    return columns[:, :3], columns[:, 3:]


def relabelled(model, order):
    """The same legs under other numbers."""
    g, law = model.geometry, model.actuator
    names = ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "beta_per_m", "initial_force_N")
    picked = {name: tuple(np.broadcast_to(getattr(law, name), 6)[list(order)].tolist()) for name in names}
    joints = {name: tuple(getattr(g, name)[i] for i in order) for name in ("base_joints_m", "platform_joints_m")}
    return replace(model, geometry=replace(g, **joints), actuator=replace(law, **picked))


def test_energy_closes_over_release_stroke_stops_and_rebound_on_a_rig_without_symmetry(lopsided):
    heavy = replace(lopsided, gravity=replace(lopsided.gravity, acceleration_m_per_s2=1.0, mass_factor=1.0))
    coarse, fine = (deploy(replace(heavy, simulation=Simulation(0.6, 250.0, step))) for step in (2e-4, 1e-4))
    assert min(fine.work_J["by_stops"]) < -1e-3, "the stops were not reached"
    assert fine.energy_closure < 1e-6
    assert fine.energy_closure < coarse.energy_closure


def test_stops_and_friction_only_take_energy_out_over_a_whole_run(prototype):
    balance = deploy(prototype).work_J
    assert balance["by_stops"][-1] < 0
    assert np.all(np.diff(balance["by_effects"]) <= 1e-12)
    assert np.all(balance["by_weight"] == 0)


def test_rk4_shows_order_four_while_the_motion_is_smooth(lopsided):
    at_rest = replace(lopsided, release=replace(lopsided.release, velocity_m_per_s=(0.0,) * 3, angular_velocity_rad_per_s=(0.0,) * 3))
    ends = []
    for step in (4e-3, 2e-3, 1e-3, 1.25e-4):
        run = deploy(replace(at_rest, simulation=Simulation(0.12, 125.0, step)))
        ends.append(np.concatenate([part[-1] for part in stacked(run)]))
    errors = [np.max(np.abs(end - ends[-1])) for end in ends[:-1]]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(orders > 3.7), orders
    assert np.all(orders < 4.6), orders


@pytest.mark.parametrize("angle", [np.pi / 3, 2.0, -0.7])
def test_turning_the_world_turns_the_answer_and_leaves_theta_z_alone(lopsided, angle):
    round_body = replace(lopsided, platform=replace(lopsided.platform, inertia_kg_m2=(0.005, 0.005, 0.009)), simulation=LONG)
    place, rotation = stacked(deploy(round_body))
    place_turned, rotation_turned = stacked(deploy(mapped(round_body, lambda v: turned(v, angle), lambda v: turned(v, angle))))
    assert np.max(np.abs(place_turned - turned(place, angle))) < 1e-9
    assert np.max(np.abs(rotation_turned - turned(rotation, angle))) < 1e-9


def test_mirroring_the_rig_mirrors_the_answer(lopsided):
    model = replace(lopsided, simulation=LONG)
    mirror, axial_mirror = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
    place, rotation = stacked(deploy(model))
    seen_place, seen_rotation = stacked(deploy(mapped(model, lambda v: np.asarray(v) * mirror, lambda v: np.asarray(v) * axial_mirror)))
    assert np.max(np.abs(seen_place - place * mirror)) < 1e-9
    assert np.max(np.abs(seen_rotation - rotation * axial_mirror)) < 1e-9


def test_numbering_the_legs_otherwise_changes_nothing(lopsided):
    model = replace(lopsided, simulation=LONG)
    order = (3, 0, 5, 1, 4, 2)
    place, rotation = stacked(deploy(model))
    other_place, other_rotation = stacked(deploy(relabelled(model, order)))
    assert np.max(np.abs(other_place - place)) < 1e-9
    assert np.max(np.abs(other_rotation - rotation)) < 1e-9


def test_relabelling_the_legs_by_a_third_turn_changes_nothing_but_the_axes(prototype):
    forces = (0.06, -0.04, 0.05, -0.01, 0.04, 0.0)
    model = replace(prototype, simulation=Simulation(0.5, 250.0))
    place, rotation = stacked(deploy(replace(model, actuator=model.actuator.shifted(forces))))
    moved = forces[-2:] + forces[:-2]
    place_moved, rotation_moved = stacked(deploy(replace(model, actuator=model.actuator.shifted(moved))))
    assert np.max(np.abs(rotation[:, 2])) > 0.1
    assert np.max(np.abs(place_moved - turned(place, 2 * np.pi / 3))) < 1e-9
    assert np.max(np.abs(rotation_moved - turned(rotation, 2 * np.pi / 3))) < 1e-9


def test_a_shifted_base_shifts_the_centre_of_mass_and_nothing_else(lopsided):
    model, shift = replace(lopsided, simulation=LONG), np.array([0.3, -0.2, 0.0])
    g, centre = model.geometry, np.asarray(model.platform.centre_of_mass_m)
    moved = replace(
        model,
        geometry=replace(
            g, base_joints_m=nested(np.asarray(g.base_joints_m) + shift), platform_joints_m=nested(np.asarray(g.platform_joints_m) + shift)
        ),
        platform=replace(model.platform, centre_of_mass_m=tuple(centre + shift)),
    )
    # the platform frame moved against the platform, so the release of its origin is not that of the same material point
    one, other = deploy(replace(model, release=type(model.release)())), deploy(replace(moved, release=type(model.release)()))
    assert np.max(np.abs(one.elongation_m - other.elongation_m)) < 1e-9
    assert np.max(np.abs(stacked(one)[1] - stacked(other)[1])) < 1e-9


def test_other_units_of_length_and_mass_give_the_same_motion(lopsided):
    length, mass = 2.5, 0.3
    law, model = lopsided.actuator, replace(lopsided, effects=(), simulation=LONG)

    def times(value, factor):
        return tuple((np.asarray(value) * factor).tolist())

    g, r = model.geometry, model.release
    other = replace(
        model,
        actuator=Actuator(
            times(law.a_l_N_per_m, mass),
            times(law.b_l_N, mass * length),
            times(law.a_u_N_per_m, mass),
            times(law.b_u_N, mass * length),
            times(law.beta_per_m, 1 / length),
            times(law.initial_force_N, mass * length),
        ),
        platform=Platform(
            0.8 * mass, times(model.platform.inertia_kg_m2, mass * length**2), times(model.platform.centre_of_mass_m, length)
        ),
        geometry=Geometry(
            nested(np.asarray(g.base_joints_m) * length), nested(np.asarray(g.platform_joints_m) * length), 0.252 * length, 0.652 * length
        ),
        end_stop=EndStop(2000.0 * mass, 3.0 * mass, 1e-3 * length),
        release=replace(r, position_m=times(r.position_m, length), velocity_m_per_s=times(r.velocity_m_per_s, length)),
    )
    one, two = deploy(model), deploy(other)
    assert np.max(np.abs(two.elongation_m - length * one.elongation_m)) < 1e-9
    assert np.max(np.abs(stacked(two)[1] - stacked(one)[1])) < 1e-9


def test_theta_z_goes_on_counting_beyond_half_a_turn(prototype):
    law = prototype.actuator.shifted((0.279, -0.279, 0.279, -0.279, 0.0, 0.0))
    theta = deploy(replace(prototype, actuator=law)).channels["theta_z_rad"]
    assert np.max(np.abs(theta)) > np.pi
    assert np.max(np.abs(np.diff(theta))) < 0.1


@pytest.mark.parametrize("runs", [2, 5, 7, 19, 26])
def test_many_runs_at_once_are_the_single_runs_to_the_last_digit(prototype, runs):
    models = [replace(prototype, actuator=prototype.actuator.shifted((0.02 * i, 0, 0, -0.01 * i, 0, 0))) for i in range(runs)]
    for model, run in zip(models, deploy_many(models), strict=True):
        np.testing.assert_array_equal(deploy(model).samples, run.samples)


def test_a_run_that_goes_out_of_all_bounds_says_when_and_shows_no_number_after(prototype):
    # a million times too stiff for a step of 4 ms
    wild = replace(prototype, end_stop=EndStop(1e9, 1e5, 1e-4), simulation=Simulation(1.0, 250.0, 4e-3))
    run = deploy(wild)
    assert run.diverged_at_s is not None
    before = run.time_s < run.diverged_at_s
    assert np.all(np.isfinite(run.samples[before]))
    assert np.all(np.isnan(run.samples[~before]))
    assert 0.3 < run.diverged_at_s < 1.0


def test_a_step_that_nobody_waits_for_is_refused(prototype):
    with pytest.raises(InputError, match="steps of"):
        deploy(replace(prototype, simulation=Simulation(1.0, 1000.0, 1e-9)))


def test_a_model_without_geometry_is_refused_by_name(prototype):
    with pytest.raises(InputError, match="no \\[geometry\\]"):
        deploy(Model(actuator=prototype.actuator, name="loops only"))


def test_the_real_force_cannot_lift_the_platforms_weight_and_four_times_it_can(prototype):
    # Aridon 2009, Fig. 16: without counterweight, g = 9.81 m/s2 and 0.8 kg
    weighed = replace(prototype, gravity=replace(prototype.gravity, acceleration_m_per_s2=9.81, mass_factor=1.0))
    assert deploy(weighed).channels["z_m"].max() < 0.253
    law = weighed.actuator
    strong = replace(law, **{name: 4 * getattr(law, name) for name in ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "initial_force_N")})
    assert deploy(replace(weighed, actuator=strong)).channels["z_m"].max() > 0.65


@pytest.mark.parametrize(
    ("coded", "theta_z_deg", "tolerance"),
    [((0.1, 0, 0, 0, 0, 0), 10.25, 0.05), ((0.5, 0, 0, 0, 0, 0), 43.4, 0.1), ((1, -1, 0, 0, 0, 0), 215.4, 0.5)],
)
def test_prototype_turns_as_far_as_the_table_of_its_inference_says(prototype, coded, theta_z_deg, tolerance):
    law = prototype.actuator.shifted(tuple(0.279 * x for x in coded))
    theta = np.degrees(deploy(replace(prototype, actuator=law)).channels["theta_z_rad"])
    assert theta[np.argmax(np.abs(theta))] == pytest.approx(theta_z_deg, abs=tolerance)


def test_a_vertical_force_lifts_a_free_platform_by_half_a_t_squared(prototype):
    law = replace(prototype.actuator, a_l_N_per_m=0.0, b_l_N=0.0, a_u_N_per_m=0.0, b_u_N=0.0, initial_force_N=0.0)
    model = replace(prototype, actuator=law, effects=(GravityImbalance(2.0),), simulation=Simulation(0.3, 100.0))
    run = deploy(model)
    assert np.max(np.abs(run.channels["z_m"] - 0.252 - 0.5 * (2.0 / 1.6) * run.time_s**2)) < 1e-12


def test_the_step_follows_what_effects_make_stiff(prototype):
    assert step_of(prototype) == 5e-4
    # 1 N of dry friction eased in over 2 mm/s is a damper of 500 N s/m at rest
    assert step_of(prototype.with_effect(StribeckFriction(1.0, 0.1))) < 1.6 / (6 * 500) / 4
    assert step_of(prototype.with_effect(HandrailContact(0.02, 1e5))) < np.sqrt(1.6 / 1e5) / 4


@pytest.mark.parametrize(
    ("effect", "given_J"),
    # the rails hold the centre of mass 14.9 mm off the middle at the release, and may give back what that is worth
    [(StribeckFriction(2.0, 2.0), 0.0), (PulleyFriction(5.0), 0.0), (JointFriction(0.0, 0.5), 0.0), (HandrailContact(0.0, 1e5), 11.1)],
)
def test_the_stiffest_dry_friction_holds_still_and_makes_no_energy(lopsided, effect, given_J):
    run = deploy(replace(lopsided.with_effect(effect), simulation=Simulation(0.3, 100.0)))
    assert run.diverged_at_s is None
    assert run.energy_closure < 2e-3
    assert run.effects_J[effect.name][-1] < given_J
    assert run.effects_J["viscous-friction"][-1] < 0


def test_every_joule_of_a_deployment_is_stored_kinetic_lost_or_named(lopsided):
    heavy = replace(lopsided, gravity=replace(lopsided.gravity, acceleration_m_per_s2=1.0, mass_factor=1.0), simulation=Simulation(0.6))
    model = heavy.with_effect(GravityImbalance(0.2)).with_effect(PulleyFriction(0.1)).with_effect(JointFriction(1e-3))
    model = replace(model, platform=replace(model.platform, centre_of_mass_m=(0.0, 0.0, 0.0)))
    run = deploy(model)
    balance, lifted = run.energy_J, run.channels["z_m"] - run.channels["z_m"][0]
    named = {"by_viscous-friction", "by_gravity-imbalance", "by_pulley-friction", "by_joint-friction"}
    assert set(balance) == {"kinetic", "stored_in_strips", "stored_in_stops", "lost_in_hysteresis", "lost_in_stops", "by_weight"} | named
    held = balance["kinetic"] + balance["stored_in_strips"] + balance["stored_in_stops"]
    lost = balance["lost_in_hysteresis"] + balance["lost_in_stops"]
    assert held + lost == pytest.approx(held[0] + sum(balance[name] for name in (*named, "by_weight")), abs=1e-6)
    assert balance["by_gravity-imbalance"] == pytest.approx(0.2 * lifted, abs=1e-6)
    assert balance["by_weight"] == pytest.approx(-0.8 * lifted, abs=1e-6)
    assert all(balance[f"by_{name}-friction"][-1] < -1e-3 for name in ("viscous", "pulley", "joint"))
    assert np.all(np.diff(balance["lost_in_hysteresis"][50:]) >= -1e-9), "the law only takes energy, once it is on its lines"
    assert balance["lost_in_stops"][-1] > 0.01
    assert balance["stored_in_stops"].max() > 0.01


def test_a_leg_that_is_pushed_below_its_stowed_length_meets_a_stop_there_too(prototype):
    # pushed down with 3 J, the platform goes as far as the springs of the six lower stops and the strips take it
    law = replace(prototype.actuator, a_l_N_per_m=0.0, b_l_N=0.0, a_u_N_per_m=0.0, b_u_N=0.0, initial_force_N=0.0)
    speed = np.sqrt(2 * 3.0 / 1.6)
    pushed = replace(prototype.release, velocity_m_per_s=(0.0, 0.0, -speed))
    model = replace(prototype, actuator=law, effects=(), release=pushed, end_stop=EndStop(2e4, 0.0, 1e-3), simulation=Simulation(0.1))
    run = deploy(model)
    lowest = int(np.argmin(run.channels["z_m"]))
    u = run.elongation_m[lowest, 0]
    assert 6 * 0.5 * 2e4 * u**2 == pytest.approx(3.0, rel=0.01), "but for the first millimetre, which is eased in"
    assert run.channels["z_m"][-1] > 0.252, "a stop without damping throws it back"
    assert run.energy_J["stored_in_stops"][lowest] == pytest.approx(3.0, rel=3e-3), "it is seen a millisecond apart"


def test_the_lower_stop_of_a_leg_stands_where_the_release_holds_it(prototype):
    # held 5 mm below the stowed height: no spring is tensed, so none throws the platform up
    low = replace(prototype.release, position_m=(0.0, 0.0, -0.005))
    for stiffness in (0.0, 2e4):
        model = replace(prototype, release=low, end_stop=EndStop(stiffness, 0.0, 1e-3), simulation=Simulation(0.1))
        assert deploy(model).work_J["by_stops"][-1] == 0.0


def test_an_effect_that_is_switched_off_is_not_even_called(prototype):
    idle = (*prototype.effects, HandrailContact(), GravityImbalance(), LegMass(), TransitionZone())
    acting = without_idle([replace(prototype, effects=idle)])[0]
    assert acting.effects == prototype.effects
    np.testing.assert_array_equal(deploy(replace(prototype, effects=idle)).samples, deploy(prototype).samples)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    force=st.floats(-1e12, 1e12),
    beta=st.floats(1e-6, 1e9),
    mass=st.floats(1e-9, 1e9),
    stiffness=st.floats(0, 1e12),
    spin=st.floats(-1e6, 1e6),
    step=st.sampled_from([1e-3, 5e-4]),
)
def test_however_wild_the_parameters_no_number_is_wrong_in_silence(prototype, force, beta, mass, stiffness, spin, step):
    wild = replace(
        prototype,
        actuator=replace(prototype.actuator, b_l_N=force, initial_force_N=-force, beta_per_m=beta),
        platform=replace(prototype.platform, mass_kg=mass),
        end_stop=replace(prototype.end_stop, stiffness_N_per_m=stiffness),
        release=replace(prototype.release, angular_velocity_rad_per_s=(spin, 0.0, -spin)),
        simulation=Simulation(0.05, 200.0, step),
    )
    run = deploy(wild)
    good = len(run.time_s) if run.diverged_at_s is None else int(np.searchsorted(run.time_s, run.diverged_at_s))
    assert np.all(np.isfinite(run.samples[:good]))
    assert np.all(np.isnan(run.samples[good:]))
