"""Which further column of a file is worth trying: what the sentence says of one, of two that are one quantity, and of none."""

from __future__ import annotations

import numpy as np
import pytest

from identify.loops.covariates import hint, shares
from identify.loops.prepare import prepare
from measure import Loop

TIME = np.arange(1200) / 400.0


def test_of_two_columns_that_are_one_quantity_both_are_named():
    """A loop leaves a pressure, which the file has in bar and, rounded, in volts, beside a temperature that has no part in it."""
    chance = np.random.default_rng(5)
    pressure = 3.0 + np.cumsum(chance.normal(0.0, 0.02, len(TIME)))
    columns = {"bar": pressure, "volts": np.round(0.5 * pressure, 4), "kelvin": 293.0 + chance.normal(0.0, 0.1, len(TIME))}
    stroke = 0.05 * np.sin(2.0 * np.pi * TIME)
    data = prepare(Loop(TIME, stroke, 2.0 + stroke + 0.1 * np.cos(2.0 * np.pi * TIME), other=columns))
    left = 0.3 * (pressure - pressure.mean()) + chance.normal(0.0, 0.02, len(TIME))
    found = shares([data], [left[data.used]], [np.ones((int(np.count_nonzero(data.used)), 1))])
    assert found["bar"] == pytest.approx(found["volts"], rel=1e-3)
    assert found["kelvin"] < 0.05
    told = hint(found)
    assert '"bar"' in told
    assert '"volts"' in told
    assert '"kelvin"' not in told


def test_a_column_that_explains_more_is_named_alone():
    told = hint({"bar": 0.61, "kelvin": 0.3})
    assert told == 'column "bar" explains 61 % of what is left; --covariate "bar" fits its share of the force jointly'


def test_columns_that_explain_next_to_nothing_are_not_named():
    assert hint({"bar": 0.04, "kelvin": 0.01}) == ""
    assert hint({}) == ""
