"""The condition of the legs against rigs whose singular poses are known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from simulate.deployment.deploy import deploy
from simulate.deployment.legs_condition import condition_along, condition_of, legs_jacobian, singular_theta_z_deg
from simulate.kernel.layout import SAMPLE_POSE
from simulate.model.model import Geometry
from simulate.model.model import Simulation as Simulated

BASE_DEG, PLATFORM_DEG = np.array([0, 120, 120, 240, 240, 360]), np.repeat([60.0, 180.0, 300.0], 2)


def ring(radius, angles_deg) -> Any:
    turned = np.radians(angles_deg)
    return tuple((radius * float(np.cos(a)), radius * float(np.sin(a)), 0.0) for a in turned)


def octahedral(base_m=0.5, platform_m=0.2, turn_deg=60.0):
    """Three pairs of legs that meet on the base, and on the platform with the next: the simplest Stewart platform."""
    return Geometry(ring(base_m, BASE_DEG), ring(platform_m, PLATFORM_DEG - 60.0 + turn_deg), 0.3, 0.7)


@pytest.mark.parametrize("height", [0.3, 0.7])
def test_a_symmetric_platform_loses_a_direction_when_it_is_turned_by_90_degrees(height):
    # Fichter 1986
    assert singular_theta_z_deg(octahedral(), height) == pytest.approx((-90.0, 90.0), abs=1e-6)


def test_turned_platform_joints_move_the_singular_rotations_by_as_much():
    assert singular_theta_z_deg(octahedral(turn_deg=80.0), 0.5) == pytest.approx((-110.0, 70.0), abs=1e-6)


@pytest.mark.parametrize("height", [0.3, 0.6])
def test_on_a_rig_without_symmetry_the_nearest_rotations_are_where_the_lines_of_the_legs_lose_a_direction(lopsided, height):
    """By the determinant of the six lines (n, r x n), written down anew, with the platform centred."""
    joints, base = np.asarray(lopsided.geometry.platform_joints_m), np.asarray(lopsided.geometry.base_joints_m)

    def volume(turn_deg):
        arms = Rotation.from_euler("z", turn_deg, degrees=True).apply(joints)
        along = arms + np.array([0.0, 0.0, height]) - base
        n = along / np.linalg.norm(along, axis=1)[:, None]
        return np.linalg.det(np.hstack([n, np.cross(arms, n)]))

    for found, side in zip(singular_theta_z_deg(lopsided.geometry, height), (-1.0, 1.0), strict=True):
        assert found is not None
        assert volume(found - 1e-4) * volume(found + 1e-4) < 0.0
        nearer = np.sign([volume(side * turn) for turn in np.linspace(0.0, abs(found) - 1e-4, 60)])
        assert np.ptp(nearer) == 0.0


def test_the_condition_is_infinite_in_a_singular_pose_and_grows_towards_it():
    geometry = octahedral()
    turns = np.radians([0.0, 45.0, 80.0, 89.0, 90.0])
    rotation = np.array([[[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]] for a in turns])
    found = condition_of(legs_jacobian(geometry, np.tile([0.0, 0.0, 0.5], (5, 1)), rotation))
    assert np.all(np.diff(found[:4]) > 0.0)
    assert found[3] > 10 * found[0]
    assert found[4] > 1e9


def test_rows_of_the_jacobian_move_the_legs():
    geometry, rng = octahedral(), np.random.default_rng(0)
    place, step = np.array([[0.02, -0.03, 0.5]]), 1e-6
    velocity, spin = rng.normal(size=3), rng.normal(size=3)
    joints, base = np.asarray(geometry.platform_joints_m), np.asarray(geometry.base_joints_m)

    def lengths(by):
        turned = joints + by * np.cross(spin, joints)
        return np.linalg.norm(place + by * velocity + turned - base, axis=1)

    arm = np.sqrt(np.mean(np.sum(joints**2, axis=1)))
    rates = legs_jacobian(geometry, place, np.eye(3)[None])[0] @ np.concatenate([velocity, arm * spin])
    assert rates == pytest.approx((lengths(step) - lengths(-step)) / (2 * step), abs=1e-8)


def test_directions_that_are_held_alike_have_condition_one():
    assert condition_of(np.linalg.qr(np.random.default_rng(1).normal(size=(4, 6, 6)))[0]) == pytest.approx(np.ones(4))


def test_condition_knows_neither_the_unit_of_length_nor_how_the_world_is_turned():
    geometry = octahedral()
    base, platform = (ring(1000.0 * radius, angles) for radius, angles in ((0.5, BASE_DEG), (0.2, PLATFORM_DEG)))
    larger = Geometry(base, platform, 300.0, 700.0)
    small, large = (
        condition_of(legs_jacobian(g, np.array([[0.0, 0.0, height]]), np.eye(3)[None])) for g, height in ((geometry, 0.4), (larger, 400.0))
    )
    assert small == pytest.approx(large, rel=1e-12)


def test_a_deployment_says_how_well_its_legs_hold_it(prototype):
    askew = replace(
        prototype,
        actuator=prototype.actuator.shifted((0.28, -0.28, 0.28, -0.28, 0.28, -0.28)),
        simulation=Simulated(1.0, 250.0),
    )
    run = deploy(askew)
    along = condition_along(askew, run.samples)
    report = run.summary["legs_condition"]
    assert report["largest"] == pytest.approx(along.max())
    assert report["at_release"] == pytest.approx(1.4995, abs=1e-3)
    assert report["singular_theta_z_deg"]["deployed"] == pytest.approx((-90.0, 90.0), abs=1e-6)
    # the worst moment is where the platform passes through a quarter turn, or three of them
    theta = np.degrees(run.channels["theta_z_rad"])
    assert np.abs(theta).max() > 120.0
    assert abs(abs(theta[np.argmax(along)]) % 180.0 - 90.0) < 8.0
    broken = run.samples.copy()
    broken[100:, SAMPLE_POSE:] = np.nan
    assert np.isnan(condition_along(askew, broken)[100:]).all()
