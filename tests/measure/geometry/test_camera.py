"""The camera against OpenCV's, and the three angles of a pose: what each turns, and back again."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from measure.geometry.camera import Camera, angles, on_cylinder, rotation

X, Y, Z = np.eye(3)


@pytest.mark.parametrize(("axis", "before", "after"), [(0, Y, Z), (1, Z, X), (2, X, Y)])
def test_an_angle_turns_about_its_own_axis_by_the_right_hand(axis, before, after):
    theta = np.zeros(3)
    theta[axis] = np.pi / 2
    assert rotation(theta) @ before == pytest.approx(after, abs=1e-12)


def test_the_platform_first_turns_about_the_vertical_and_then_tilts():
    assert rotation(np.array([np.pi / 2, 0.0, np.pi / 2])) @ X == pytest.approx(Z, abs=1e-12)


def test_angles_undo_rotation():
    theta = np.random.default_rng(0).normal(0, 0.4, (20, 3))
    assert np.allclose(angles(rotation(theta)), theta, atol=1e-12)


POINTS = np.random.default_rng(1).uniform(-0.25, 0.25, (25, 3))
BENT = (0.31, -0.42, 0.013, -0.021, 0.55)


@pytest.mark.parametrize("distortion", [(), BENT])
@pytest.mark.parametrize("up_rad", [0.0, 0.35])
def test_points_are_projected_as_opencv_does(up_rad, distortion):
    """OpenCV looks along z with y down; the origin is off the axis, and the camera rolled about its axis."""
    size, distance, principal = 0.4e-3, 0.9, (300.0, 260.0)
    focal = distance / size
    origin = np.array([0.06, -0.04])
    c, s = np.cos(up_rad), np.sin(up_rad)
    # Clockwise from the picture's own: what is up in the world stands to the right of up in the picture.
    roll = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    seen = np.stack([POINTS[:, 0] + origin[0], -(POINTS[:, 2] + origin[1]), POINTS[:, 1] + distance], axis=-1) @ roll.T
    matrix = np.array([[focal, 0.0, principal[0]], [0.0, focal, principal[1]], [0.0, 0.0, 1.0]])
    expected = cv2.projectPoints(seen, np.zeros(3), np.zeros(3), matrix, np.array(distortion))[0][:, 0].astype(float)
    at_origin = roll @ [origin[0], -origin[1], distance]
    origin_px = cv2.projectPoints(at_origin[None], np.zeros(3), np.zeros(3), matrix, np.array(distortion))[0][0, 0]
    camera = Camera(size, tuple(origin_px), up_rad, distance, principal, focal, distortion)
    assert camera.project(POINTS) == pytest.approx(expected, abs=1e-6)
    assert camera.place(expected, POINTS[:, 1]) == pytest.approx(POINTS, abs=1e-9)
    assert camera.without_distortion(camera.with_distortion(expected)) == pytest.approx(expected, abs=1e-6)


def test_up_is_counted_clockwise_from_the_pictures_own():
    camera = Camera(1e-3, (50.0, 50.0), np.radians(90.0))
    assert camera.project(np.array([0.0, 0.0, 0.01])) == pytest.approx([60.0, 50.0])
    assert camera.project(np.array([0.01, 0.0, 0.0])) == pytest.approx([50.0, 60.0])


def test_without_perspective_depth_changes_nothing():
    camera = Camera(1e-3, (50.0, 50.0), 0.1)
    assert camera.project(POINTS) == pytest.approx(camera.project(POINTS * [1.0, 0.0, 1.0]))


def test_what_is_seen_of_a_cylinder_is_its_near_side():
    """Points of the near side go to the picture and come back; beside the cylinder there is none."""
    radius, camera = 0.07, Camera(0.5e-3, (152.0, 480.0), 0.05, 1.1, (160.0, 250.0))
    psi, height = np.linspace(-1.0, 1.0, 21), np.linspace(-0.1, 0.1, 21)
    points = np.stack([radius * np.sin(psi), -radius * np.cos(psi), height], axis=-1)
    assert on_cylinder(camera, camera.project(points), radius) == pytest.approx(points, abs=1e-7)
    beside = camera.project(np.array([[1.2 * radius, 0.0, 0.0], [-1.2 * radius, 0.0, 0.0]]))
    assert np.isnan(on_cylinder(camera, beside, radius)).all()


def test_a_turn_beyond_half_a_turn_is_counted_from_the_other_side():
    assert angles(rotation(np.array([0.1, -0.2, 3.5]))) == pytest.approx([0.1, -0.2, 3.5 - 2.0 * np.pi])
    assert angles(rotation(np.array([0.1, -0.2, -3.5]))) == pytest.approx([0.1, -0.2, 2.0 * np.pi - 3.5])
    assert angles(rotation(np.zeros((2, 5, 3)))).shape == (2, 5, 3)
