"""Marks to one rigid body, against made footage and exact geometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from measure.correlation.marks import OK, Marks
from measure.correlation.shape_function_bias import EVEN, NODES, Response
from measure.film.track import track
from measure.footage.footage import from_array
from measure.geometry.body import Body, body_points
from measure.geometry.camera import Camera, on_cylinder, rotation
from measure.geometry.film_project import MarkList
from measure.geometry.rigid_body import (
    CYLINDER,
    PERSPECTIVE,
    PLANE,
    fit_platform,
    trajectory,
)
from measure.geometry.scale import camera_of, picture_scale
from measure.synthetic.made_film import pictures, project_for, true_motion
from measure.tables.trajectory import CHANNELS

CAMERA = Camera(0.5e-3, (100.0, 400.0), np.radians(3.0), 2.5, (160.0, 240.0))


def even_response(reference_px, subset):
    """The response of marks whose texture is the same everywhere."""
    nodes = reference_px[:, None] + subset / 2 * NODES
    return Response(
        reference_px,
        nodes,
        np.broadcast_to(EVEN, (len(nodes), 9, 2, 2)),
        np.full(len(nodes), 6),
        np.broadcast_to(np.eye(4), (len(nodes), 4, 4)),
    )


def _still(places, subset=31):
    """Marks in a single frame."""
    count = len(places)
    x, y = places.T[:, None]
    none = np.zeros((1, count))
    return Marks(
        np.zeros(1), [""] * count, even_response(places, subset), x, y, np.zeros((1, count, 2, 2)), none, none, np.full((1, count), OK)
    )


def _seen(camera, points, pose, response, sigma=0.005):
    """Exact sightings of body points (n, 9, 3) under poses (t, 6)."""
    at = Body(camera, points, response).project(pose)
    n = at.shape[:2]
    covariance = np.broadcast_to(sigma**2 * np.eye(2), (*n, 2, 2)).copy()
    names = [f"m{i}" for i in range(n[1])]
    return Marks(np.arange(n[0]) / 250, names, response, at[..., 0], at[..., 1], covariance, np.ones(n), np.zeros(n), np.full(n, OK))


def test_projection_and_its_inverse_agree():
    points = np.random.default_rng(0).normal(0, 0.05, (20, 3))
    assert np.allclose(CAMERA.place(CAMERA.project(points), points[:, 1]), points, atol=1e-12)


def test_points_on_the_cylinder_are_on_the_cylinder():
    points = on_cylinder(CAMERA, np.array([[60.0, 380.0], [100.0, 400.0], [170.0, 420.0]]), 0.06)
    assert np.allclose(np.hypot(points[:, 0], points[:, 1]), 0.06, atol=1e-12)
    assert (points[:, 1] < 0).all()


def test_positive_roll_turns_the_vertical_towards_the_right_of_the_picture():
    turned = rotation(np.array([0.0, 0.3, 0.0])) @ [0.0, 0.0, 1.0]
    assert turned[0] > 0
    assert np.allclose(turned[1], 0)


@pytest.mark.parametrize("free", [PLANE, CYLINDER, PERSPECTIVE])
def test_an_exact_picture_gives_the_exact_pose(free):
    reference = np.array([[60.0, 380.0], [100.0, 380.0], [170.0, 385.0], [62.0, 420.0], [101.0, 424.0], [165.0, 420.0]])
    radius = None if free is PLANE else 0.06
    camera = Camera(0.5e-3, (100.0, 400.0)) if free is PLANE else CAMERA
    still = _still(reference)
    points = body_points(still, camera, radius)
    pose = np.zeros((5, 6))
    channels = ("x_m", "y_m", "z_m", "theta_x_rad", "theta_y_rad", "theta_z_rad")
    for i, c in enumerate(channels):
        if c in free:
            pose[1:, i] = np.random.default_rng(i).normal(0, 0.05, 4)
    marks = _seen(camera, points, pose, still.response)
    fit = fit_platform(marks, camera, points, free)
    assert np.abs(fit.pose - pose).max() < 1e-7


def test_one_mark_that_slipped_is_left_out():
    at = np.array([[40, 350], [160, 350], [40, 450], [160, 450], [100, 330.0]])
    camera = Camera(0.5e-3, (100.0, 400.0))
    still = _still(at)
    points = body_points(still, camera, None)
    pose = np.array([[0, 0, 0, 0, 0, 0], [0.01, 0, 0.02, 0, 0.1, 0.0]])
    marks = _seen(camera, points, pose, still.response)
    marks.x_px[1, 2] += 3.0
    fit = fit_platform(marks, camera, points, PLANE)
    assert list(fit.used[1]) == [True, True, False, True, True]
    assert np.abs(fit.pose - pose).max() < 1e-7
    assert trajectory(marks, fit, 0.252).status[1] == "partial"


SQUARE = np.array([[40, 350], [160, 350], [40, 450], [160, 450.0]])


def _square(frames=3, sigma=0.02, pose=(0.01, 0.0, 0.02, 0.0, 0.1, 0.0)):
    """Exact sightings of the corners of a square in the plane about its middle; the first frame is the reference."""
    camera, still = Camera(0.5e-3, (100.0, 400.0)), _still(SQUARE)
    points = body_points(still, camera, None)
    return camera, points, _seen(camera, points, np.outer(np.arange(frames) > 0, pose), still.response, sigma)


def test_a_pose_is_as_well_known_as_the_squares_arms_say():
    """Shift: one standard deviation over the root of four; angle: over the root of the arms' squares."""
    camera, points, marks = _square()
    sigma = np.sqrt(np.diagonal(fit_platform(marks, camera, points, PLANE).covariance[1]))
    one = 0.02
    across = np.hypot(*(SQUARE - [100.0, 400.0]).T)
    assert sigma[:2] == pytest.approx(np.full(2, 0.5e-3 * one / 2.0), rel=0.02)
    assert sigma[2] == pytest.approx(one / np.sqrt(np.sum(across**2)), rel=0.02)


def test_a_mark_counts_by_its_own_standard_deviation():
    """One of four is off by a little and known three times worse than the others: a weighted mean."""
    camera, points, marks = _square(pose=(0.0,) * 6)
    marks.covariance_px2[:] *= np.array([9.0, 1.0, 1.0, 1.0])[:, None, None] * 1e4
    marks.x_px[1] += 0.3
    marks.x_px[1, 0] += 0.7
    found = fit_platform(marks, camera, points, ("x_m",)).pose[1, 0]
    assert found == pytest.approx(0.5e-3 * (0.3 + 0.7 / 9.0 / (3.0 + 1.0 / 9.0)), rel=1e-3)


def test_the_residual_of_a_mark_is_over_the_frames_in_which_it_took_part():
    camera, points, marks = _square()
    fit = fit_platform(marks, camera, points, PLANE)
    residual = np.zeros((3, 4, 2))
    residual[:, 0] = [[3.0, 0.0], [0.0, 4.0], [0.0, 0.0]]
    residual[2, 1] = [0.6, 0.8]
    used = np.ones((3, 4), bool)
    used[:2, 1] = used[:, 2] = False
    found = replace(fit, residual_px=residual, used=used).mark_residual_px
    assert found == pytest.approx([np.sqrt(25.0 / 3.0), 1.0, np.nan, 0.0], nan_ok=True)


def test_two_marks_that_contradict_each_other_are_both_kept_and_three_marks_lose_the_wrong_one():
    camera, points, marks = _square()
    gone = np.zeros((3, 4), bool)
    gone[1, 2:] = True
    gone[2, 3] = True
    marks.x_px[1, 0] += 5.0
    marks.x_px[2, 0] += 5.0
    fit = fit_platform(marks.without(gone, "lost"), camera, points, ("x_m", "z_m"))
    assert fit.used.tolist() == [[True] * 4, [True, True, False, False], [True, True, True, False]]


def test_every_frame_says_how_it_was_seen():
    camera, points, marks = _square(frames=5)
    for frame, which, why in ((1, [0], "lost"), (2, [0, 1, 2], "occluded"), (3, [0, 1, 2, 3], "missing")):
        gone = np.zeros((5, 4), bool)
        gone[frame, which] = True
        marks = marks.without(gone, why)
    table = trajectory(marks, fit_platform(marks, camera, points, PLANE), 0.252)
    assert table.status == ["ok", "partial", "lost", "missing", "ok"]
    assert table.channels["z_m"] == pytest.approx([0.252, 0.272, np.nan, np.nan, 0.272], nan_ok=True)
    assert table.channels["x_m"] == pytest.approx([0.0, 0.01, np.nan, np.nan, 0.01], nan_ok=True, abs=1e-9)
    assert table.sigma["theta_y_rad"][1] > table.sigma["theta_y_rad"][4] > 0.0


def _tracked(rig, seed=1, **changed):
    motion, scene = rig(**changed)
    truth = true_motion(motion, scene, 100.0)
    film = from_array(np.array(list(pictures(motion, scene, fps=100.0, seed=seed))))
    tracked = track(film, project_for(scene, 100.0, 0.252))
    assert tracked.summary["verdict"] == "ok"
    assert tracked.trajectory is not None
    return tracked.trajectory, truth.trajectory


def test_the_made_rig_comes_back_within_hundredths_of_a_millimetre(rig):
    seen, truth = _tracked(rig)
    for channel, limit in (("x_m", 5e-5), ("z_m", 5e-5), ("theta_y_rad", 5e-4)):
        gap = seen.channels[channel] - truth.channels[channel]
        assert np.abs(gap).max() < limit, channel


def test_rotation_about_the_vertical_is_read_from_one_camera_to_thirty_degrees(rig):
    seen, truth = _tracked(rig, theta_z=np.radians(30.0))
    gap = seen.channels["theta_z_rad"] - truth.channels["theta_z_rad"]
    assert np.degrees(np.abs(gap).max()) < 0.05
    assert np.degrees(np.median(seen.sigma["theta_z_rad"])) < 0.05
    assert np.abs(seen.channels["x_m"] - truth.channels["x_m"]).max() < 4e-5


@pytest.mark.calibrate
def test_marks_on_a_drum_that_turns_are_at_their_reference_points_by_their_textures(rig):
    """On a cylinder that turns, a subset's refined place leaves its reference point, and by how much its texture says."""
    motion, scene = rig(theta_z=np.radians(30.0), noise=0.3, roll=0.0)
    film = from_array(np.array(list(pictures(motion, scene, fps=100.0, seed=1))))
    project = project_for(scene, 100.0, 0.252)
    marks, truth = track(film, project).marks, true_motion(motion, scene, 100.0)
    size = picture_scale(project, next(picture for _, picture in film.pictures()))
    assert size is not None
    assert project.platform.origin_px is not None
    camera = camera_of(project, size, project.platform.origin_px, (256, 256))
    points = body_points(marks, camera, project.platform.radius_m)
    pose = np.stack([truth.trajectory.channels[c] for c in CHANNELS], axis=-1).astype(np.float64) - [0.0, 0.0, 0.252, 0.0, 0.0, 0.0]
    off = np.stack([marks.x_px - truth.x_px, marks.y_px - truth.y_px], axis=-1)
    by_texture = Body(camera, points, marks.response).project(pose)
    by_area = Body(camera, points, even_response(marks.reference_px, 25)).project(pose)
    assert np.abs(off).max() < 0.015
    assert np.abs(off + by_texture - by_area).max() > 2 * np.abs(off).max()


def test_marks_are_found_where_none_are_named(rig):
    motion, scene = rig(seconds=0.1)
    film = from_array(np.array(list(pictures(motion, scene, fps=100.0, seed=1))))
    known = project_for(scene, 100.0, 0.252)
    tracked = track(film, known.model_copy(update={"marks": MarkList(subset_px=25)}))
    assert len(tracked.marks.names) >= 4
    assert tracked.trajectory is not None
    truth = true_motion(motion, scene, 100.0).trajectory
    assert np.abs(tracked.trajectory.channels["z_m"] - truth.channels["z_m"]).max() < 2e-4
