"""A part of a film keeps the film's time; an interlaced film is recognised and split."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from measure.common.errors import InputError
from measure.correlation.tracking import track_marks
from measure.footage.derived import field, fields, part
from measure.footage.footage import from_array
from measure.footage.integrity import IntegrityCheck


def _instants(count, step_px=(0.7, 1.9), seed=0, noise=1.0):
    """A blurred random picture that moves, at half frames."""
    rng = np.random.default_rng(seed)
    wide = cv2.GaussianBlur(rng.normal(128.0, 600.0, (160 + 2 * count, 160)).astype(np.float32), (0, 0), 2.0)
    for n in range(count):
        shift = np.array([[1, 0, -40 + step_px[0] * n / 2], [0, 1, -60 + step_px[1] * n / 2]], np.float32)
        moved = cv2.warpAffine(wide, shift, (96, 96), flags=cv2.INTER_CUBIC)
        yield np.clip(np.rint(moved + rng.normal(0.0, noise, moved.shape)), 0, 255).astype(np.uint8)


def _woven(instants, top_first=True):
    """Frames of an interlaced camera: one field of every instant."""
    instants = list(instants)
    for one, other in zip(instants[::2], instants[1::2], strict=True):
        frame = one.copy()
        frame[int(top_first) :: 2] = other[int(top_first) :: 2]
        yield frame


def test_a_part_has_the_times_and_numbers_of_the_film():
    stack = np.array(list(_instants(30)))
    film = from_array(stack, fps=50.0)
    piece = part(film, 50.0, 0.1, 0.4)
    shown = list(piece.pictures())
    assert [number for number, _ in shown] == list(range(16))
    assert (piece.first, piece.frames) == (5, 16)
    assert np.array_equal(shown[0][1], stack[5])
    marks = track_marks(piece, [(48.0, 48.0)], 50.0)
    assert np.allclose(marks.time_s, np.arange(5, 21) / 50.0)
    assert list(marks.columns()["frame"][:2]) == [5, 6]


def test_without_limits_a_part_is_the_film():
    film = from_array(np.array(list(_instants(4))))
    assert part(film, 50.0) is film


@pytest.mark.parametrize(
    ("limits", "says"),
    [
        ((0.7, None), r"--from 0.7: is outside of the film.*0 to 0.58 s"),
        ((None, 9.0), r"--to 9: is outside"),
        ((0.3, 0.1), "0 frames of array are between"),
        ((0.1, 0.105), "1 frames of array"),
    ],
)
def test_limits_outside_of_the_film_are_named(limits, says):
    film = from_array(np.array(list(_instants(30))), fps=50.0)
    with pytest.raises(InputError, match=says):
        part(film, 50.0, *limits)


@pytest.mark.parametrize("top_first", [True, False])
@pytest.mark.parametrize("step", [(3.0, 0.0), (0.7, 1.9), (0.0, 2.0), (1.5, 0.4)])
def test_an_interlaced_film_is_named_and_a_progressive_one_is_not(top_first, step):
    check = IntegrityCheck()
    list(check.watch(iter(enumerate(_woven(_instants(24, step), top_first)))))
    assert check.combing.interlaced
    assert check.combing.top_first is top_first
    assert any("interlaced, " + ("top" if top_first else "bottom") in remark for remark in check.remarks)
    plain = IntegrityCheck()
    list(plain.watch(iter(enumerate(_instants(24, step)))))
    assert not plain.combing.interlaced
    assert plain.remarks == ()


@pytest.mark.parametrize("top_first", [True, False])
def test_fields_are_pictures_half_a_frame_apart_in_the_films_own_pixels(top_first):
    """Positions of a mark in the fields lie on its straight way, at twice as many instants."""
    film = from_array(np.array(list(_woven(_instants(24, (0.8, 2.2)), top_first))), fps=25.0)
    halves = fields(film)
    assert (halves.frames, halves.per_frame) == (24, 2)
    marks = track_marks(halves, [(50.0, 40.0)], 25.0)
    assert np.allclose(marks.time_s, np.arange(24) / 50.0)
    assert np.abs(marks.x_px[:, 0] - 50.0 - 0.4 * np.arange(24)).max() < 0.15
    assert np.abs(marks.y_px[:, 0] - 40.0 - 1.1 * np.arange(24)).max() < 0.25


def test_fields_of_a_progressive_film_are_refused():
    with pytest.raises(InputError, match="is not interlaced"):
        fields(from_array(np.array(list(_instants(12)))))


@pytest.mark.parametrize("rows", [9, 10])
@pytest.mark.parametrize("top", [True, False])
def test_a_field_keeps_its_own_rows_and_fills_the_others_smoothly(rows, top):
    slope = np.tile(np.arange(rows, dtype=np.uint8)[:, None] * 10, (1, 4))
    made = field(slope, top)
    own = 0 if top else 1
    assert np.array_equal(made[own::2], slope[own::2])
    assert np.abs(made[3:-3].astype(int) - slope[3:-3]).max() <= 1
