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
