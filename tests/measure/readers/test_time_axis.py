"""The time of a record: what can be put in order, what is reported, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.readers.time_axis import gaps, in_order, remarks

TIME = np.arange(40) / 10.0
RISING = {"time": TIME, "elongation": 0.01 * TIME, "force": 3.0 + TIME}


def ordered(**changed):
    return in_order({**RISING, **changed}, lambda i: f"line {i + 2}")


def rows(which):
    return {name: values[which] for name, values in RISING.items()}


def test_a_time_that_grows_is_left_as_it_is():
    columns, said = ordered()
    assert said == []
    assert all(np.array_equal(columns[name], RISING[name]) for name in RISING)


def test_rows_that_lie_in_disorder_are_sorted_and_it_is_said():
    swapped = np.arange(40)
    swapped[[5, 6, 20, 21]] = [6, 5, 21, 20]
    columns, said = ordered(**rows(swapped))
    assert said == ["time goes back at 2 of 40 rows; the rows were sorted by time"]
    assert all(np.array_equal(columns[name], RISING[name]) for name in RISING)


def test_two_recordings_over_the_same_seconds_are_refused_with_the_line_of_the_second():
    twice = {name: np.concatenate([values, values + (0.3 if name == "elongation" else 0.0)]) for name, values in RISING.items()}
    with pytest.raises(InputError, match=r"line 42: time goes from 3.9 back to 0 s .* there are two recordings"):
        ordered(**twice)
    thrice = {name: np.concatenate([twice[name], RISING[name] + (0.6 if name == "elongation" else 0.0)]) for name in RISING}
    with pytest.raises(InputError, match="there are 3 recordings"):
        ordered(**thrice)


@pytest.mark.parametrize(("begin", "refused"), [(1.9, True), (2.05, False)])
def test_runs_that_share_half_of_the_shorter_ones_seconds_are_two_recordings(begin, refused):
    second = {"time": begin + TIME, "elongation": 0.01 * (begin + TIME) - 0.02, "force": TIME}
    both = {name: np.concatenate([RISING[name], second[name]]) for name in RISING}
    if refused:
        with pytest.raises(InputError, match="runs over the same seconds again"):
            ordered(**both)
    else:
        with pytest.raises(InputError, match="leap to and fro"):
            ordered(**both)


def test_rows_that_stand_twice_count_once():
    again = {name: np.concatenate([values, values[:20]]) for name, values in RISING.items()}
    columns, said = ordered(**again)
    assert np.array_equal(columns["force"], RISING["force"])
    assert said[-1] == "20 of 60 rows have the time of another one; they are the same and count once"


def test_of_rows_of_one_instant_the_mean_is_taken():
    time, force = TIME.copy(), RISING["force"].copy()
    time[7] = time[8]
    columns, said = ordered(time=time, force=force)
    assert said == ["1 of 40 rows have the time of another one; their mean was taken"]
    assert len(columns["time"]) == 39
    assert columns["force"][7] == pytest.approx((force[7] + force[8]) / 2)
    assert columns["elongation"][7] == pytest.approx(0.0075)
    assert columns["time"][7] == TIME[8]
    assert columns["force"][8] == force[9]


@pytest.mark.parametrize(("apart", "refused"), [(0.0035, False), (0.0045, True)])
def test_two_elongations_at_one_instant_may_differ_by_a_tenth_of_the_range(apart, refused):
    time, u = TIME.copy(), RISING["elongation"].copy()
    time[30] = time[31]
    u[30] = u[31] - apart
    if refused:
        with pytest.raises(InputError, match=r"line 32: 2 rows have the time 3.1 s, and their elongations differ by 0.0045 m"):
            ordered(time=time, elongation=u)
    else:
        assert len(ordered(time=time, elongation=u)[0]["time"]) == 39


def test_a_gap_is_five_usual_steps():
    time = np.concatenate([np.arange(30) / 10.0, 2.9 + 0.49 + np.arange(30) / 10.0, 6.29 + 0.51 + np.arange(30) / 10.0])
    assert gaps(time) == [59]
    assert remarks(time) == ["no samples for 0.51 s after 6.29 s (a sample every 0.1 s elsewhere)"]


def test_three_gaps_are_listed_and_the_others_counted():
    time = np.arange(150) / 10.0 + 2.0 * (np.arange(150) // 30)
    assert len(gaps(time)) == 4
    said = remarks(time)
    assert len(said) == 4
    assert said[0] == "no samples for 2.1 s after 2.9 s (a sample every 0.1 s elsewhere)"
    assert said[3] == "and 1 more gaps"
    assert len(remarks(time[:120])) == 3


@pytest.mark.parametrize(("spread", "is_said"), [(0.018, False), (0.0222, True)])
def test_a_clock_whose_steps_spread_by_a_fifth_is_uneven(spread, is_said):
    steps = 0.1 + spread * (np.arange(41) % 2 - 0.5)
    said = remarks(np.cumsum(steps))
    assert said == (["steps of 0.0889 to 0.111 s: the clock is uneven, and every time is taken as it is"] if is_said else [])


def test_two_samples_have_nothing_to_say():
    assert remarks(np.array([0.0, 1.0])) == []
    assert remarks(np.array([0.0, 1.0, 9.0])) != []
