"""Offsets that the error of the reference picture gives to all later sightings, in sightings made from exact geometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from measure.correlation.marks import OK, Marks
from measure.correlation.shape_function_bias import EVEN, NODES, Response
from measure.geometry.body import Body, body_points
from measure.geometry.camera import Camera, on_cylinder, rotation
from measure.geometry.mark_places import places_on_body
from measure.geometry.reference_error import share_left
from measure.geometry.rigid_body import PERSPECTIVE, fit_platform
from measure.tables.trajectory import CHANNELS

PLACES = np.array([[x, y] for y in (300.0, 346.0) for x in (76.0, 152.0, 228.0)])
RADIUS, NOISE, FRAMES, REST = 0.07, 0.01, 48, 4
CAMERA = Camera(0.5e-3, (152.0, 323.0), 0.0, 3.0, (152.0, 190.0))


def _response():
    count = len(PLACES)
    nodes = PLACES[:, None] + 12.5 * NODES
    return Response(PLACES, nodes, np.broadcast_to(EVEN, (count, 9, 2, 2)), np.full(count, 6), np.broadcast_to(np.eye(4), (count, 4, 4)))


def _poses():
    s = np.clip((np.arange(FRAMES) - REST) / (FRAMES - REST - 1.0), 0.0, 1.0)
    turn = np.radians([1.0, 1.2, 30.0])
    channels = [0.01 * np.sin(3.0 * s), 0.0 * s, 0.1 * s, turn[0] * np.sin(2.0 * s), turn[1] * np.sin(4.0 * s), turn[2] * s]
    return np.stack(channels, axis=-1)


def _film(offset_px, seed):
    """Sightings of a drum, beside their places by an offset that the body carries from when it moves.

    Returns marks, fit, and errors of the sightings by offsets and by noise, (frames, marks, 2) px each.
    """
    rng, poses = np.random.default_rng(seed), _poses()
    none = np.zeros((FRAMES, len(PLACES)))
    marks = Marks(
        np.arange(FRAMES) / 250.0, [f"m{i}" for i in range(len(PLACES))], _response(), none, none,
        np.broadcast_to(NOISE**2 * np.eye(2), (*none.shape, 2, 2)).copy(), none + 1.0, none, np.full(none.shape, OK),
    )  # fmt: skip
    points = body_points(marks, CAMERA, RADIUS)
    body = Body(CAMERA, points, marks.response)
    exact = body.project(poses)
    left = share_left(np.linalg.norm(exact - PLACES, axis=-1))
    added = np.einsum("tnij,nj->tni", body.carried(poses), offset_px) * left[..., None]
    noise = rng.normal(0.0, NOISE, exact.shape)
    noise[0] = 0.0
    seen = exact + added + noise
    marks = replace(marks, x_px=seen[..., 0], y_px=seen[..., 1])
    return marks, fit_platform(marks, CAMERA, points, PERSPECTIVE), added, noise


def _ratios(fit):
    """Errors of the poses after the rest, over their standard deviations."""
    at = [CHANNELS.index(channel) for channel in fit.free]
    return ((fit.pose - _poses())[:, at] / np.sqrt(np.diagonal(fit.covariance, axis1=1, axis2=2)))[REST + 1 :]


def test_offsets_that_do_not_look_like_a_pose_are_found():
    """Of two marks in a column, one too far to the left and one too far to the right: most of that is no motion of the body."""
    offset = np.zeros((6, 2))
    offset[[0, 3], 0] = 0.15, -0.15
    _, fit, added, _ = _film(offset, 1)
    late = slice(FRAMES // 2, None)
    assert np.sqrt(np.mean((fit.offset_px - added)[late] ** 2)) < 0.6 * np.sqrt(np.mean(added[late] ** 2))
    assert fit.offset_px[late, 0, 0].min() > 0.05
    assert fit.offset_px[late, 3, 0].max() < -0.05
    assert fit.widened < 1.5


def test_places_are_nearer_and_all_bars_hold_with_offsets_of_the_reference():
    poses, places, plain, mended = [], [], [], []
    for seed in range(5):
        marks, fit, added, noise = _film(np.random.default_rng([seed, 1]).normal(0.0, 0.1, (6, 2)), seed)
        sigma = np.sqrt(np.diagonal(places_on_body(marks, CAMERA, RADIUS, fit).covariance_px2, axis1=2, axis2=3))
        poses.append(_ratios(fit))
        plain.append((added + noise)[REST:])
        mended.append((added + noise - fit.offset_px)[REST:])
        places.append(mended[-1] / sigma[REST:])
    assert np.mean(np.square(mended)) < 0.7 * np.mean(np.square(plain))
    assert np.mean(np.abs(poses) < 1.96) > 0.85
    assert np.mean(np.abs(places) < 1.96) > 0.85


def test_without_offsets_nothing_changes():
    """Noise alone: what is taken off the sightings is far below it, and the bars are no wider."""
    for seed in range(3):
        _, fit, _, _ = _film(np.zeros((6, 2)), 100 + seed)
        assert np.abs(fit.offset_px).max() < 0.5 * NOISE
        assert fit.widened < 1.2
        assert np.sqrt(np.mean(_ratios(fit) ** 2)) == pytest.approx(1.0, abs=0.25)


def test_a_place_on_a_bent_mark_is_where_the_body_carries_its_reference_point():
    """What a subset makes of its bending is in the sightings and not in the places."""
    marks, fit, _, _ = _film(np.zeros((6, 2)), 7)
    points = on_cylinder(CAMERA, PLACES, RADIUS)
    poses = _poses()
    true = CAMERA.project(np.einsum("tij,nj->tni", rotation(poses[:, 3:]), points) + poses[:, None, :3])
    places = places_on_body(marks, CAMERA, RADIUS, fit)
    assert np.abs(marks.x_px - true[..., 0]).max() > 15.0 * NOISE
    assert np.abs(places.x_px - true[..., 0]).max() < 5.0 * NOISE
    assert np.abs(places.y_px - true[..., 1]).max() < 5.0 * NOISE


def test_a_mark_that_has_not_left_its_place_shows_no_offset():
    assert share_left(np.array([0.0, np.nan])) == pytest.approx([0.0, 0.0])
    assert share_left(np.array([0.02, 1.0])) == pytest.approx([0.0, 1.0], abs=0.01)
