"""Which marks move as one body, on paths that are drawn by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from measure.correlation.marks import Marks
from measure.correlation.shape_function_bias import EVEN, NODES, Response
from measure.film.one_body import moves, one_body

FRAMES = 21
ALONG = np.linspace(0.0, 1.0, FRAMES)
FOUR = [(0.0, 0.0), (60.0, 0.0), (0.0, 60.0), (60.0, 60.0)]


def marks_of(places, ways, sigma: float | list[float] = 0.01):
    """Marks that go from their places along straight ways, evenly; sigma px, one or one for each."""
    start, way = np.array(places, float), np.array(ways, float)
    count = len(start)
    path = start + ALONG[:, None, None] * way
    covariance = np.broadcast_to(sigma, count)[None, :, None, None] ** 2 * np.eye(2) * np.ones((FRAMES, 1, 1, 1))
    response = Response(
        start, start[:, None] + NODES, np.tile(EVEN, (count, 1, 1, 1)), np.full(count, 6), np.tile(np.eye(4), (count, 1, 1))
    )
    even = np.ones((FRAMES, count))
    status = np.full((FRAMES, count), "ok", "<U12")
    return Marks(ALONG, [f"a{i}" for i in range(count)], response, path[..., 0], path[..., 1], covariance, even, 0.0 * even, status)


def hidden(marks, which, frames):
    gone = np.zeros((FRAMES, len(marks.names)), bool)
    gone[frames, which] = True
    return marks.without(gone, "lost")


def kept(marks):
    """Places of the marks that are kept, and the reasons of the others by place."""
    found = one_body(marks)
    assert list(found.marks.names) == [f"m{i + 1}" for i in range(len(found.marks.names))]
    places = [tuple(place) for place in found.marks.reference_px.tolist()]
    return places, {(one.x_px, one.y_px): one.reason for one in found.left_out}, found


def test_a_motion_counts_from_a_tenth_of_a_pixel_and_eight_standard_deviations():
    """The length of the way without its outermost fiftieths: 0.96 of it."""
    ways = [(3 * length / 4.8, 4 * length / 4.8) for length in (0.09, 0.11, 0.09, 0.15, 0.17)]
    marks = marks_of([(0.0, 0.0)] * 5, ways, [0.001, 0.001, 0.001, 0.02, 0.02])
    assert moves(marks).tolist() == [False, True, False, False, True]
    nowhere = hidden(marks, 1, slice(None))
    assert not moves(nowhere)[1]


def test_marks_that_are_lost_in_most_frames_are_left_out_and_counted():
    marks = marks_of(FOUR, [(20.0, 0.0)] * 4)
    places, reasons, found = kept(hidden(hidden(marks, 0, slice(0, 10)), 3, slice(0, 11)))
    assert places == FOUR[:3]
    assert reasons == {FOUR[3]: "lost in most frames"}
    assert found.lost == 1
    for i in range(4):
        marks = hidden(marks, i, slice(0, 14))
    places, reasons, found = kept(hidden(marks, 2, slice(0, 16)))
    assert places == [FOUR[0], FOUR[1], FOUR[3]]
    assert found.lost == 1
    assert kept(marks_of(FOUR, [(20.0, 0.0)] * 4))[2].lost == 0


def test_a_place_four_times_less_certain_than_the_others_is_left_out():
    where = [(40.0 * i, 0.0) for i in range(6)]
    places, reasons, _ = kept(marks_of(where, [(0.0, 20.0)] * 6, [0.01] * 4 + [0.039, 0.041]))
    assert places == where[:5]
    assert "less certain" in reasons[where[5]]


def test_a_mark_that_moves_by_less_than_three_tenths_of_the_others_is_background():
    where = [(0.0, 0.0), (20.0, 0.0), (40.0, 0.0), (60.0, 0.0)]
    places, reasons, _ = kept(marks_of(where, [(20.0, 0.0), (20.0, 0.0), (5.8, 0.0), (6.2, 0.0)]))
    assert places == where[:2]
    assert "background" in reasons[where[2]]
    assert "one body" in reasons[where[3]]


def test_where_nothing_moves_all_are_kept():
    found = one_body(marks_of(FOUR, [(0.0, 0.0)] * 4))
    assert len(found.marks.names) == 4
    assert not found.left_out


@pytest.mark.parametrize(("other", "as_one"), [(14.2, True), (13.8, False)])
def test_motions_are_alike_up_to_three_tenths_of_the_larger(other, as_one):
    _, reasons, _ = kept(marks_of([(0.0, 0.0), (60.0, 0.0), (0.0, 60.0)], [(0.0, 20.0), (0.0, 20.0), (0.0, other)]))
    assert ("one body" not in reasons.get((0.0, 60.0), "")) == as_one


def test_marks_that_turn_about_each_other_and_keep_their_distance_are_one():
    """Quarter of a turn about their middle: they go opposite ways."""
    marks = marks_of([(-30.0, 0.0), (30.0, 0.0)], [(0.0, 0.0)] * 2)
    angle = 0.5 * np.pi * ALONG[:, None] + [np.pi, 0.0]
    turned = replace(marks, x_px=30.0 * np.cos(angle), y_px=30.0 * np.sin(angle))
    assert len(one_body(turned).marks.names) == 2
    stretched = replace(turned, x_px=turned.x_px * (1.0 + 0.1 * ALONG[:, None]), y_px=turned.y_px * (1.0 + 0.1 * ALONG[:, None]))
    assert len(one_body(stretched).marks.names) == 1


@pytest.mark.parametrize(("own", "others", "rivals"), [(4, 2, 2), (5, 2, 0), (4, 3, 3), (2, 1, 0), (3, 1, 0)])
def test_another_body_of_half_as_many_marks_is_a_rival(own, others, rivals):
    places = [(40.0 * i, 0.0) for i in range(own)] + [(40.0 * i, 200.0) for i in range(others)]
    found = one_body(marks_of(places, [(0.0, 30.0)] * own + [(30.0, 0.0)] * others))
    assert len(found.marks.names) == own
    assert found.rivals == rivals
    assert sum("one body" in one.reason for one in found.left_out) == others


def test_of_two_bodies_with_as_many_marks_the_one_that_goes_farther_is_taken():
    places = [(0.0, 0.0), (40.0, 0.0), (0.0, 200.0), (40.0, 200.0)]
    assert kept(marks_of(places, [(0.0, 30.0)] * 2 + [(33.0, 0.0)] * 2))[0] == places[2:]
    assert kept(marks_of(places, [(0.0, 33.0)] * 2 + [(30.0, 0.0)] * 2))[0] == places[:2]


@pytest.mark.parametrize(("astray_px", "is_out"), [(0.3, False), (3.0, True)])
def test_a_mark_that_leaves_the_plane_motion_of_the_others_is_left_out(astray_px, is_out):
    """The others shift, turn and stretch together; one is missing for a while."""
    places = [(35.0 * i, 35.0 * j) for i in range(4) for j in range(3)]
    ways = [(0.03 * x - 0.02 * y + 4.0, 0.02 * x + 0.03 * y - 30.0) for x, y in places]
    ways[5] = (ways[5][0] + astray_px, ways[5][1])
    found = one_body(hidden(marks_of(places, ways), 1, slice(3, 9)))
    left = [(one.x_px, one.y_px) for one in found.left_out]
    assert left == ([places[5]] if is_out else [])


def test_without_some_of_its_marks_a_body_says_why():
    body = one_body(marks_of(FOUR, [(20.0, 0.0)] * 4)).without(np.array([False, True, False, False]), "slipped")
    assert [tuple(place) for place in body.marks.reference_px.tolist()] == [FOUR[0], *FOUR[2:]]
    assert [(one.x_px, one.y_px, one.reason) for one in body.left_out] == [(60.0, 0.0, "slipped")]
