"""Frames that were decoded and are wrong nevertheless."""

from __future__ import annotations

import numpy as np

from measure.footage.footage import from_array
from measure.footage.integrity import IntegrityCheck


def test_repeated_and_dark_frames_are_named():
    stack = np.random.default_rng(0).integers(80, 160, (9, 40, 50), dtype=np.uint8)
    stack[4] = stack[3]
    stack[7] = 5
    check = IntegrityCheck()
    assert len(list(check.watch(iter(from_array(stack).pictures())))) == 9
    assert (check.repeated, check.dark) == ([4], [7])
    assert check.remarks == ("frames repeat the one before (1): 4", "frames are dark (1): 7")


def test_a_sound_film_has_no_remarks():
    stack = np.random.default_rng(0).integers(80, 160, (5, 40, 50), dtype=np.uint8)
    check = IntegrityCheck()
    list(check.watch(iter(from_array(stack).pictures())))
    assert check.remarks == ()


def checked(stack, **changed):
    check = IntegrityCheck(**changed)
    assert len(list(check.watch(iter(from_array(stack).pictures())))) == len(stack)
    return check


def test_a_frame_is_dark_below_a_quarter_of_the_first_ones_brightness():
    stack = np.full((5, 40, 48), 100, np.uint8)
    stack[1:] += np.arange(1, 5, dtype=np.uint8)[:, None, None]
    stack[2], stack[3] = 26, 24
    assert checked(stack).dark == [3]


def test_a_frame_that_differs_in_a_single_pixel_repeats_nothing():
    stack = np.repeat(np.random.default_rng(0).integers(80, 160, (1, 40, 48), dtype=np.uint8), 4, axis=0)
    stack[1, 3, 5] += 1
    stack[2] = stack[1]
    stack[3, 8, 16] += 1
    assert checked(stack).repeated == [2]


def test_eight_frames_are_listed_by_their_numbers_in_the_film():
    moving = np.random.default_rng(0).integers(80, 160, (12, 40, 48), dtype=np.uint8)
    dark = moving.copy()
    dark[2:10] = np.arange(8, dtype=np.uint8)[:, None, None]
    assert checked(dark, first=100).remarks == ("frames are dark (8): 102, 103, 104, 105, 106, 107, 108, 109",)
    dark[10] = 9
    assert checked(dark).remarks == ("frames are dark (9): 2, 3, 4, 5, 6, 7, 8, 9, ...",)
