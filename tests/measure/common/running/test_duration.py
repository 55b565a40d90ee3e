"""What is said of the time ahead: round figures that follow the amount of work; no clock of the machine is asked."""

from __future__ import annotations

import pytest

from measure.common.command_line import foretell, progress
from measure.common.errors import InputError
from measure.common.running import duration
from measure.common.running.duration import LONGEST_S, foretold, in_words, timed


class Clock:
    """One that goes on by as much as the work says."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


def worked_through(total, seconds, first=0.0):
    """What is foretold of items that take so many seconds each, the first one longer."""
    clock, said = Clock(), []
    for k, _ in enumerate(foretold(range(total), total, said.append, clock)):
        clock.now += seconds + (first if k == 0 else 0.0)
    return said


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.2, "about 1 s"),
        (4.4, "about 4 s"),
        (41.0, "about 41 s"),
        (200.0, "about 3 min"),
        (5.1 * 3600, "about 5 h"),
        (3e5, "about 3 days"),
    ],
)
def test_a_duration_is_said_in_round_figures(seconds, words):
    assert in_words(seconds) == words


@pytest.mark.parametrize("total", [100, 1000, 10_000])
def test_what_is_foretold_follows_the_amount_of_work_and_not_the_first_item(total):
    (rest,) = worked_through(total, 0.5, first=30.0)
    assert rest == pytest.approx(0.5 * total, rel=0.1)


def test_of_what_is_soon_done_nothing_is_said():
    assert worked_through(5, 0.5) == []
    assert worked_through(1, 100.0) == []


def test_the_first_time_is_that_of_loading_and_is_not_counted():
    clock, durations = Clock(), iter([50.0, 2.0])

    def work():
        clock.now += next(durations)

    assert timed(work, clock) == 2.0


def test_what_nobody_waits_for_is_refused_with_what_to_change(capsys):
    with pytest.raises(InputError, match=r"about 28 days. Give fewer --runs"):
        foretell("sweep-deployments", True, "Give fewer --runs.")(2 * LONGEST_S)
    with pytest.raises(InputError, match="for ever"):
        foretell("sweep-deployments", True, "Give fewer --runs.")(float("inf"))


def test_it_is_said_on_standard_error_and_not_where_quiet_is_asked_for(capsys):
    foretell("explain-gap", False)(190.0)
    foretell("explain-gap", True)(190.0)
    out, error = capsys.readouterr()
    assert (out, error) == ("", "explain-gap: this takes about 3 min\n")


def test_items_that_take_longer_than_anybody_waits_end_in_a_sentence(monkeypatch):
    for name, value in {"_SAMPLE_S": 0.0, "_WORTH_S": 0.0, "LONGEST_S": 0.0}.items():
        monkeypatch.setattr(duration, name, value)
    with pytest.raises(InputError, match="Give fewer marks"):
        list(progress(range(9), what="frames", total=9, change="Give fewer marks."))
