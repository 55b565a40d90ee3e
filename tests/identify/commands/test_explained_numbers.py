"""What is printed of the numbers of a finding: each with its interval, and those of which nothing shows on one line."""

from __future__ import annotations

import numpy as np
import pytest

from identify.commands.explain_gap import _numbers
from identify.report.result import parameters_of
from identify.selection.verdict import Finding
from simulate.effects import CentreOfMassOffset, StoredForcePerRun
from simulate.model.effect import Effect


def printed(effect: Effect, shown: int) -> list[str]:
    """Of an effect of which the first numbers show."""
    count = len(effect.flat())
    stderr, ends = np.full(count, np.nan), np.tile([-0.9, 9.0], (count, 1))
    stderr[:shown], ends[:shown] = 0.01, [0.03, 0.07]
    return _numbers(parameters_of(Finding(effect, stderr, ends, (), 0.0, 0.0, 1.0)))


def test_stored_forces_of_runs_that_are_not_there_take_one_line():
    lines = printed(StoredForcePerRun((0.05, 0.04, *(0.0,) * 14)), 2)
    assert lines[:2] == ["fraction[0] = 0.05   95 % 0.03 ... 0.07", "fraction[1] = 0.04   95 % 0.03 ... 0.07"]
    assert lines[2:] == ["fraction[2] ... fraction[15] (14 of 16): not identifiable from these runs"]


@pytest.mark.parametrize(
    ("shown", "last"),
    [
        (3, "offset_m[2] = 0   95 % 0.03 ... 0.07"),
        (2, "offset_m[2]: not identifiable from these runs"),
        (1, "offset_m[1], offset_m[2]: not identifiable from these runs"),
    ],
)
def test_a_few_numbers_that_do_not_show_are_listed(shown, last):
    assert printed(CentreOfMassOffset(), shown)[-1] == last
