"""Effects that laboratories bring along (play, eddy currents, filters, lenses): one physical claim each, against closed forms."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from simulate import effects as known
from simulate.deployment.deploy import deploy
from simulate.law import steady_loop_area
from simulate.loop import loop_force
from simulate.model.model import Geometry, Gravity, Release, Simulation

FLAT = np.array([0.0, 2.79, 0.0, 2.89, 400.0])
MASS = 1.6
AMPLITUDE, OMEGA = 0.05, 2 * np.pi
TIME = np.linspace(0.0, 1.0, 20_001)
U = 0.1 + AMPLITUDE * np.sin(OMEGA * TIME)
V, A = AMPLITUDE * OMEGA * np.cos(OMEGA * TIME), -AMPLITUDE * OMEGA**2 * np.sin(OMEGA * TIME)


def test_series_play_keeps_the_force_over_its_gap_and_goes_on_from_there_as_if_the_leg_were_shorter():
    gap = 0.004
    force = loop_force(FLAT, TIME, U, V, A, 2.85, (known.SeriesPlay(gap),))
    top = int(np.argmax(U))
    travel = U[top] - U[top:15_000]
    back, within = force[top:15_000], travel < gap
    assert np.max(np.abs(back[within] - force[top])) < 1e-12
    strip = travel[~within] - gap
    assert back[~within] == pytest.approx(2.89 + (force[top] - 2.89) * np.exp(-400.0 * strip), abs=1e-12)


def test_series_play_shaves_its_gap_off_the_loop_at_both_ends():
    # -integral F du = -integral F dw - g (F_coiled - F_uncoiled), w the steady loop of the strip with a stroke less by g
    gap, time = 0.004, np.linspace(0.0, 2.0, 40_001)
    u = 0.1 + AMPLITUDE * np.sin(OMEGA * time)
    still = np.zeros_like(u)
    steady = slice(20_000, None)
    force = loop_force(FLAT, time, u, still, still, 2.85, (known.SeriesPlay(gap),))[steady]
    stroke = 2 * AMPLITUDE - gap
    expected = steady_loop_area(0.1, stroke, 400.0) - gap * 0.1 * np.tanh(stroke * 400.0 / 2)
    assert -np.trapezoid(force, u[steady]) == pytest.approx(expected, rel=1e-4)


def test_within_its_play_a_leg_is_a_constant_force(free):
    # six legs along the vertical, each R = 0.5 N until the strip follows; then its law takes over
    ring: Any = tuple((float(np.cos(a)), float(np.sin(a)), 0.0) for a in np.arange(6) * np.pi / 3)
    law = replace(free.actuator, b_l_N=0.1, b_u_N=0.9, beta_per_m=300.0, initial_force_N=0.5)
    lift = replace(free, geometry=Geometry(ring, ring), actuator=law).with_effect(known.SeriesPlay(0.02))
    z = deploy(lift).channels["z_m"] - 0.252
    free_way = 0.5 * 6 * 0.5 / MASS * deploy(lift).time_s ** 2
    inside = free_way < 0.01
    assert inside.sum() > 15
    assert z[inside] == pytest.approx(free_way[inside], abs=1e-12)
    assert np.all(z[free_way > 0.012] < free_way[free_way > 0.012])


def test_an_eddy_brake_is_viscous_at_low_speed_and_strongest_at_its_own():
    without = loop_force(FLAT, TIME, U, V, A, 2.85)
    force = loop_force(FLAT, TIME, U, V, A, 2.85, (known.EddyDamping(0.4, 0.12),)) - without
    at = [force[np.argmin(np.abs(V - v))] for v in (0.005, 0.12, 0.3)]
    assert at == pytest.approx([-0.4 * 0.005, -0.4 * 0.12 / 2, -0.4 * 0.3 / 7.25], rel=5e-3)
    # the work of a cycle: -integral F du = c v_0^2 T (1 - 1 / sqrt(1 + (v_max / v_0)^2))
    assert -np.trapezoid(force, U) == pytest.approx(0.4 * 0.12**2 * (1 - 1 / np.hypot(1, AMPLITUDE * OMEGA / 0.12)), rel=1e-6)


def test_an_eddy_brake_lets_a_fast_platform_coast_and_stops_a_slow_one(free):
    # m V' = -6 c V / (1 + (V / v_0)^2), so ln V + V^2 / (2 v_0^2) falls by 6 c / m each second
    ring: Any = tuple((float(np.cos(a)), float(np.sin(a)), 0.0) for a in np.arange(6) * np.pi / 3)
    lift = replace(free, geometry=Geometry(ring, ring), release=Release(velocity_m_per_s=(0.0, 0.0, 0.25)))
    run = deploy(lift.with_effect(known.EddyDamping(1.5, 0.12)))
    speed = run.samples[:, 9]
    fallen = np.log(speed) + speed**2 / (2 * 0.12**2)
    assert speed[-1] < 0.2
    assert fallen - fallen[0] == pytest.approx(-6 * 1.5 / MASS * run.time_s, abs=1e-7)
    assert np.all(np.diff(run.work_J["by_effects"]) < 0)


def test_a_ripple_gives_back_over_a_cycle_what_it_takes():
    without = loop_force(FLAT, TIME, U, V, A, 2.85)
    wave = loop_force(FLAT, TIME, U, V, A, 2.85, (known.Ripple(0.02, 0.03, 0.7),)) - without
    assert wave == pytest.approx(0.02 * np.sin(2 * np.pi * U / 0.03 + 0.7), abs=1e-12)
    assert np.trapezoid(wave, U) == pytest.approx(0.0, abs=1e-9)


def test_a_platform_runs_over_a_ripple_as_over_hills_of_energy(free):
    # m V^2 / 2 - 6 integral F du is kept
    ring: Any = tuple((float(np.cos(a)), float(np.sin(a)), 0.0) for a in np.arange(6) * np.pi / 3)
    lift = replace(free, geometry=Geometry(ring, ring), release=Release(velocity_m_per_s=(0.0, 0.0, 0.3)))
    run = deploy(lift.with_effect(known.Ripple(0.2, 0.02, 0.7)))
    u = run.channels["z_m"] - 0.252
    hill = 6 * 0.2 * 0.02 / (2 * np.pi) * (np.cos(2 * np.pi * u / 0.02 + 0.7) - np.cos(0.7))
    energy = 0.5 * MASS * (run.samples[:, 9] ** 2 - 0.3**2)
    assert np.ptp(hill) > 5e-3
    assert energy == pytest.approx(-hill, abs=1e-7)


def test_a_slow_load_cell_shows_a_sine_smaller_and_later_as_a_low_pass_does():
    tau = 0.03
    shown = known.SensorFilter((tau, 0.0)).observe_force(TIME, U, np.sin(OMEGA * TIME))
    transient = OMEGA * tau * np.exp(-TIME / tau)
    expected = (np.sin(OMEGA * TIME) - OMEGA * tau * np.cos(OMEGA * TIME) + transient) / (1 + (OMEGA * tau) ** 2)
    assert shown == pytest.approx(expected, abs=1e-9)


def test_a_slow_camera_lags_behind_a_coasting_platform_by_speed_times_time_constant_whatever_its_frame_rate(free):
    tau, speed = 0.02, 0.3
    run = deploy(replace(free, release=Release(velocity_m_per_s=(0.0, speed, 0.0))))
    for every in (1, 2, 7):
        time, y = run.time_s[::every], run.channels["y_m"][::every]
        shown = known.SensorFilter((0.0, tau)).observe(time, {"y_m": y})["y_m"]
        assert shown == pytest.approx(speed * (time - tau * (1 - np.exp(-time / tau))), abs=1e-12)


def test_a_slow_camera_shows_of_channels_together_what_it_shows_of_each_by_itself():
    chance, time = np.random.default_rng(3), np.cumsum(np.random.default_rng(4).uniform(0.5e-3, 2e-3, 60))
    channels = {name: np.cumsum(chance.normal(size=60)) for name in ("x_m", "y_m", "z_m", "theta_z_rad")}
    slow = known.SensorFilter((0.0, 4e-3))
    together = slow.observe(time, channels)
    assert list(together) == list(channels)
    for name, values in channels.items():
        np.testing.assert_array_equal(together[name], slow.observe(time, {name: values})[name])
        assert np.ptp(together[name] - values) > 0.1


def test_what_a_slow_camera_shows_of_a_run_that_diverged_ends_where_the_run_does():
    time, x = np.arange(8) * 0.01, np.array([0.0, 1.0, 2.0, 3.0, 4.0, np.nan, np.nan, np.nan])
    shown = known.SensorFilter((0.0, 1e-3)).observe(time, {"x_m": x})["x_m"]
    np.testing.assert_array_equal(np.isfinite(shown), np.isfinite(x))


def test_a_lens_distorts_as_browns_first_coefficient_does_in_another_camera_model():
    distance, k1, height = 2.5, -0.3, 0.45
    x, z = np.array([-0.15, 0.0, 0.02, 0.2]), np.array([0.25, 0.45, 0.3, 0.7])
    points = np.stack([x, z - height, np.full(4, distance)], axis=1)
    camera = np.diag([distance, distance, 1.0])
    theirs = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera, np.array([k1, 0.0, 0.0, 0.0]))[0].reshape(-1, 2)
    seen = known.LensDistortion(k1 / distance**2, height).observe(np.arange(4.0), {"x_m": x, "z_m": z})
    assert np.stack([seen["x_m"], seen["z_m"] - height], axis=1) == pytest.approx(theirs, abs=1e-12)


def test_a_lens_leaves_rotations_and_its_axis_alone_and_takes_the_elevation_as_it_is_where_nothing_else_is_seen():
    z = np.array([0.25, 0.45, 0.65])
    seen = known.LensDistortion(0.5, 0.45).observe(np.arange(3.0), {"z_m": z, "theta_z_rad": z})
    assert seen["theta_z_rad"] is z
    assert seen["z_m"] - z == pytest.approx([-0.5 * 0.2**3, 0.0, 0.5 * 0.2**3])


def on_vertical_legs(free, force_N):
    """A platform that six vertical legs of constant force lift from the base, without weight."""
    ring: Any = tuple((float(np.cos(a)), float(np.sin(a)), 0.0) for a in np.arange(6) * np.pi / 3)
    law = replace(free.actuator, b_l_N=force_N, b_u_N=force_N, initial_force_N=force_N)
    return replace(free, geometry=Geometry(ring, ring), actuator=law)


def test_a_base_on_springs_swings_at_its_own_frequency_under_the_step_of_the_legs_force(free):
    # hubs of h in each leg: M z'' = 6 F - 6 h (z'' - s''), so the base swings with m + 6 h M / (M + 6 h) under 6 F M / (M + 6 h)
    force, hub, mass, frequency, zeta = 0.5, 0.1, 3.0, 7.0, 0.06
    lift = on_vertical_legs(free, force).with_effect(known.HubInertia(hub))
    run = deploy(lift.with_effect(known.FlexibleBase(mass, frequency, zeta)))
    share = MASS / (MASS + 6 * hub)
    swinging, omega = mass + 6 * hub * share, 2 * np.pi * frequency
    stiffness, damping = mass * omega**2, 2 * zeta * omega * mass
    decay, still = damping / (2 * swinging), -6 * force * share / stiffness
    turning = np.sqrt(stiffness / swinging - decay**2)
    t = run.time_s
    base = still * (1 - np.exp(-decay * t) * (np.cos(turning * t) + decay / turning * np.sin(turning * t)))
    # (M + 6 h) z'' = 6 F + 6 h s''
    z = 0.252 + (0.5 * 6 * force * t**2 + 6 * hub * base) / (MASS + 6 * hub)
    assert np.ptp(base) > 2e-4
    assert run.channels["z_m"] == pytest.approx(z, abs=1e-9)
    assert run.elongation_m[:, 0] == pytest.approx(z - base - 0.252, abs=1e-9)
    assert run.energy_closure < 1e-8
    assert run.effects_J["flexible-base"][-1] < 0.0


def test_a_platform_that_rests_on_its_legs_leaves_the_base_where_it_is(free):
    # the springs carry the weight beforehand: 6 F = M g moves nothing, and a lighter base moves no more than a heavy one
    resting = replace(on_vertical_legs(free, 0.8 * 9.81 / 6), gravity=Gravity(9.81, 1.0))
    run = deploy(resting.with_effect(known.FlexibleBase(0.5, 5.0, 0.0)))
    assert np.max(np.abs(run.channels["z_m"] - 0.252)) < 1e-12


def test_a_base_that_is_heavy_or_stiff_is_rigid(lopsided):
    brief = replace(lopsided, simulation=Simulation(0.3, 200.0, 2e-5))
    rigid = deploy(brief).channels["z_m"]
    apart = [
        np.ptp(deploy(brief.with_effect(known.FlexibleBase(m, f, 0.1))).channels["z_m"] - rigid) for m, f in ((2e3, 5.0), (50.0, 100.0))
    ]
    near = np.ptp(deploy(brief.with_effect(known.FlexibleBase(2.0, 5.0, 0.1))).channels["z_m"] - rigid)
    assert max(apart) < 1e-2 * near
