"""The base parameters: what is worked out of them, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.model.model import EndStop, Gravity, Platform, Release, Simulation, leg_lengths, longest_arm, per_leg, stroke_of
from simulate.model.radii import radius_of, with_radius
from simulate.model.rig import Covariance, Nuisance, Rate, Rig, altered, geometry_of


def test_a_number_serves_all_legs():
    assert per_leg(2.5).tolist() == [2.5] * 6
    assert per_leg((1.0, 2.0, 3.0, 4.0, 5.0, 6.0)).tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


def test_legs_are_as_long_as_their_joints_are_apart(lopsided):
    g = lopsided.geometry
    base, joints = np.array(g.base_joints_m), np.array(g.platform_joints_m)
    expected = [[np.linalg.norm(joints[i] + [0, 0, h] - base[i]) for i in range(6)] for h in (g.stowed_height_m, g.deployed_height_m)]
    assert leg_lengths(base, joints, g.stowed_height_m) == pytest.approx(expected[0])
    assert stroke_of(lopsided) == pytest.approx(np.subtract(expected[1], expected[0]))
    assert longest_arm(lopsided) == pytest.approx(max(np.linalg.norm(joint) for joint in joints))


def test_a_rig_without_a_geometry_is_good_for_loops_only(prototype):
    bare = Rig(actuator=prototype.actuator, name="bare")
    assert longest_arm(bare) == 0.0
    with pytest.raises(InputError, match=r'model "bare": no \[geometry\] table'):
        geometry_of(bare)


def test_what_moves_is_the_platform_times_what_the_counterweight_makes_of_it(prototype):
    heavy = Rig(actuator=prototype.actuator, platform=Platform(0.7), gravity=Gravity(9.81, 1.5))
    assert heavy.moving_mass_kg == pytest.approx(1.05)
    assert Rig(actuator=prototype.actuator).moving_mass_kg == pytest.approx(1.6)


def test_forces_are_shifted_leg_by_leg_and_slopes_stay(lopsided):
    by = (0.1, -0.2, 0.3, 0.0, 0.5, -0.6)
    moved, law = lopsided.actuator.shifted(by), lopsided.actuator
    for name in ("b_l_N", "b_u_N", "initial_force_N"):
        assert per_leg(getattr(moved, name)) - per_leg(getattr(law, name)) == pytest.approx(by)
    assert (moved.a_l_N_per_m, moved.beta_per_m) == (law.a_l_N_per_m, law.beta_per_m)
    assert altered(law, b_l_N=7.0).b_l_N == 7.0


def test_the_speed_of_a_loop_is_two_pi_times_its_frequency_and_amplitude():
    f, stroke = (0.5, 1.0, 2.0), (0.1, 0.1, 0.1)
    speeds = tuple(np.pi * one * both for one, both in zip(f, stroke, strict=True))
    assert Rate("frequency_Hz", frequency_Hz=f, mid_stroke_speed_m_per_s=speeds).speed_per_Hz == pytest.approx(np.pi * 0.1)
    assert Rate("frequency_Hz", stroke_m=(0.1, 0.3)).speed_per_Hz == pytest.approx(np.pi * 0.2)
    assert Rate("frequency_Hz").speed_per_Hz is None
    unequal = Rate("frequency_Hz", frequency_Hz=(1.0, 2.0), mid_stroke_speed_m_per_s=(0.3, 0.4)).speed_per_Hz
    assert unequal == pytest.approx((0.3 + 0.8) / 5.0)
    with pytest.raises(ValueError, match="one number for each loop"):
        Rate("frequency_Hz", frequency_Hz=f, stroke_m=(0.1,))


def test_a_covariance_is_square_symmetric_and_has_a_name_for_each_row():
    assert Covariance(("a", "b"), ((1.0, 0.5), (0.5, 2.0))).names == ("a", "b")
    with pytest.raises(ValueError, match="must be 2 x 2"):
        Covariance(("a", "b"), ((1.0,),))
    with pytest.raises(ValueError, match="must be symmetric"):
        Covariance(("a", "b"), ((1.0, 0.5), (0.4, 2.0)))


def test_a_radius_is_the_mean_distance_from_the_vertical_and_moves_a_ring_at_its_height(lopsided):
    g = lopsided.geometry
    points = np.array(g.base_joints_m)
    assert radius_of(g, "base_joints_m") == pytest.approx(np.mean(np.sqrt(points[:, 0] ** 2 + points[:, 1] ** 2)))
    wider = with_radius(g, "base_joints_m", 0.9)
    assert radius_of(wider, "base_joints_m") == pytest.approx(0.9)
    moved = np.array(wider.base_joints_m)
    assert moved[:, 2] == pytest.approx(points[:, 2])
    assert np.arctan2(moved[:, 1], moved[:, 0]) == pytest.approx(np.arctan2(points[:, 1], points[:, 0]))
    assert wider.platform_joints_m == g.platform_joints_m
    with pytest.raises(ValueError, match="must be above zero"):
        with_radius(g, "base_joints_m", 0.0)


def test_what_a_model_file_leaves_out_is_what_its_format_states():
    """Files are written by people who rely on it."""
    assert vars(Platform()) == {"mass_kg": 0.8, "inertia_kg_m2": (0.006, 0.006, 0.010), "centre_of_mass_m": (0.0, 0.0, 0.0)}
    assert vars(EndStop()) == {"stiffness_N_per_m": 2.0e4, "damping_N_s_per_m": 40.0, "smoothing_m": 1e-3}
    assert vars(Gravity()) == {"acceleration_m_per_s2": 0.0, "mass_factor": 2.0}
    assert vars(Simulation()) == {"duration_s": 1.0, "sample_rate_Hz": 1000.0, "step_s": None}
    assert set(vars(Release()).values()) == {(0.0, 0.0, 0.0)}
    assert vars(Nuisance()) == {
        "release_position_m": 0.001, "release_theta_rad": 0.002, "release_instant_s": 0.004, "stored_force_N": 0.0,
        "stored_force_percent": 0.5, "platform_mass_percent": 0.5, "inertia_percent": 5.0, "centre_of_mass_m": 0.0005, "joints_m": 0.0003,
        "end_stop_percent": 30.0, "camera_scale_percent": 0.0,
    }  # fmt: skip
