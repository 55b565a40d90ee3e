"""The standard deviations of a body's pose against what can be worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from measure.geometry.camera import rotation
from measure.geometry.marker_body import body_motion, width_to_length

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


BODY = np.array([[0.15, 0.02, 0.01], [-0.08, 0.11, -0.03], [-0.05, -0.1, 0.06], [0.03, -0.04, -0.05]])
BODY -= BODY.mean(axis=0)


def carried(poses, body=BODY, noise_m=0.0, seed=5):
    """Markers of a body under poses (frames, 6), with noise."""
    moved = np.einsum("kij,mj->kmi", rotation(poses[:, 3:]), body) + poses[:, None, :3]
    return moved + np.random.default_rng(seed).normal(0.0, noise_m, moved.shape)


def test_each_channel_of_a_tilted_body_scatters_as_its_sigma_says():
    poses = np.tile([0.1, -0.2, 0.3, 0.9, -0.7, 1.3], (2500, 1))
    poses[0] = 0.0
    found = body_motion(carried(poses, noise_m=1e-4))
    assert found is not None
    assert found.pose[1:].std(axis=0) / found.sigma[1:].mean(axis=0) == pytest.approx(np.ones(6), rel=0.06)
    assert found.pose[1:].mean(axis=0) - found.pose[0] == pytest.approx(poses[1], abs=1e-3)
    assert found.size_m == pytest.approx(np.sqrt(np.mean(np.sum(BODY**2, axis=1))), rel=1e-3)
    freedom = (3 * 4 - 6) / (3 * 4)
    assert np.sqrt(np.mean(found.residual_m**2)) == pytest.approx(1e-4 * np.sqrt(3.0 * freedom), rel=0.03)
    assert found.noise_m == pytest.approx(1e-4 * np.sqrt(3.0 * freedom), rel=0.03)


def test_markers_that_hide_in_turn_leave_the_pose_and_say_who_took_part():
    """Three are enough; with two there is no pose, and one that is never seen beside three others stays out."""
    poses = np.column_stack([np.linspace(0.0, 0.2, 30), np.zeros((30, 4)), np.linspace(0.0, 0.6, 30)])
    points = carried(poses, np.vstack([BODY, [[0.2, 0.2, 0.2]]]))
    points[:, 4] = np.nan
    points[3:9, 0] = np.nan
    points[9:15, 2] = np.nan
    points[20, :2] = np.nan
    points[20, 4] = 1.0
    found = body_motion(points)
    assert found is not None
    seen = np.isfinite(points[..., 0])
    assert np.array_equal(found.used, seen & (np.arange(30) != 20)[:, None] & (np.arange(5) < 4))
    assert np.array_equal(found.has_pose, np.arange(30) != 20)
    kept = found.pose[found.has_pose]
    assert kept == pytest.approx(poses[found.has_pose], abs=1e-9)
    assert np.isnan(found.sigma[20]).all()


def test_a_marker_that_slips_once_is_off_by_its_slip_and_no_noise():
    """It sits 1 mm farther out in the second half: off by half of that on the average, and no change from frame to frame but one."""
    points = carried(np.zeros((40, 6)))
    points[20:, 0] += [1e-3, 0.0, 0.0]
    found = body_motion(points)
    assert found is not None
    assert 1e-4 < found.residual_m[0] < 5e-4
    assert found.noise_m < 1e-4


def test_markers_on_a_line_and_fewer_than_three_are_no_body():
    along = np.outer([0.0, 0.1, 0.25, 0.3], [1.0, 0.5, 0.2])
    assert body_motion(carried(np.zeros((5, 6)), along)) is None
    assert body_motion(carried(np.zeros((5, 6)), BODY[:2])) is None
    assert body_motion(carried(np.zeros((5, 6)), BODY[:1])) is None
    assert body_motion(carried(np.zeros((5, 6)), BODY[:3])) is not None
    assert np.isnan(body_motion(carried(np.zeros((1, 6)), BODY[:3])).sigma).all()  # type: ignore[union-attr]


def test_the_mirror_image_of_a_body_is_not_its_rotation():
    points = carried(np.zeros((8, 6)))
    points[4:] *= [1.0, 1.0, -1.0]
    found = body_motion(points)
    assert found is not None
    assert found.residual_m.max() > 0.01


def test_points_are_as_wide_as_the_second_extent_over_the_first():
    corners = np.array([[x, y, 5.0] for x in (-2.0, 2.0) for y in (-0.5, 0.5)])
    assert width_to_length(corners) == pytest.approx(0.25)
    assert width_to_length(np.outer([0.0, 1.0, 3.0], [1.0, 2.0, 2.0])) == pytest.approx(0.0, abs=1e-12)
    assert width_to_length(np.ones((3, 3))) == 0.0
