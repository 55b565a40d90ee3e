"""Copies, fields and parts of films whose frames are known to the last pixel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from measure.footage.derived import field, fields, part
from measure.footage.footage import from_array
from measure.footage.integrity import Combing, IntegrityCheck


def moving(places, width=96, rows=64):
    """A smooth pattern at these places, px, in grey levels of 8 bit."""
    x, y = np.meshgrid(np.arange(width, dtype=float), np.arange(rows, dtype=float))
    frames = [127.0 + 60.0 * np.sin((x - place) / 5.0) + 40.0 * np.sin((y + 0.3 * x - place) / 7.0) for place in places]
    return np.rint(np.stack(frames)).astype(np.uint8)


def copies(frames, noise=0):
    chance = np.random.default_rng(0)
    check = IntegrityCheck()
    noisy = [np.clip(frame + chance.integers(-noise, noise + 1, frame.shape), 0, 255).astype(np.uint8) for frame in frames]
    list(check.watch(iter(from_array(np.stack(noisy)).pictures())))
    return check.copies


def test_a_frame_that_shows_the_one_before_while_the_film_moves_is_a_copy_also_after_compression():
    assert copies(moving([0, 2, 4, 4, 6, 8, 10, 12]), noise=1) == [3]
    assert copies(moving([0, 2, 4, 4, 4, 6, 8, 10]), noise=1) == [3, 4]
    assert copies(moving([0, 2, 4, 6, 8, 10, 10, 12]), noise=1) == [6]


def test_a_film_that_stands_still_turns_round_or_goes_on_evenly_has_no_copies():
    assert copies(moving([0, 0, 0, 0, 0, 0]), noise=1) == []
    assert copies(moving([0, 2, 4, 6, 8, 10]), noise=1) == []
    assert copies(moving([0, 2, 4, 6, 6, 4, 2, 0]), noise=1) == []
    assert copies(moving([0, 2, 4, 4, 4, 4, 4, 4, 6, 8]), noise=1) == []


def combed(places, top_first):
    """Frames whose fields were taken half a step apart."""
    early, late = moving(places), moving(np.asarray(places, float) + 1.0)
    first, second = (slice(0, None, 2), slice(1, None, 2))[:: 1 if top_first else -1]
    made = early.copy()
    made[:, second] = late[:, second]
    assert np.array_equal(made[:, first], early[:, first])
    return made


@pytest.mark.parametrize("top_first", [True, False])
def test_fields_taken_at_two_instants_are_seen_with_their_order(top_first):
    seen = Combing()
    for frame in combed(2.0 * np.arange(8), top_first):
        seen.watch(frame)
    assert seen.interlaced
    assert seen.top_first == top_first
    assert seen.moving == seen.combed == 7


def test_a_progressive_film_and_one_at_rest_are_not_combed():
    for places in (2.0 * np.arange(8), np.zeros(8)):
        seen = Combing()
        for frame in moving(places):
            seen.watch(frame)
        assert not seen.interlaced
        assert seen.combed == 0


@pytest.mark.parametrize("combing", [(10, 7, 1, True), (10, 6, 1, False), (10, 7, 2, False), (10, 0, 7, True), (0, 0, 0, False)])
def test_most_frames_that_move_must_be_combed_one_way(combing):
    number, top, bottom, interlaced = combing
    assert Combing(number, top, bottom).interlaced == interlaced


@pytest.mark.parametrize("rows", [8, 9])
@pytest.mark.parametrize("top", [True, False])
def test_rows_between_those_of_a_field_are_cubic_in_them(rows, top):
    y = np.arange(rows, dtype=float)
    smooth = np.tile((200.0 + 3.0 * y + 1.0 * (y - 4.0) ** 2 - 0.25 * (y - 4.0) ** 3)[:, None], (1, 5))
    picture = np.rint(16.0 * smooth).astype(np.uint16)
    picture[(1 if top else 0) :: 2] = 0
    found = field(picture, top).astype(float)
    own = 0 if top else 1
    assert np.array_equal(found[own::2], picture[own::2])
    inner = slice(own + 3, own + 2 * len(range(own, rows, 2)) - 4)
    assert found[inner] == pytest.approx(np.rint(16.0 * smooth)[inner], abs=1.5)
    assert np.all(found > 0.0)


def test_a_part_of_a_film_has_both_its_ends_and_the_clock_of_the_whole():
    film = from_array(moving(np.arange(10.0)))
    cut = part(film, 100.0, 0.02, 0.05)
    assert (cut.frames, cut.first) == (4, 2)
    assert cut.times_s(4, 100.0) == pytest.approx([0.02, 0.03, 0.04, 0.05])
    numbers, pictures = zip(*cut.pictures(), strict=True)
    assert numbers == (0, 1, 2, 3)
    assert np.array_equal(pictures[0], moving(np.arange(10.0))[2])
    assert part(film, 100.0, 0.07, None).frames == 3
    assert part(film, 100.0, None, 0.01).frames == 2


def test_up_to_three_frames_in_a_row_are_copies_and_where_four_stay_nothing_moves():
    for held, expected in ((1, [4]), (2, [4, 5]), (3, [4, 5, 6]), (4, [])):
        places = [0, 2, 4, 6, *[6] * held, 8, 10, 12, 14]
        assert copies(moving(places), noise=1) == expected


def test_nothing_is_known_of_the_first_frame_and_the_last():
    assert copies(moving([0, 0, 2, 4, 6, 8]), noise=1) == []
    assert copies(moving([0, 2, 4, 6, 8, 8]), noise=1) == []


def test_what_moves_by_less_than_a_tenth_of_the_grey_values_is_compression():
    """The pattern has a range of 200 grey levels; a step of a tenth of a pixel changes it by one or two."""
    assert copies(moving([0.0, 0.1, 0.2, 0.2, 0.3, 0.4, 0.5])) == []


def test_fields_have_the_instants_of_their_frames_and_half_a_step_later():
    film = from_array(combed(2.0 * np.arange(8), True), fps=50.0)
    halves = fields(film)
    assert (halves.frames, halves.per_frame, halves.width, halves.height) == (16, 2, 96, 64)
    assert halves.instants == pytest.approx(np.arange(16) / 2.0)
    assert halves.remarks[-1].startswith("split into fields, top field first")
    dropped = replace(film, instants=np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 7.0, 8.0]))
    assert fields(dropped).instants[4:10] == pytest.approx([2.0, 3.0, 4.0, 4.5, 5.0, 5.5])  # type: ignore[index]
    numbers, pictures = zip(*halves.pictures(), strict=True)
    assert numbers == tuple(range(16))
    frame = combed(2.0 * np.arange(8), True)[3]
    assert np.array_equal(pictures[6][0::2], frame[0::2])
    assert np.array_equal(pictures[7][1::2], frame[1::2])
    assert "bottom field first" in fields(from_array(combed(2.0 * np.arange(8), False))).remarks[-1]


def test_after_a_hundred_frames_that_move_the_order_of_fields_is_settled():
    seen = Combing()
    frames = combed(2.0 * np.arange(8), True)
    for n in range(140):
        seen.watch(frames[n % 8])
    assert seen.moving == 100
    assert seen.remark.startswith("the film is interlaced, top field first: ")
    assert f"{seen.combed} of 100 frames" in seen.remark


def test_a_film_that_comes_to_rest_for_an_instant_on_either_side_has_no_copies():
    """Ever faster from rest, or ever slower to it: the change there is what the frames on that side foresee."""
    assert copies(moving([0.0, 1.5, 3.0, 3.0, 4.5, 7.5, 10.5, 13.5]), noise=1) == []
    assert copies(moving([13.5, 10.5, 7.5, 4.5, 3.0, 3.0, 1.5, 0.0]), noise=1) == []
    assert copies(moving([0.0, 1.5, 3.0, 3.0, 4.5, 6.0, 7.5, 9.0]), noise=1) == [3]
