"""An error of the model file is as large as its parameters that the measurements determine; those that stay at nought say nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from identify.estimation.tolerances import TOLERANCE_OF
from identify.selection import model_errors
from identify.selection.model_errors import _determined, slight_errors
from simulate.effects import GeometryError
from simulate.files.model_file import add_effects, read_model

NAME = "geometry-error"


def fit_of(deviations) -> Any:
    """A fit of a law and of an error with parameters known to some deviations; the prior of each is ten."""
    rows = [
        SimpleNamespace(name="beta_per_m", spread=2.0),
        *(SimpleNamespace(name=f"{NAME}.position_m[{i}]", spread=10.0) for i in range(36)),
    ]
    effects = (GeometryError(),)
    own = {"effects": effects, "effects_at": lambda _: effects, "rows_of": lambda _: np.arange(1, 37)}
    problem = SimpleNamespace(parameters=rows, first_effect=1, **own)
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


RIG = read_model(Path(__file__).resolve().parents[1].joinpath("rig.toml"))
MODEL = replace(RIG, nuisance=replace(RIG.nuisance, camera_scale_percent=1.0))


@pytest.mark.parametrize("name", TOLERANCE_OF)
@given(size=st.floats(-30.0, 30.0))
def test_sizes_in_tolerances_and_parameters_lead_to_each_other(name, size):
    of = TOLERANCE_OF[name]
    sizes = np.full(len(of.kind.flat_names()), size)
    assert of.sizes(MODEL, of.values(MODEL, sizes)) == pytest.approx(sizes, abs=1e-6)


@pytest.mark.parametrize("name", TOLERANCE_OF)
def test_a_step_is_what_a_tolerance_more_adds_wherever_the_model_is(name):
    of = TOLERANCE_OF[name]
    zero = np.zeros(len(of.kind.flat_names()))
    off = MODEL.effect(of.kind).with_flat(of.values(MODEL, zero + 2.0))
    for model in (MODEL, add_effects(MODEL, (off,))):
        slope = (of.values(model, zero + 1e-4) - of.values(model, zero - 1e-4)) / 2e-4
        assert of.step(model) == pytest.approx(slope, rel=1e-6)


def test_a_stop_is_twice_as_stiff_as_likely_as_half_and_never_less_than_nothing():
    """In equal ratios: 30 % too much is one tolerance, and five tolerances too little are no damping below nought."""
    of, damping = TOLERANCE_OF["end-stop-dissipation"], MODEL.end_stop.damping_N_s_per_m
    twice, half = of.sizes(MODEL, np.array([damping])), of.sizes(MODEL, np.array([-0.5 * damping]))
    assert twice == pytest.approx(-half)
    assert twice == pytest.approx(np.log(2.0) / 0.3)
    assert -damping < of.values(MODEL, np.array([-5.0]))[0] < -0.7 * damping
    lengths = TOLERANCE_OF[NAME]
    assert lengths.values(MODEL, np.full(36, 2.0)) == pytest.approx(-lengths.values(MODEL, np.full(36, -2.0)))
