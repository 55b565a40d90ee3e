"""What the paper prints of its actuator tests (section 3), held against the shipped loops.

Three numbers of that section cannot be: the force at a deployment's start (2.987 N is seen in no loop), the 0.25 m from which on
the force is nearly constant (the shipped loops end at 0.14 m), and the curves of Figs. 7 to 13, which are printed as pictures only.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from identify.actuator.actuator_fit import ActuatorFit, transition_of
from identify.actuator.fit_actuator import fit_actuator
from identify.actuator.rate_order import choose_order
from identify.actuator.stiffness import effective_stiffness, friction_of
from identify.commands.fit_actuator import main
from identify.loops.loop_data import LoopData, area, free_start
from identify.loops.paper_recipe import straight_lines
from identify.loops.prepare import prepare
from measure import read_loop
from simulate.effects import HubInertia
from simulate.files.model_file import read_model
from simulate.law import steady_loop_area

DATASETS = Path(__file__).resolve().parents[3] / "datasets"
FILES = sorted((DATASETS / "demo" / "loops").glob("*.csv"))
PRINTED_FREQUENCIES_HZ = (0.2, 1.0, 3.0)
PRINTED_DISTANCE_N = 0.1
PRINTED_LASER_M = 10e-6
PRINTED_B_L_N = (2.51, 3.07)  # at -10 % and at +10 %


@pytest.fixture(scope="module")
def loops() -> list[LoopData]:
    return [prepare(read_loop(path)) for path in FILES]


@pytest.fixture(scope="module")
def fit(loops) -> ActuatorFit:
    return fit_actuator(loops, (HubInertia,))


def of(loops, frequency, stroke_mm):
    return next(d for d in loops if abs(d.frequency_Hz - frequency) < 0.02 and abs(2e3 * d.amplitude_m - stroke_mm) < 1.0)


def test_the_loops_run_at_the_three_frequencies_of_the_paper(loops):
    assert sorted(data.frequency_Hz for data in loops) == pytest.approx(np.repeat(PRINTED_FREQUENCIES_HZ, 2), rel=1e-3)


def test_the_laser_is_good_to_10_um_and_makes_no_reversal(loops):
    assert np.mean([data.elongation_sigma_m for data in loops]) == pytest.approx(PRINTED_LASER_M, rel=0.05)
    assert all(len(data.cycles.reversals) == 6 for data in loops)


def test_uncoiling_and_coiling_are_a_tenth_of_a_newton_apart(loops, fit):
    assert 2.0 * fit.half_height_N == pytest.approx(PRINTED_DISTANCE_N, abs=3e-3)
    slow = of(loops, 0.2, 80)
    middle = slow.used & (np.abs(slow.elongation_m - 0.1) < 0.01)
    away = slow.speed_m_per_s > 0.0
    assert slow.force_N[middle & ~away].mean() - slow.force_N[middle & away].mean() == pytest.approx(PRINTED_DISTANCE_N, abs=5e-3)


def test_ten_per_cent_to_each_side_of_the_stored_force_is_the_printed_range(fit):
    low, high = fit.estimates["b_l_N"].ci95
    least, most = PRINTED_B_L_N
    assert (0.9 * low, 0.9 * high) == pytest.approx((least, least), abs=5e-3)
    assert (1.1 * low, 1.1 * high) == pytest.approx((most, most), abs=5e-3)
    law = read_model(DATASETS / "prototype.toml").actuator
    b_l, b_u = np.asarray(law.b_l_N), np.asarray(law.b_u_N)
    assert (0.9 * b_l, 1.1 * b_l) == pytest.approx(PRINTED_B_L_N, abs=5e-3)
    assert b_u - b_l == pytest.approx(PRINTED_DISTANCE_N)


def test_equations_1_and_2_with_brackets_follow_the_measured_force_and_with_bars_run_away(loops, fit):
    data = of(loops, 0.2, 80)
    a_l, b_l, a_u, b_u, beta = fit.lines

    def rate(t, force, bars):
        u, v = np.interp(t, data.time_s, data.elongation_m), np.interp(t, data.time_s, data.speed_m_per_s)
        h_l, h_u, s = a_l * u + b_l, a_u * u + b_u, np.sign(v)
        h = ((h_u + h_l) * s - (h_u - h_l)) / 2
        return beta * abs(v) * (force - abs(h)) if bars else beta * v * (h - force * s)

    def solved(bars, end_s):
        times = data.time_s[data.time_s <= end_s]
        solution: Any = solve_ivp(rate, (0.0, times[-1]), [data.force_N[0]], "LSODA", times, args=(bars,), rtol=1e-8, atol=1e-8)
        return times, solution.y[0]

    times, force = solved(False, data.time_s[-1])
    left = (data.force_N[: len(times)] - force)[data.used]
    assert np.sqrt(np.mean(left**2)) < 1.5 * data.force_sigma_N
    _, away = solved(True, 3.0)
    assert np.abs(away[-1]) > 1e6


def test_straight_parts_lie_beside_the_asymptotes_by_slope_over_beta(loops, fit):
    slow = [of(loops, 0.2, 80)]
    found = straight_lines(slow)
    a_l, b_l, a_u, b_u, beta = fit.lines
    inertia = fit.effects[0].flat()[0] * (2 * np.pi * 0.2) ** 2
    assert found is not None
    assert found[[0, 2]] == pytest.approx([a_l + inertia, a_u + inertia], abs=0.03)
    at_centre = found[[1, 3]] + 0.1 * found[[0, 2]]
    assert at_centre == pytest.approx([a_l * 0.1 + b_l - a_l / beta, a_u * 0.1 + b_u + a_u / beta], abs=5e-4)


@pytest.mark.parametrize("stroke_mm", [20, 80])
def test_the_enclosed_area_is_that_of_flat_asymptotes_and_hardly_knows_beta(loops, fit, stroke_mm):
    data, stroke, beta = of(loops, 1.0, stroke_mm), stroke_mm / 1e3, float(fit.lines[4])
    assert area(data, data.force_N) == pytest.approx(steady_loop_area(2.0 * fit.half_height_N, stroke, beta), rel=0.02)
    one_per_cent = steady_loop_area(0.1, stroke, beta * (1 + stroke * beta / 200)) / steady_loop_area(0.1, stroke, beta)
    assert one_per_cent == pytest.approx(1.01, abs=5e-3)


def test_equal_areas_give_a_beta_and_the_joint_fit_a_far_better_one(loops, fit):
    assert fit.recipe is not None
    assert fit.recipe.statement.startswith("equal areas")
    modelled = sum(area(d, free_start(fit.recipe.lines, d)[1]) for d in loops)
    assert modelled == pytest.approx(sum(area(d, d.force_N) for d in loops), rel=1e-6)
    assert abs(fit.lines[4] - 400.0) < 4.0 * fit.estimates["beta_per_m"].stderr
    assert abs(fit.recipe.beta_per_m - 400.0) > abs(fit.lines[4] - 400.0)


def test_the_loop_turns_with_the_frequency_squared(loops, fit):
    slopes = {f: float(np.mean(lines[[0, 2]])) for f in PRINTED_FREQUENCIES_HZ if (lines := straight_lines([of(loops, f, 80)])) is not None}
    mass = fit.effects[0].flat()[0]
    for frequency in (1.0, 3.0):
        turned = slopes[frequency] - slopes[0.2]
        assert turned == pytest.approx(mass * (2 * np.pi) ** 2 * (frequency**2 - 0.04), abs=0.04)


def test_friction_is_dry_once_the_inertia_force_is_subtracted_and_not_before(loops, fit):
    assert friction_of(loops, fit.effects).word == "dry"
    assert friction_of(loops).word != "dry"


@pytest.mark.parametrize("frequency", PRINTED_FREQUENCIES_HZ)
def test_effective_stiffness_is_force_range_over_stroke_and_falls_with_the_stroke(loops, fit, frequency):
    seen = [effective_stiffness(of(loops, frequency, stroke), fit.effects) for stroke in (20, 80)]
    noise_N = 2 * 3.0 * 2e-3  # extremes of some hundred samples
    height, slope = 2 * fit.half_height_N, abs(fit.lines[0])
    for stiffness, stroke in zip(seen, (0.02, 0.08), strict=True):
        assert height / stroke < stiffness < (height + slope * stroke + noise_N) / stroke
    assert seen[0] > 3.0 * seen[1]


def test_polynomials_of_order_two_are_shown_whatever_order_is_taken(tmp_path, capsys, fit):
    out = tmp_path / "r.json"
    assert main([*map(str, FILES), "--effect", "hub-inertia", "--rate", "frequency", "--no-suggest", "--json", str(out)]) == 0
    rate = json.loads(out.read_text())["rate"]
    assert rate["order"] == 0
    assert {name: len(row) for name, row in rate["papers_order_2"].items()} == {"a_l": 3, "b_l": 3, "a_u": 3, "b_u": 3}
    papers = {name: np.polynomial.Polynomial(row) for name, row in rate["papers_order_2"].items()}
    for frequency in PRINTED_FREQUENCIES_HZ:
        for line, (a, b) in (("l", fit.lines[:2]), ("u", fit.lines[2:4])):
            level = papers[f"b_{line}"](frequency) + 0.1 * papers[f"a_{line}"](frequency)
            assert level == pytest.approx(b + 0.1 * a, abs=0.01)  # a slope of 3.5 N/m in the place of the inertia shifts it by a / beta
    assert "the paper's polynomials of order 2: a_l" in capsys.readouterr().out


def test_slopes_of_order_two_in_the_frequency_are_said_to_imitate_the_hubs_inertia(loops, fit):
    choice = choose_order(loops, (HubInertia,), "frequency_Hz")
    assert choice.imitated == ("hub-inertia.mass_kg",)
    assert "cannot be told from the lines" in choice.sentences(0)[1]
    bare = choose_order(loops, (), "frequency_Hz")
    assert bare.papers is not None
    turned = np.polynomial.Polynomial(bare.papers["a_l"])
    assert turned(3.0) - turned(0.2) == pytest.approx(fit.effects[0].flat()[0] * (2 * np.pi) ** 2 * 8.96, rel=0.02)


def test_loops_that_end_at_14_cm_claim_nothing_about_a_quarter_of_a_metre(loops, fit):
    level = transition_of(fit, loops)
    assert level.elongation_m.max() < 0.15
    assert "the shortest seen" in level.sentence
