"""The standard deviations of a body's pose against what can be worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from measure.geometry.marker_body import body_motion

SIDE_M = 0.2  # of the square that four markers are the corners of


def square_still(noise_m=1e-5, frames=40):
    """Positions (frames, 4, 3) of the markers of a square that lies still, with noise."""
    corners = np.array([[x, y, 0.0] for x in (-0.5, 0.5) for y in (-0.5, 0.5)]) * SIDE_M
    return corners + np.random.default_rng(1).normal(0.0, noise_m, (frames, 4, 3))


def test_angles_of_a_square_are_as_well_known_as_its_markers_arms_say():
    """Of a place a quarter of the variance is left; of an angle the noise's variance over the sum of the squared arms about its axis."""
    sigma = np.median(body_motion(square_still()).sigma, axis=0)  # type: ignore[union-attr]
    assert sigma[:3] == pytest.approx(sigma[0], rel=1e-3)
    assert sigma[0] == pytest.approx(1e-5 / 2.0, rel=0.1)
    across, upright = np.sqrt(4.0 * (SIDE_M / 2.0) ** 2), np.sqrt(8.0 * (SIDE_M / 2.0) ** 2)
    assert sigma[3:] == pytest.approx(2.0 * sigma[0] / np.array([across, across, upright]), rel=1e-3)


def test_a_turned_body_is_as_well_known_as_one_that_is_not():
    """About the axis of the turn the angle's error stays the same; the first frame is the one that the angles are counted from."""
    still = square_still()
    turned = np.concatenate([still[:20], still[20:] @ Rotation.from_euler("z", 1.0).as_matrix().T])
    sigma = body_motion(turned).sigma  # type: ignore[union-attr]
    assert sigma[30, 5] == pytest.approx(sigma[5, 5], rel=1e-3)


def test_a_body_that_goes_and_turns_away_from_the_origin_has_the_pose_of_its_centre():
    """Whatever the place of the first frame: shift of the centroid, and the turn about it beyond half a turn."""
    turn = np.linspace(0.0, 4.0, 30)
    way = np.stack([0.1 * turn, -0.02 * turn**2, 0.3 * turn], axis=1)
    corners = square_still(0.0, 1)[0] + [0.0, 0.01, 0.0]
    corners = corners - corners.mean(axis=0)
    moved = np.stack([corners @ Rotation.from_euler("z", a).as_matrix().T for a in turn]) + way[:, None] + [3.0, -2.0, 1.0]
    found = body_motion(moved + np.random.default_rng(2).normal(0.0, 1e-7, moved.shape))
    assert found is not None
    assert found.pose[:, :3] == pytest.approx(way, abs=1e-5)
    assert found.pose[:, 5] == pytest.approx(turn, abs=1e-5)
    assert np.abs(found.pose[:, 3:5]).max() < 1e-5


def test_in_a_few_frames_shape_and_poses_take_up_much_of_the_noise():
    """Of 36 coordinates of four markers in three frames twelve are left; on the average the sigma is right even so."""
    chance = np.random.default_rng(3)
    corners = square_still(0.0, 1)[0]
    found = [body_motion(corners + chance.normal(0.0, 1e-5, (3, 4, 3))) for _ in range(200)]
    variance = np.mean([np.median(one.sigma[:, 0]) ** 2 for one in found if one is not None])
    assert np.sqrt(variance) == pytest.approx(1e-5 / 2.0, rel=0.06)
