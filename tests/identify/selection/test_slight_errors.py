"""An error of the model file is as large as its parameters that the measurements determine; those that stay at nought say nothing."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.selection import model_errors
from identify.selection.model_errors import _determined, slight_errors

NAME = "geometry-error"


def fit_of(deviations) -> Any:
    """A fit of a law and of an error with parameters known to some deviations; the prior of each is ten."""
    rows = [
        SimpleNamespace(name="beta_per_m", spread=2.0),
        *(SimpleNamespace(name=f"{NAME}.position_m[{i}]", spread=10.0) for i in range(36)),
    ]
    effect = SimpleNamespace(name=NAME)
    problem = SimpleNamespace(parameters=rows, first_effect=1, effects_at=lambda _: (effect,), rows_of=lambda _: np.arange(1, 37))
    return SimpleNamespace(problem=problem, q=np.zeros(37), covariance=np.diag([0.1, *np.square(deviations)]))


def test_parameters_that_are_no_better_known_than_before_do_not_count():
    assert _determined(fit_of([0.1] * 6 + [10.0] * 30), NAME) == pytest.approx(6.0, abs=0.01)
    assert _determined(fit_of([10.0] * 36), NAME) == 1.0
    assert _determined(fit_of([0.0] * 36), NAME) == 36.0


@pytest.mark.parametrize(("shown", "slight"), [(1.0, True), (3.3, False)])
def test_a_few_joints_far_off_are_no_slight_error_beside_many_that_do_not_show(monkeypatch, shown, slight):
    sizes = {(NAME, i): shown if i < 6 else 0.0 for i in range(36)}
    monkeypatch.setattr(model_errors, "sizes_in_tolerances", lambda *_: sizes)
    assert bool(slight_errors(fit_of([0.1] * 6 + [10.0] * 30))) is slight
