"""What follows the frequency from loop to loop, on values that can be checked by eye."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.actuator.rates_and_strokes import follows_frequency

LOOPS: Any = [SimpleNamespace(frequency_Hz=f) for f in (0.1, 0.3, 1.0, 3.0, np.nan)]


@pytest.mark.parametrize(
    ("values", "follows"),
    [
        ([-1.0, -0.5, 0.0, 0.5, 9.0], True),
        ([1.0, 0.5, 0.0, -0.5, 9.0], True),
        ([1.0, -1.0, 1.0, -1.0, 0.0], False),
        ([0.0, 1.0, np.nan, np.nan, 9.0], False),
    ],
    ids=["grows", "falls", "to and fro", "two known"],
)
def test_a_line_through_the_logarithm_of_the_frequency_is_followed_up_and_down(values, follows):
    assert follows_frequency(LOOPS, np.array(values)) is follows


def test_loops_of_one_frequency_show_nothing_of_it():
    assert not follows_frequency([LOOPS[2]] * 4, np.arange(4.0))
