"""Loops fitted by themselves and loops of a campaign: one problem, one result, whoever asks; and lmfit shows it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import lmfit
import numpy as np
import pytest
from lmfit.minimizer import MinimizerResult

from identify.actuator.actuator_fit import ActuatorFit
from identify.actuator.fit_actuator import fit_actuator
from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.estimation.estimates import estimates_of
from identify.estimation.least_squares import solve
from identify.estimation.lmfit_result import identifiers
from identify.estimation.parameters import Change
from identify.loops.prepare import prepare
from measure import Loop
from simulate.effects import HubInertia
from simulate.loop import loop_force

LINES, HUB, FINE = np.array([-0.25, 2.79, -0.3, 2.89, 400.0]), HubInertia(0.04), 10


def shaken(frequency: float, amplitude: float, seed: int, level: float = 0.0) -> Loop:
    rng, w = np.random.default_rng(seed), 2 * np.pi * frequency
    t = np.arange(600 * FINE) * (3.2 / frequency / 600 / FINE)
    u, v, a = 0.25 + amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)
    force = loop_force(LINES, t, u, v, a, 2.75, (HUB,))[::FINE] + level + 2e-3 * rng.standard_normal(600)
    return Loop(t[::FINE], u[::FINE] + 1e-5 * rng.standard_normal(600), force, f"{frequency:g} Hz, {1e3 * amplitude:g} mm")


def loops(levels=(0.0, 0.0, 0.0, 0.0)) -> list[Loop]:
    conditions = [(f, a) for f in (0.4, 3.0) for a in (0.05, 0.02)]
    return [shaken(f, a, seed, level) for seed, ((f, a), level) in enumerate(zip(conditions, levels, strict=True))]


@pytest.fixture(scope="module")
def fit() -> ActuatorFit:
    return fit_actuator([prepare(loop) for loop in loops()], (HubInertia,), suggest=False)


@pytest.mark.parametrize("own_zeros", [False, True])
def test_a_campaign_of_loops_gives_what_the_loops_give_by_themselves(prototype, own_zeros):
    """From another law, another scale and another start; to a millionth, or to what a prior of the zeros says, which loops alone have not.

    What fit-actuator adds to the covariance for channels that may be out of step is left out.
    """
    measured = loops((0.0, 0.02, -0.03, 0.05)) if own_zeros else loops()
    alone = fit_actuator([prepare(loop) for loop in measured], (HubInertia,), tare="each" if own_zeros else "common", suggest=False)
    model = replace(prototype, effects=())
    asked = solve(problem_of(model, [Run(loop) for loop in measured], own_zeros=own_zeros).with_effects([HubInertia()]))
    by_themselves, near = estimates_of(replace(alone.fit, widened=None)), 1e-4 if own_zeros else 1e-6
    for name, estimate in estimates_of(asked).items():
        if own_zeros and name.startswith("b_"):
            continue  # zeros of a drifting cell count from the begin of a record there, from its middle here
        assert estimate.value == pytest.approx(by_themselves[name].value, rel=near), name
        assert estimate.stderr == pytest.approx(by_themselves[name].stderr, rel=100 * near if own_zeros else near), name
        if not own_zeros:
            assert estimate.ci95 == pytest.approx(by_themselves[name].ci95, rel=near), name


def test_lmfits_result_has_the_engines_values_and_errors(fit):
    assert isinstance(fit.result, MinimizerResult)
    result: Any = fit.result
    for name, key in (("beta_per_m", "beta_per_m"), ("hub-inertia.mass_kg", "hub_inertia__mass_kg")):
        assert result.params[key].value == fit.estimates[name].value
        assert result.params[key].stderr == fit.estimates[name].stderr
        assert result.user_names[key] == name
        assert result.uvars[key].std_dev == pytest.approx(fit.estimates[name].stderr)
    assert result.params["hub_inertia__mass_kg"].min == 0.0
    assert not result.params["initial_force_N"].vary  # no loop shows it
    assert result.redchi == pytest.approx(1.0, abs=0.1)
    assert result.params["a_l_N_per_m"].correl["b_l_N"] < -0.9  # the loops are far from zero elongation
    report = lmfit.fit_report(result)
    assert "hub_inertia__mass_kg" in report
    assert "initial_force_N" in report


def test_a_slope_times_a_length_carries_its_error_and_the_levels(fit):
    """The level in the middle of the loops is known far better than the intercept that it is made of."""
    result: Any = fit.result
    level = result.uvars["b_l_N"] + 0.25 * result.uvars["a_l_N_per_m"]
    assert level.std_dev < 0.1 * result.uvars["b_l_N"].std_dev
    assert level.nominal_value == pytest.approx(2.79 - 0.25 * 0.25, abs=1e-3)


def test_lmfits_profile_agrees_with_the_intervals(fit):
    found: Any = lmfit.conf_interval(fit.minimizer, fit.result, p_names=["beta_per_m"], sigmas=[0.95])
    ends = found["beta_per_m"]
    assert (ends[0][1], ends[-1][1]) == pytest.approx(fit.estimates["beta_per_m"].ci95, rel=5e-3)


def test_names_that_lmfit_would_take_for_one_stay_two():
    names = ["leg-disparity.force_N[0]", "leg_disparity.force_N[0]", "covariate.column 6", "1Hz.zero_N"]
    assert list(identifiers(names)) == ["leg_disparity__force_N_0", "leg_disparity__force_N_0_2", "covariate__column_6", "_1Hz__zero_N"]


def test_a_fit_is_a_table_and_a_line(fit):
    frame = fit.to_frame()
    assert frame.loc["beta_per_m", "value"] == fit.estimates["beta_per_m"].value
    assert frame.attrs["units"]["hub-inertia.mass_kg"] == "kg"
    assert repr(fit).startswith("ActuatorFit(ok: 4 loops, b_l_N 2.79")


def fitted(*changes: Change) -> ActuatorFit:
    return fit_actuator([prepare(loop) for loop in loops()], (HubInertia,), changes=changes, suggest=False)


def test_a_parameter_that_is_held_is_no_error_of_the_others(fit):
    held = fitted(Change("hub-inertia.mass_kg", 0.04, held=True))
    assert held.estimates["hub-inertia.mass_kg"].value == 0.04
    assert held.estimates["hub-inertia.mass_kg"].stderr == 0.0
    assert held.estimates["a_l_N_per_m"].stderr < fit.estimates["a_l_N_per_m"].stderr
    result: Any = held.result
    assert not result.params["hub_inertia__mass_kg"].vary


def test_a_bound_that_binds_is_named(fit):
    bounded = fitted(Change("beta_per_m", high=300.0))
    assert bounded.estimates["beta_per_m"].value == pytest.approx(300.0, rel=1e-4)
    assert bounded.estimates["beta_per_m"].verdict == "at-bound"
    assert bounded.fit.at_bounds() == {"beta_per_m": "upper bound 300"}


def test_where_a_fit_begins_does_not_matter_to_where_it_ends(fit):
    far = fitted(Change("beta_per_m", 60.0), Change("hub-inertia.mass_kg", 1.0))
    for name, estimate in far.estimates.items():
        assert estimate.value == pytest.approx(fit.estimates[name].value, rel=1e-6)
