"""Effects fitted jointly: from where a fit starts, when releases have swallowed a part of what is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.estimation.fit import Fit
from identify.estimation.least_squares import before_the_stops, solve
from identify.estimation.parameters import POSE
from identify.estimation.problem import problem_of
from identify.selection import candidate_fits as candidates
from identify.selection.candidate_fits import as_planned, carried_on, carried_to_the_end, fit_screened
from identify.selection.comparison import BUDGETS, next_effect
from identify.selection.gap_test import GAP_P, gap_test
from identify.selection.screening import screen
from measure.common.arrays import Array
from simulate.effects import GravityImbalance, LegDisparity, PowerLawFriction
from simulate.files.model_file import read_model

LEGS = np.array([0.020, -0.020, 0.0, 0.010, -0.010, 0.0])
CHI2_999 = 20.5  # of five degrees of freedom, in one case of a thousand


@pytest.mark.slow
def test_releases_that_have_swallowed_an_effect_give_it_back(campaign):
    """Unequal legs leave releases far from the plan; with the effect they are as planned again, and the legs are as they were made."""
    folder = campaign(LegDisparity(tuple(LEGS)), 601)
    runs = [run for run in read_campaign([folder / "campaign.toml"]) if not run.hold_out]
    early = before_the_stops(problem_of(read_model(folder / "model.toml"), runs))
    before = solve(early)
    assert gap_test(before).release_p < GAP_P
    (legs,) = screen(before, [LegDisparity()])
    found = fit_screened(before, legs).fit
    assert gap_test(found).release_p > GAP_P
    assert found.cost < before.cost - 0.8 * legs.promise * before.variance_inflation
    assert _departure(found, LEGS) < CHI2_999 < 1e-3 * _departure(found, 0.0 * LEGS)


def _departure(found: Fit, legs_N: Array) -> float:
    """Chi-squared of five differences of the legs, once the fit has been carried to its end."""
    fit = solve(found.problem, found.q, most_steps=60)
    (effect,), own = fit.problem.effects_at(fit.q), slice(fit.problem.first_effect, None)
    differences = np.eye(6) - 1.0 / 6.0
    scales = fit.problem.scales[own]
    spread = differences @ (fit.covariance[own, own] * np.outer(scales, scales)) @ differences
    off = differences @ (effect.flat() - legs_N)
    return float(off @ np.linalg.pinv(spread, rcond=1e-9) @ off)


def test_planned_releases_move_nothing_but_where_the_platform_was_let_go(campaign):
    folder = campaign(None, 602, loops=(), deployments=({},))
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    planned = as_planned(problem, np.ones(len(problem.parameters)))
    moved = {parameter.key for parameter, value in zip(problem.parameters, planned, strict=True) if value == 0.0}
    assert moved == set(POSE)


@pytest.mark.slow
def test_base_in_a_wrong_minimum_is_left_before_anything_is_named(campaign, fitted):
    """A release that is three spreads off, held there by nothing but where the fit ended: nothing is missing, and nothing is named."""
    before = fitted(campaign(None, 603, loops=(), deployments=({}, {"geometry.stowed_height_m": 0.30}), hold_out=False))
    problem, q = before.problem, before.q.copy()
    q[problem.first_nuisance : problem.first_nuisance + 3] += 3.0
    astray = Fit(problem, q, *problem.jacobian(q), converged=True)
    assert astray.cost > 4.0 * before.cost
    look, step = next_effect(
        astray, {"leg-disparity": LegDisparity, "gravity-imbalance": GravityImbalance}, BUDGETS["quick"], lambda text: None
    )
    assert step is None
    assert look.current.cost < 1.1 * before.cost


def test_who_was_cut_off_near_the_best_is_fitted_on(campaign, fitted):
    before = fitted(campaign(PowerLawFriction(0.3, 1.5), 604, deployments=()))
    (best,) = (fit_screened(before, one) for one in screen(before, [PowerLawFriction()]))
    near, far = (replace(best, fit=_cut_off(best.fit, higher)) for higher in (20.0, 500.0))
    found = carried_on(before, [best, near, far])
    assert found[0] is best
    assert near.fit.cost > best.fit.cost + 10.0
    assert found[1].fit.cost < best.fit.cost + 1.0
    assert found[2] is far


@pytest.mark.parametrize("hidden", [PowerLawFriction(2e-3, 0.65), PowerLawFriction(5e-3, 1.6)])
def test_a_power_law_is_found_on_its_side_of_viscous_friction(campaign, fitted, hidden):
    """Both sides look nearly alike while the law is weak, and no fit comes from the one to the other."""
    before = fitted(campaign(hidden, 605, deployments=()))
    (look,) = screen(before, [PowerLawFriction()])
    fit = fit_screened(before, look).fit
    found = fit.problem.effects_at(fit.q)[-1]
    assert isinstance(found, PowerLawFriction)
    assert (found.exponent < 1.0) == (hidden.exponent < 1.0)
    true = before.problem.with_effects([*before.problem.effects, hidden])
    assert fit.cost < solve(true, np.append(before.q, [0.0, 0.0])).cost + 1.0


def _cut_off(fit: Fit, higher: float) -> Fit:
    """A fit that has not come to its end: its sum of squares is by about so much higher."""
    first, q = fit.problem.first_effect, fit.q.copy()
    q[first] += np.sqrt(higher / np.sum(fit.jacobian[:, first] ** 2))
    return Fit(fit.problem, q, *fit.problem.jacobian(q), converged=False)


def test_an_effect_that_fits_worse_than_none_is_fitted_again_from_there(campaign, fitted, monkeypatch):
    """Behind the stops a fit can lose its way and end far above the fit without the effect, which it holds as a special case."""
    before = fitted(campaign(GravityImbalance(0.05), 605, loops=(), deployments=({}, {"geometry.stowed_height_m": 0.30}), hold_out=False))
    (one,) = screen(before, [GravityImbalance()])
    good = fit_screened(before, one)
    problem, q = good.fit.problem, good.fit.q.copy()
    q[problem.first_nuisance : problem.first_nuisance + 3] += 3.0
    lost = Fit(problem, q, *problem.jacobian(q), converged=True)
    assert lost.cost > before.cost + 100.0
    monkeypatch.setattr(candidates, "_whole", lambda *_: lost)
    (found,) = carried_to_the_end(before, [replace(good, fit=lost)])
    assert found.fit.cost < good.fit.cost + 1.0
    assert found.gain.chi2 > 20.0
