"""What follows the frequency from loop to loop, on values that can be checked by eye."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.actuator.rates_and_strokes import by_stroke, follows_frequency, groups_of_rate, strokes

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


def of_strokes(*amplitudes_m) -> Any:
    return [SimpleNamespace(amplitude_m=a, frequency_Hz=float(k)) for k, a in enumerate(amplitudes_m)]


def test_loops_whose_strokes_differ_by_less_than_five_per_cent_are_of_one_stroke_the_smallest_first():
    groups = strokes(of_strokes(0.04, 0.01, 0.0104, 0.0412, 0.02, 0.0098, 0.0415))
    assert [[one.amplitude_m for one in group] for group in groups] == [[0.0098, 0.01], [0.0104], [0.02], [0.04, 0.0412, 0.0415]]


def test_the_largest_group_of_one_stroke_is_in_the_order_of_its_frequencies():
    loops = of_strokes(0.04, 0.01, 0.0401, 0.02, 0.0402)
    assert by_stroke(loops) == [0, 2, 4]


def test_rates_within_two_per_cent_of_the_last_one_are_one_rate():
    assert groups_of_rate(np.array([3.0, 1.0, 1.01, 0.3, 3.05, 1.02])) == [[3], [1, 2, 5], [0, 4]]
