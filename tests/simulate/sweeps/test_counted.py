"""Counts, intervals, levels and tables of a sweep whose responses are given, not simulated."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import binom, norm

from measure.common.errors import InputError
from simulate.model import responses
from simulate.model.measures import Measures, measured, unit_of
from simulate.sweeps import tolerance
from simulate.sweeps.designs import Design, design_of
from simulate.sweeps.factors import factor_of, factors_of
from simulate.sweeps.rare_events import RareFailure
from simulate.sweeps.result import GRID, SweepResult
from simulate.sweeps.step_search import ERROR_DEG, StepChoice
from simulate.sweeps.sweep import RunCounts, Sweep, count_runs, wilson
from simulate.sweeps.tolerance import gradient_deg_per_N, spread_N, tolerance_of, tried_spread


def answers_of(theta_deg, before_deg=None, diverged=()):
    rows = np.full((len(theta_deg), responses.COUNT), np.nan)
    rows[:, responses.THETA_Z] = np.radians(theta_deg)
    rows[:, responses.BEFORE_STOP] = np.radians(theta_deg if before_deg is None else before_deg)
    for run in diverged:
        rows[run], rows[run, responses.DIVERGED] = np.nan, 0.1
    return rows


def test_a_run_fails_on_either_side_beyond_the_angle_and_one_that_diverged_is_no_failure():
    counted = count_runs(answers_of([31.0, -31.0, 29.0, 0.0, 99.0], [31.0, 0.0, 0.0, 0.0, 0.0], diverged=[4]), 30.0)
    assert counted == RunCounts(5, 1, 2, 1)
    assert counted.failed_percent == 50.0
    assert counted.failed_before_stop_percent == 25.0
    assert counted + counted == RunCounts(10, 2, 4, 2)
    assert np.isnan(RunCounts(3, 3, 0).failed_percent)


@pytest.mark.parametrize(("n", "p"), [(20, 0.5), (50, 0.1), (400, 0.02)])
def test_an_interval_of_a_count_holds_its_probability_about_as_often_as_it_says(n, p):
    inside = [low < p < high for low, high in (wilson(k, n) for k in range(n + 1))]
    assert np.sum(binom.pmf(np.arange(n + 1), n, p)[inside]) == pytest.approx(0.95, abs=0.03)


def test_an_interval_of_a_count_solves_the_score_equation_at_both_ends():
    for end in wilson(7, 40):
        assert abs(7 / 40 - end) == pytest.approx(norm.isf(0.025) * np.sqrt(end * (1.0 - end) / 40.0))
    assert wilson(0, 10)[0] == 0.0
    assert wilson(10, 10)[1] == pytest.approx(1.0)
    assert np.isnan(wilson(0, 0)).all()
    assert RunCounts(41, 1, 7).interval_percent() == pytest.approx([100.0 * end for end in wilson(7, 40)])


def made(prototype, theta_deg, words, design=None):
    factors = tuple(factors_of(prototype, words))
    sweep = Sweep(prototype, factors, design or design_of("full", len(factors), None, 0))
    half = len(theta_deg) // 2
    pieces = [answers_of(theta_deg[:half]), answers_of(theta_deg[half:])]
    return SweepResult(sweep, pieces, "theta_z_deg", 30.0)


WORDS = ["platform.mass_kg=+-10%", "actuator.stored_force_N[0]=+-10%", "actuator.stored_force_N[1]=+-10%"]


def signs(factors):
    design = design_of("full", factors, None, 0)
    return design.piece(0, design.runs)


def test_the_regression_of_a_result_is_that_of_its_pieces_in_their_order(prototype):
    coded = signs(3)
    result = made(prototype, 1.0 + 2.0 * coded[:, 0] - 40.0 * coded[:, 2] + 0.5 * coded[:, 0] * coded[:, 1] * coded[:, 2], WORDS)
    assert result.coefficients == pytest.approx({"1": 1.0, "A": 2.0, "B": 0.0, "C": -40.0, "AB": 0.0, "AC": 0.0, "BC": 0.0, "ABC": 0.5})
    assert result.largest_pair == (0, 2)
    assert result.limit == 30.0
    assert result.counts == RunCounts(8, 0, 8, 8)
    columns = result.coefficient_columns()
    assert columns["name"][:3] == ["C", "A", "1"]
    assert columns["coefficient_deg"][:2] == pytest.approx([-40.0, 2.0])
    assert columns["variability_percent"][0] == pytest.approx(100.0 * 1600.0 / 1604.25)
    assert result._left_over() == pytest.approx(0.0, abs=1e-9)


def test_what_a_regression_of_three_factors_cannot_say_is_left_over(prototype):
    words = [*WORDS, "actuator.stored_force_N[2]=+-10%"]
    coded = signs(4)
    theta = 3.0 * coded[:, 0] + 0.7 * np.prod(coded, axis=1)
    assert made(prototype, theta, words)._left_over() == pytest.approx(0.7)
    theta[5] = np.nan
    assert made(prototype, theta, words)._left_over() < 1.0


def test_a_histogram_counts_every_run_once_from_the_smallest_to_the_largest(prototype):
    theta = np.array([0.0, 1.0, 2.0, 60.0, 60.0, np.nan, 30.2, 15.0])
    counts, edges = made(prototype, theta, WORDS).histogram()
    assert counts.sum() == 7
    assert edges[[0, -1]] == pytest.approx([0.0, 60.0])
    assert len(edges) == len(counts) + 1 == 61
    assert counts[[0, 1, 2, 15, 30, 59]].tolist() == [1, 1, 1, 1, 1, 2]
    flat, ends = made(prototype, np.full(8, 5.0), WORDS).histogram()
    assert flat.sum() == 8
    assert ends[[0, -1]] == pytest.approx([5.0, 6.0])


def linear(result, slopes, monkeypatch):
    """The result of a rig that answers linearly at any levels."""
    monkeypatch.setattr(Sweep, "responses_at", lambda self, coded: answers_of(coded @ slopes))
    return result


def test_a_map_has_the_first_factor_along_its_rows_and_the_others_in_their_middle(prototype, monkeypatch):
    result = linear(made(prototype, signs(3)[:, 0], WORDS), [2.0, 5.0, 100.0], monkeypatch)
    shown = result.map(0, 1)
    levels = np.linspace(-1.0, 1.0, GRID)
    assert shown == pytest.approx(2.0 * levels[:, None] + 5.0 * levels)


def test_on_fresh_runs_a_regression_errs_by_what_it_has_not_seen(prototype, monkeypatch):
    """Levels are even from -1 to 1: of variance 1/3."""
    result = linear(made(prototype, 6.0 * signs(3)[:, 0], WORDS), [6.0, 3.0, 0.0], monkeypatch)
    fresh = result.fresh()
    assert fresh["runs"] == 256
    assert fresh["rms"] == pytest.approx(3.0 / np.sqrt(3.0), rel=0.1)
    assert 2.7 < fresh["largest"] <= 3.0
    assert fresh["rms_of_response"] == pytest.approx(np.sqrt(45.0 / 3.0), rel=0.1)


def test_runs_that_were_chosen_have_no_interval_and_drawn_ones_have(prototype):
    assert made(prototype, signs(3)[:, 0], WORDS)._is_chosen
    assert not made(prototype, np.zeros(8), WORDS, Design("random", 8, 3))._is_chosen


def test_a_step_is_fine_enough_where_all_runs_that_are_not_sensitive_agree():
    sweep: Any = SimpleNamespace(pace=SimpleNamespace(frame=1e-4))
    fine, coarse = 0.9 * ERROR_DEG, 1.1 * ERROR_DEG
    growth = np.array([1.0, 100.0, 99.0])
    assert StepChoice(sweep, np.array([fine, fine, coarse]), growth, 99.5).good is False
    choice = StepChoice(sweep, np.array([fine, coarse, ERROR_DEG]), growth, 99.5)
    assert choice.good
    assert choice.sensitive.tolist() == [False, True, False]
    assert choice.report["largest_error_deg"] == ERROR_DEG
    assert choice.report["largest_error_of_sensitive_deg"] == coarse
    assert choice.report["sensitive_probes"] == 1
    assert StepChoice(sweep, np.array([9.0]), np.array([np.nan]), 1.0).sensitive.all()


SLOPES = np.array([3.0, -1.0, 2.0, 0.5, -4.0, 1.0])


@pytest.fixture
def turns_linearly(monkeypatch):
    """A rig whose rotation is linear in the stored forces, and 2 deg as it is."""

    def theta(model, shifts):
        return 2.0 + np.asarray(shifts) @ SLOPES

    monkeypatch.setattr(tolerance, "theta_z_deg", theta)


def test_a_tolerance_keeps_the_angle_with_its_probability(prototype, turns_linearly):
    assert gradient_deg_per_N(prototype) == pytest.approx(SLOPES)
    spread = spread_N(SLOPES, 30.0, 0.9)
    assert 2.0 * norm.sf(30.0 / (spread * np.linalg.norm(SLOPES))) == pytest.approx(0.1)
    assert spread_N(np.zeros(6), 30.0, 0.9) == np.inf
    tried = tried_spread(prototype, spread, 30.0, 0.9)
    assert tried.share == pytest.approx(0.9, abs=0.05)
    assert tried.angle_deg == pytest.approx(30.0, rel=0.15)
    assert tried.interval[0] < tried.share < tried.interval[1]


def test_the_leg_that_turns_most_is_named_and_adjusted_until_the_rig_stands_still(prototype, turns_linearly):
    said = tolerance_of(prototype, (5.0, 30.0), 0.95)
    assert said["most_sensitive_leg"] == 5
    assert said["adjust"] == pytest.approx({"leg": 5, "by_N": 0.5, "theta_z_before_deg": 2.0, "theta_z_after_deg": 0.0})
    assert said["stored_force_spread_N"]["30"] == pytest.approx(6.0 * said["stored_force_spread_N"]["5"])
    middle = np.sqrt(said["stored_force_spread_N"]["30"] * said["stored_force_spread_N"]["5"])
    assert [point["spread_N"] / middle for point in said["curve"]] == pytest.approx([0.25, 0.5, 1.0, 2.0, 4.0])
    assert said["sort"] is None


def test_legs_are_sorted_so_that_what_they_differ_by_turns_least(lopsided, turns_linearly):
    found = tolerance_of(lopsided, (30.0,), 0.95)["sort"]
    force = np.array([2.7, 2.8, 2.75, 2.85, 2.9, 2.65])
    order = np.array(found["order"]) - 1
    assert sorted(order) == list(range(6))
    assert found["theta_z_after_deg"] == pytest.approx(2.0 + (force[order] - force) @ SLOPES)
    assert abs((force[order] - force.mean()) @ SLOPES) < 0.02


def test_levels_of_a_factor_are_read_in_all_four_ways(prototype):
    mass = prototype.platform.mass_kg
    for levels, low, high, normal in (
        ("+-10%", 0.9 * mass, 1.1 * mass, False),
        ("+-0.05", mass - 0.05, mass + 0.05, False),
        ("0.5..0.7", 0.5, 0.7, False),
        ("sigma:1%", 0.99 * mass, 1.01 * mass, True),
    ):
        factor = factor_of(prototype, f"platform.mass_kg={levels}", "A")
        assert (factor.low, factor.high, factor.normal) == (pytest.approx(low), pytest.approx(high), normal)
        assert factor.value(-1.0) == pytest.approx(low)
        assert factor.value(0.5) == pytest.approx(low + 0.75 * (high - low))
        assert factor.farthest == (6.0 if normal else 1.0)


def test_a_negative_value_has_its_levels_in_order(prototype):
    factor = factor_of(prototype, "actuator.a_l_N_per_m=+-10%", "A")
    assert (factor.low, factor.high) == (pytest.approx(-0.04114), pytest.approx(-0.03366))


def test_as_many_factors_as_letters_are_taken_and_each_key_once(prototype):
    words = [f"actuator.{name}[{leg}]=+-1%" for leg in range(6) for name in ("stored_force_N", "a_l_N_per_m", "beta_per_m")]
    assert len(factors_of(prototype, words)) == 18
    assert factors_of(prototype, words[:3], lettered=2)[0].letter == "C"
    assert factors_of(prototype, words[:7], lettered=18)[-1].letter == "Z"
    with pytest.raises(InputError, match="26 factors; at most 25"):
        factors_of(prototype, words[:8], lettered=18)
    with pytest.raises(InputError, match="given twice"):
        factors_of(prototype, [words[0], words[0]])


@pytest.mark.parametrize(("factors", "runs"), [(3, 4), (7, 8), (5, 16), (6, 32)])
def test_a_fractional_design_of_few_runs_keeps_main_effects_apart(factors, runs):
    coded = design_of("fractional", factors, runs, 0).piece(0, runs)
    assert coded.T @ coded == pytest.approx(runs * np.eye(factors))


def test_of_six_factors_in_sixteen_runs_no_main_effect_is_mixed_with_a_pair():
    coded = design_of("fractional", 6, 16, 0).piece(0, 16)
    pairs = np.array([coded[:, i] * coded[:, j] for i in range(6) for j in range(i)])
    assert np.abs(pairs @ coded).max() == 0.0


def test_a_normal_factor_is_drawn_normally_and_the_others_evenly():
    design = design_of("random", 2, 4096, 1, normal=(1,))
    even, normal = design.piece(0, 4096).T
    assert np.std(even) == pytest.approx(1.0 / np.sqrt(3.0), rel=0.03)
    assert np.std(normal) == pytest.approx(1.0, rel=0.04)
    assert np.mean(np.abs(normal) < 1.0) == pytest.approx(0.683, abs=0.02)


def test_the_interval_of_a_rare_failure_is_lognormal_and_ends_at_one():
    low, high = RareFailure(1e-4, 0.3, (), 1, True).interval
    assert low * high == pytest.approx(1e-8)
    assert np.log(high / low) == pytest.approx(2.0 * norm.isf(0.025) * np.sqrt(np.log(1.09)))
    assert RareFailure(0.9, 1.0, (), 1, True).interval[1] == 1.0


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("damping_N_s_per_m", (1, -1, 1, 0)),
        ("mass_kg", (0, 0, 0, 1)),
        ("acceleration_m_per_s2", (0, 1, -2, 0)),
        ("cutoff_Hz", (0, 0, -1, 0)),
        ("inertia_kg_m2[3]", (0, 2, 0, 1)),
        ("share", (0, 0, 0, 0)),
        ("theta_z_rad", (0, 0, 0, 0)),
    ],
)
def test_the_unit_of_a_parameter_is_at_the_end_of_its_name(name, unit):
    assert unit_of(name) == unit


def test_sizes_of_another_rig_follow_force_length_time_and_the_mass_that_these_move():
    rig = Measures(force=8.0, length=2.0, time=3.0)
    assert rig.mass == 36.0
    assert rig.of((1, -1, 1, 0)) == 12.0
    assert rig.of((0, 2, 0, 1)) == 144.0
    other = measured(5.6, 1.2, 0.8)
    assert (other.force, other.length, other.time) == pytest.approx((2.0, 3.0, 4.0))
