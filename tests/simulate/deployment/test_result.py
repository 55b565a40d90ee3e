"""What is read off a run's samples, on samples that are made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from measure.geometry.camera import angles
from simulate.control.eddy_damper import EddyDamper
from simulate.deployment.result import Deployment, channels_of
from simulate.kernel.layout import SAMPLE_ELONGATION, SAMPLE_ENERGY, SAMPLE_FORCE, SAMPLE_POSE, SAMPLE_SIZE
from simulate.model.rig import stroke_of

TIME = np.arange(11) / 10.0


def pose_of(rotations, place=(0.0, 0.0, 0.3)):
    """Samples with these rotations at a place."""
    samples = np.zeros((len(rotations), SAMPLE_SIZE))
    samples[:, SAMPLE_POSE : SAMPLE_POSE + 3] = place
    samples[:, SAMPLE_POSE + 3 : SAMPLE_POSE + 7] = rotations.as_quat()[:, [3, 0, 1, 2]]
    return samples


def test_a_rotation_is_split_as_the_film_splits_it():
    """Turn about the vertical first, then the tilt; the film's own code is another one."""
    vectors = np.random.default_rng(0).normal(0.0, 0.7, (50, 3))
    rotations = Rotation.from_rotvec(vectors)
    found = [channels_of(pose_of(rotations[k : k + 1], vectors[k])) for k in range(50)]
    for name, column in (("theta_x_rad", 0), ("theta_y_rad", 1), ("theta_z_rad", 2)):
        expected = angles(rotations.as_matrix())[:, column]
        off = np.array([float(one[name][0]) for one in found]) - expected
        assert off - 2 * np.pi * np.round(off / (2 * np.pi)) == pytest.approx(np.zeros(50), abs=1e-9)
    for name, column in (("x_m", 0), ("y_m", 1), ("z_m", 2)):
        assert [float(one[name][0]) for one in found] == vectors[:, column].tolist()


def test_a_small_tilt_is_its_rotation_vector_and_turns_are_counted_on():
    tilted = channels_of(pose_of(Rotation.from_rotvec([[1e-10, -2e-10, 0.0], [1e-4, -2e-4, 0.0]])))
    assert tilted["theta_x_rad"] == pytest.approx([1e-10, 1e-4])
    assert tilted["theta_y_rad"] == pytest.approx([-2e-10, -2e-4])
    turns = np.linspace(0.0, 9.0, 30)
    turned = channels_of(pose_of(Rotation.from_rotvec(np.outer(turns, [0.0, 0.0, 1.0]))))
    assert turned["theta_z_rad"] == pytest.approx(turns)


def run_of(model, samples, **changed):
    return Deployment(model, TIME[: len(samples)], samples, 5e-4, **{"diverged_at_s": None, **changed})


def turning(model, theta_z_deg, elongation):
    """A run with this rotation about the vertical (n,) and elongation of all legs (n,) over their strokes."""
    samples = pose_of(Rotation.from_rotvec(np.outer(np.radians(theta_z_deg), [0.0, 0.0, 1.0])))
    samples[:, SAMPLE_ELONGATION : SAMPLE_ELONGATION + 6] = np.outer(elongation, stroke_of(model))
    return samples


def test_the_rotation_before_the_first_stop_is_the_largest_until_a_leg_reaches_it(prototype):
    samples = turning(prototype, [0.0, 4.0, -9.0, 3.0, 5.0, 30.0], [0.0, 0.3, 0.6, 0.9, 1.0, 1.0])
    samples[4, SAMPLE_ELONGATION + 2] *= 1.001
    run = run_of(prototype, samples)
    assert run.theta_z_before_stop_deg == pytest.approx(-9.0)
    assert run.summary["theta_z_deg"] == pytest.approx(30.0)
    assert run_of(prototype, samples[:2]).theta_z_before_stop_deg == pytest.approx(4.0)
    samples[0, SAMPLE_ELONGATION] = 9.0
    assert run_of(prototype, samples).theta_z_before_stop_deg is None


def test_the_full_height_is_reached_when_it_is_first_seen(prototype):
    samples = turning(prototype, np.zeros(6), np.linspace(0.0, 1.0, 6))
    full = prototype.geometry.deployed_height_m
    samples[:, SAMPLE_POSE + 2] = [0.25, 0.4, full - 1e-9, full, full + 0.01, full - 0.01]
    assert run_of(prototype, samples).time_to_full_height_s == pytest.approx(0.3)
    assert run_of(prototype, samples[:3]).time_to_full_height_s is None


def test_energy_closes_where_all_work_is_kinetic_and_by_its_largest_gap_where_not(prototype):
    samples = turning(prototype, np.zeros(5), np.zeros(5))
    work = np.array([[0.0, 1.0, 3.0, 2.0, 4.0], [0.0, 2.0, 4.0, 4.0, 8.0], [0.0, -0.5, -0.5, -1.0, -3.0], [0.0, -0.5, -0.5, -1.0, -1.0]])
    samples[:, SAMPLE_ENERGY : SAMPLE_ENERGY + 4] = (work + np.array([[0.5], [0.0], [0.0], [0.0]])).T
    assert run_of(prototype, samples).energy_closure == pytest.approx(0.0)
    samples[2, SAMPLE_ENERGY] -= 0.09
    assert run_of(prototype, samples).energy_closure == pytest.approx(0.09 / 4.5)
    samples[:, SAMPLE_ENERGY] = 0.0
    assert np.isnan(run_of(prototype, samples).energy_closure)


def test_work_and_energy_have_their_names_and_effects_of_one_name_are_added_up(prototype):
    samples = np.hstack([turning(prototype, np.zeros(3), np.zeros(3)), np.outer([0.0, 1.0, 2.0], [-0.1, -0.2, 0.4])])
    samples[:, SAMPLE_ENERGY : SAMPLE_ENERGY + 4] = [1.0, 2.0, 3.0, 4.0]
    run = run_of(prototype, samples, effects_with_power=("viscous-friction", "air-drag", "viscous-friction"))
    assert {name: values[2] for name, values in run.work_J.items()} == {
        "kinetic": 1.0, "by_legs": 2.0, "by_stops": 3.0, "by_weight": 4.0, "by_effects": pytest.approx(0.2),
    }  # fmt: skip
    assert {name: values[2] for name, values in run.effects_J.items()} == {
        "viscous-friction": pytest.approx(0.6), "air-drag": pytest.approx(-0.4),
    }  # fmt: skip


def test_forces_of_a_controller_stand_behind_the_work_of_effects(prototype):
    bare = turning(prototype, np.zeros(3), np.zeros(3))
    samples = np.hstack([bare, np.full((3, 1), 7.0), np.arange(18.0).reshape(3, 6)])
    samples[:, SAMPLE_FORCE : SAMPLE_FORCE + 6] = np.arange(6.0)
    assert np.array_equal(run_of(prototype, bare).control_force_N, np.zeros((3, 6)))
    damped = run_of(replace(prototype, controller=EddyDamper(damping_N_s_per_m=1.0)), samples, effects_with_power=("air-drag",))
    assert np.array_equal(damped.control_force_N, np.arange(18.0).reshape(3, 6))
    columns = damped.leg_columns
    stowed = columns["length_4_m"] - columns["elongation_4_m"]
    g = prototype.geometry
    apart = np.add(g.platform_joints_m[3], (0.0, 0.0, g.stowed_height_m)) - np.array(g.base_joints_m[3])
    assert stowed == pytest.approx(np.full(3, np.linalg.norm(apart)))
    assert (columns["force_4_N"][0], columns["control_4_N"][2]) == (3.0, 15.0)


def test_a_run_that_diverged_says_so(prototype):
    samples = turning(prototype, np.zeros(11), np.zeros(11))
    samples[7:] = np.nan
    run = run_of(prototype, samples, diverged_at_s=0.65)
    assert "the run diverged at 0.65 s, so nothing of it is exact" in run.summary["warnings"]
    assert repr(run) == "Deployment('prototype', 11 samples over 1 s, step 0.5 ms, diverged at 0.65 s)"
    assert repr(run_of(prototype, samples[:6])) == "Deployment('prototype', 6 samples over 0.5 s, step 0.5 ms)"
