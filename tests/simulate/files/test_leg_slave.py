"""The leg that runs inside an FMU, without one: where a step turns round, and what the force does on both parts of it."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simulate.files.leg_fmu import law_of
from simulate.files.leg_slave import UNITS, Leg, turning_point
from simulate.law import restoring_force
from simulate.model.rig import per_leg


@pytest.mark.parametrize("start_slope", [0.3, 2.0, -0.5, -3.0])
@pytest.mark.parametrize("end_slope", [0.4, -0.2, -2.5, 1.0])
@pytest.mark.parametrize("end", [1.0, 1.2, 0.7])
def test_a_step_turns_where_its_cubic_has_no_slope(start_slope, end_slope, end):
    """By the roots of the derivative of Hermite's cubic."""
    start = 1.0
    found = turning_point(start, end, start_slope, end_slope)
    if start_slope * end_slope >= 0.0:
        assert found == end
        return
    way = end - start
    cubic = np.polynomial.Polynomial([start, start_slope, 3 * way - 2 * start_slope - end_slope, start_slope + end_slope - 2 * way])
    roots = [root.real for root in cubic.deriv().roots() if abs(root.imag) < 1e-12 and 0.0 <= root.real <= 1.0]
    assert len(roots) == 1
    assert found == pytest.approx(cubic(roots[0]))


def test_a_step_that_comes_to_rest_or_starts_from_it_does_not_turn():
    for slopes in ((0.0, 1.0), (1.0, 0.0), (0.0, 0.0)):
        assert turning_point(0.0, 0.5, *slopes) == 0.5


LAW = {"a_l_N_per_m": -0.2, "b_l_N": 2.8, "a_u_N_per_m": -0.1, "b_u_N": 2.95, "beta_per_m": 300.0}


@pytest.fixture
def leg(tmp_path):
    parameters = {name: (value, "N", "what it is") for name, value in {**LAW, "initial_force_N": 2.9}.items()}
    inputs = {"u_m": ("m", "elongation"), "speed_m_per_s": ("m/s", "its rate")}
    about = {"description": "a leg", "version": "1", "parameters": parameters, "inputs": inputs, "output": "force"}
    (tmp_path / "law.json").write_text(json.dumps(about))
    made = Leg(instance_name="leg", resources=str(tmp_path))
    made.u_m = made.speed_m_per_s = 0.0
    made.exit_initialization_mode()
    return made


def step(leg, u, speed, size=0.1):
    leg.u_m, leg.speed_m_per_s = u, speed
    leg.do_step(leg.time, size)
    return leg.last_force_N


def force(u, since, at, side):
    return float(restoring_force(u, since, at, LAW[f"a_{side}_N_per_m"], LAW[f"b_{side}_N"], LAW["beta_per_m"]))


def test_the_force_follows_the_lower_line_outwards_and_the_upper_one_back(leg):
    assert leg.last_force_N == 2.9
    out = step(leg, 0.02, 0.0)
    assert out == pytest.approx(force(0.02, 0.0, 2.9, "l"))
    assert step(leg, 0.02, 0.0) == out
    assert step(leg, 0.015, 0.0) == pytest.approx(force(0.015, 0.02, out, "u"))
    assert leg.time == pytest.approx(0.3)


def test_within_a_step_that_turns_the_leg_goes_out_and_back(leg):
    """From 0.02 m on at 0.2 m/s, back there with -0.2 m/s a tenth of a second later: 5 mm farther in between."""
    at = step(leg, 0.02, 0.2)
    middle = turning_point(0.02, 0.02, 0.02, -0.02)
    assert middle == pytest.approx(0.025)
    expected = force(0.02, middle, force(middle, 0.02, at, "l"), "u")
    assert step(leg, 0.02, -0.2) == pytest.approx(expected)


def test_a_state_that_is_brought_back_goes_the_same_way(leg):
    step(leg, 0.02, 0.2)
    kept = leg._get_fmu_state()
    first = [step(leg, u, v) for u, v in ((0.03, -0.1), (0.01, -0.2))]
    leg._set_fmu_state(kept)
    assert [step(leg, u, v) for u, v in ((0.03, -0.1), (0.01, -0.2))] == first
    leg.exit_initialization_mode()
    assert leg.last_force_N == 2.9


def test_units_are_made_of_the_base_units():
    assert UNITS == {
        "s": {"s": 1}, "m": {"m": 1}, "m/s": {"m": 1, "s": -1}, "1/m": {"m": -1},
        "N": {"kg": 1, "m": 1, "s": -2}, "N/m": {"kg": 1, "s": -2},
    }  # fmt: skip


def test_what_an_fmu_holds_is_the_law_of_a_leg_by_its_name_and_says_what_it_leaves_out(prototype, lopsided):
    alike, one = law_of(prototype, None), law_of(lopsided, 3)
    assert alike["description"] == "force law of a leg of prototype; without hub-inertia (0.487), viscous-friction (0.513)"
    assert str(one["description"]).startswith("force law of leg 3 of lopsided; without hub-inertia (0.2)")
    assert law_of(replace(prototype, effects=()), 1)["description"] == "force law of leg 1 of prototype"
    parameters: Any = one["parameters"]
    expected = {name: per_leg(getattr(lopsided.actuator, name))[2] for name in parameters}
    assert {name: value for name, (value, _, _) in parameters.items()} == pytest.approx(expected)
    assert {name: unit for name, (_, unit, _) in parameters.items()} == {
        "a_l_N_per_m": "N/m", "b_l_N": "N", "a_u_N_per_m": "N/m", "b_u_N": "N", "beta_per_m": "1/m", "initial_force_N": "N",
    }  # fmt: skip
