"""A prepared mark and what it makes of motions, by finite differences and by motions that are known exactly."""

from __future__ import annotations

import numpy as np
import pytest

from measure.correlation.gauss_newton import compose
from measure.correlation.marks import Observation, not_observed
from measure.correlation.reference_image import reference
from measure.correlation.rest_frames import at_rest, read_rest
from measure.correlation.shape_function_bias import NODES, SHARES
from measure.correlation.steepest_descent import AFFINE, EUCLIDEAN, TRANSLATION
from measure.correlation.tracking import responses

PLACE = (36.3, 35.6)


@pytest.fixture(scope="module")
def marks(speckled):
    picture = speckled(noise=0.0)
    return {warp: reference(picture, *PLACE, 31, warp) for warp in (TRANSLATION, EUCLIDEAN, AFFINE)}


@pytest.fixture(scope="module")
def crossed():
    """Two edges that cross: their directions are fixed, the stretches along them are not."""
    y, x = np.mgrid[:72, :72] - 36.3
    return reference(np.rint(60 + 65 * (1 + np.tanh(x / 0.8) * np.tanh(y / 0.8))).astype(np.uint8), 36.3, 36.3, 41)


@pytest.mark.parametrize("warp", [TRANSLATION, EUCLIDEAN, AFFINE])
def test_the_reference_point_moves_with_each_parameter_as_its_slopes_say(marks, warp):
    mark = marks[warp]
    assert mark.point(mark.start) == pytest.approx(PLACE)
    assert mark.point_px == pytest.approx(PLACE)
    for k, step in enumerate(1e-6 * np.eye(warp)):
        moved = mark.point(compose(mark.start, -step)) - mark.point(mark.start)
        assert moved / 1e-6 == pytest.approx(mark.point_slopes[:, k], abs=1e-4)
    assert mark.point_noise == pytest.approx(mark.point_slopes @ mark.noise @ mark.point_slopes.T)


def test_a_grey_level_more_in_the_shape_of_a_slope_is_a_shift_of_a_pixel(marks):
    """What the picture would gain if all of it moved by one pixel along an axis, moves the point by one pixel along it."""
    for mark in marks.values():
        for axis in (0, 1):
            assert mark.answer @ mark.descent[axis].astype(float) == pytest.approx(np.eye(2)[axis], abs=0.02)


def test_texture_fixes_all_of_a_warp_and_crossed_edges_no_stretch(marks, crossed):
    assert marks[AFFINE].followed == pytest.approx(np.eye(4), abs=1e-9)
    assert marks[AFFINE].turns
    assert marks[EUCLIDEAN].turns
    assert not marks[TRANSLATION].turns
    assert marks[AFFINE].loose == marks[EUCLIDEAN].loose == ()
    assert np.linalg.matrix_rank(crossed.followed, tol=1e-6) == 2
    assert crossed.turns
    along_x, along_y = crossed.loose
    assert along_x == pytest.approx(np.diag([1.0, 0.0]), abs=0.15)
    assert along_y == pytest.approx(np.diag([0.0, 1.0]), abs=0.15)


def test_the_shape_of_a_mark_is_its_mask_within_the_square(speckled):
    mask = np.hypot(*(np.mgrid[:72, :72] - 36.0)) < 12
    mark = reference(speckled(), 36.0, 36.0, 31, AFFINE, mask)
    assert mark.shape is not None
    assert np.array_equal(mark.shape, mask[21:52, 21:52])
    assert reference(speckled(), 36.0, 36.0, 31).shape is None
    assert mark.contrast == pytest.approx(float(mark.values.std()))
    assert len(mark.added) == len(mark.light) + len(mark.bending)
    assert (mark.half, mark.warp) == (15, AFFINE)


def moved_nodes(response, matrix, shift):
    return np.einsum("ij,nqj->nqi", matrix, response.nodes_px) + shift


TURN = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
STRETCH = np.array([[1.1, 0.15], [-0.05, 0.9]])


@pytest.mark.parametrize(
    ("warp", "matrix", "exact"),
    [
        (TRANSLATION, np.eye(2), 1e-7),
        (EUCLIDEAN, TURN, 1e-7),
        (AFFINE, TURN, 1e-7),
        (AFFINE, STRETCH, 1e-7),
        (EUCLIDEAN, STRETCH @ TURN, None),
    ],
)
def test_a_motion_that_the_warp_can_follow_puts_the_point_where_it_goes(marks, warp, matrix, exact):
    response = responses([marks[warp]])
    found = response.apparent(moved_nodes(response, matrix, [3.0, -2.0]))[0]
    expected = matrix @ PLACE + [3.0, -2.0]
    if exact:
        assert found == pytest.approx(expected, abs=exact)
    else:
        assert 1e-3 < np.abs(found - expected).max() < 1.0


def test_nodes_are_those_of_gauss_and_a_shift_of_all_is_a_shift_of_the_mark(marks):
    """Exact for cubic motions: over the square the mean of x^2 is a third, of x^2 y^2 a ninth."""
    assert SHARES.sum() == pytest.approx(1.0)
    x, y = NODES.T
    assert [SHARES @ x**2, SHARES @ y**2, SHARES @ (x * y) ** 2, SHARES @ x**4] == pytest.approx([1 / 3, 1 / 3, 1 / 9, 1 / 5])
    for mark in marks.values():
        response = responses([mark])
        assert response.weights[0].sum(axis=0) == pytest.approx(np.eye(2), abs=0.02)
        assert response.nodes_px[0].mean(axis=0) == pytest.approx([36.0, 36.0])
        assert np.ptp(response.nodes_px[0][:, 0]) == pytest.approx(31.0 * np.sqrt(0.6))
    assert np.array_equal(responses(list(marks.values())).parameters, [2, 3, 6])


def test_what_a_texture_does_not_fix_is_not_followed(crossed):
    """The mark is stretched along both axes: its point, the crossing, stays."""
    response = responses([crossed])
    found = response.apparent(moved_nodes(response, np.diag([1.2, 0.8]), [36.3 * -0.2, 36.3 * 0.2]))[0]
    assert found == pytest.approx([36.3, 36.3], abs=0.05)


def seen(x, y, sigma=0.01, hidden=0.0):
    return Observation(x, y, sigma**2 * np.eye(2), 0.99, 1.0, hidden, "ok")


def test_marks_are_at_rest_until_all_together_leave_by_twice_their_standard_deviation():
    """Four marks of 0.01 px: their mean is known to 0.005 px."""
    places = np.array([[10.0, 10.0], [50.0, 10.0], [10.0, 50.0], [50.0, 50.0]])

    def moved(dx, dy, **one):
        return [seen(x + dx, y + dy, **(one if k == 0 else {})) for k, (x, y) in enumerate(places)]

    for dx, dy, rests in ((0.0099, 0.0, True), (0.0101, 0.0, False), (0.0, -0.0099, True), (0.0, -0.0101, False)):
        assert at_rest(places, moved(dx, dy)) == rests
    assert not at_rest(places, moved(0.0, 0.0, hidden=0.01))
    assert not at_rest(places, [not_observed("lost"), *moved(0.0, 0.0)[1:]])
    for apart, rests in ((0.019, True), (0.041, False)):
        opposite = [seen(x + apart * sign, y) for (x, y), sign in zip(places, (1, -1, 1, -1), strict=True)]
        assert at_rest(places, opposite) == rests


@pytest.mark.parametrize(("moves_at", "read", "averaged"), [(5, 6, 4), (2, 3, None), (3, 4, 2), (99, 16, 16)])
def test_frames_are_read_until_something_moves_and_the_last_one_at_rest_does_not_count(moves_at, read, averaged):
    pictures = np.random.default_rng(0).integers(0, 255, (40, 6, 7)).astype(np.uint8)
    frames = iter(enumerate(pictures))
    taken, mean = read_rest(frames, lambda n, _: n < moves_at)
    assert [n for n, _ in taken] == list(range(read))
    assert next(frames)[0] == read
    if averaged is None:
        assert mean is None
    else:
        assert mean == pytest.approx(pictures[:averaged].mean(axis=0), rel=1e-6)


def test_a_film_that_ends_at_rest_is_averaged_as_a_whole():
    pictures = np.full((3, 6, 7), 9, np.uint8)
    taken, mean = read_rest(iter(enumerate(pictures)), lambda *_: True)
    assert len(taken) == 3
    assert mean is not None
    assert mean.dtype == np.float32
