"""The force law against its differential form, its loop area, and what the paper prints."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from simulate.effects import HubInertia, ViscousFriction
from simulate.law import force_rate, restoring_force, steady_loop_area
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])


def sine(n=4001, amplitude=0.05, frequency=1.0, cycles=2):
    t = np.linspace(0.0, cycles / frequency, n)
    w = 2 * np.pi * frequency
    return t, amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)


@pytest.mark.parametrize(("end", "slope", "intercept"), [(0.05, -0.25, 2.79), (-0.05, -0.3, 2.89)])
def test_closed_form_agrees_with_an_ode_solver_to_1e_9(end, slope, intercept):
    s = np.sign(end)
    u = np.linspace(0.0, end, 300)

    def rate(x, r):
        return s * force_rate(s, r, slope * x + intercept, slope * x + intercept, 400.0)

    solved = solve_ivp(rate, (0.0, end), [2.987], method="DOP853", t_eval=u, rtol=1e-12, atol=1e-13)
    assert np.max(np.abs(solved.y[0] - restoring_force(u, 0.0, 2.987, slope, intercept, 400.0))) < 1e-9


def test_loop_kernel_is_the_closed_form_branch_by_branch():
    t, u, v, a = sine()
    force = loop_force(LINES, t, u, v, a, 2.987)
    top = int(np.argmax(u[:1500]))
    first = restoring_force(u[: top + 1], 0.0, 2.987, LINES[0], LINES[1], LINES[4])
    assert np.max(np.abs(force[: top + 1] - first)) < 1e-12
    down = restoring_force(u[top:1501], u[top], force[top], LINES[2], LINES[3], LINES[4])
    assert np.max(np.abs(force[top:1501] - down)) < 1e-12


def test_uncoiling_settles_on_the_lower_asymptote_shifted_by_its_slope_over_beta():
    u = np.linspace(0.0, 0.2, 50)
    force = restoring_force(u, 0.0, 2.987, -0.25, 2.79, 400.0)
    assert force[-1] == pytest.approx(-0.25 * 0.2 + 2.79 + 0.25 / 400.0, abs=1e-12)


def test_coiling_settles_on_the_upper_asymptote():
    u = np.linspace(0.2, 0.0, 50)
    assert restoring_force(u, 0.2, 2.7, -0.3, 2.89, 400.0)[-1] == pytest.approx(2.89 - 0.3 / 400.0, abs=1e-12)


def test_steady_loop_has_the_area_of_the_closed_formula_and_runs_anticlockwise():
    flat = np.array([0.0, 2.79, 0.0, 2.89, 400.0])
    t, u, v, a = sine(n=400_001, amplitude=0.01, cycles=4)
    force = loop_force(flat, t, u, v, a, 2.84)
    last = slice(300_000, None)
    area = -np.trapezoid(force[last], u[last])
    assert area > 0
    assert area == pytest.approx(steady_loop_area(0.1, 0.02, 400.0), rel=1e-6)


def test_the_printed_form_of_equation_1_runs_away_from_both_asymptotes():
    # with bars instead of brackets, R' = beta |u'| (R - h) on both branches: the sign that pulls R back is lost
    def printed(x, r):
        return 400.0 * np.abs(r - (-0.25 * x + 2.79))

    solved = solve_ivp(printed, (0.0, 0.2), [2.987], method="LSODA", rtol=1e-8)
    assert solved.y[0, -1] > 1e16
    settled = restoring_force(0.2, 0.0, 2.987, -0.25, 2.79, 400.0)
    assert 2.7 < float(settled) < 2.8


def test_bracket_form_brings_the_force_back_into_the_band_from_outside():
    assert restoring_force(0.1, 0.0, 10.0, 0.0, 2.79, 400.0) == pytest.approx(2.79)
    assert restoring_force(-0.1, 0.0, -5.0, 0.0, 2.89, 400.0) == pytest.approx(2.89)


def test_hub_inertia_turns_the_loop_with_frequency_squared():
    slopes = []
    for frequency in (1.0, 3.0):
        t, u, v, a = sine(frequency=frequency)
        added = loop_force(LINES, t, u, v, a, 2.9, (HubInertia(0.05),)) - loop_force(LINES, t, u, v, a, 2.9)
        slopes.append(np.polyfit(u, added, 1)[0])
    assert slopes[1] / slopes[0] == pytest.approx(9.0)
    assert slopes[0] == pytest.approx(0.05 * (2 * np.pi) ** 2)


def test_viscous_friction_adds_the_area_of_an_ellipse():
    t, u, v, a = sine(n=20_001, cycles=1)
    added = loop_force(LINES, t, u, v, a, 2.9, (ViscousFriction(0.4),)) - loop_force(LINES, t, u, v, a, 2.9)
    assert -np.trapezoid(added, u) == pytest.approx(np.pi * 0.4 * 2 * np.pi * 0.05**2, rel=1e-6)


@settings(max_examples=60, deadline=None)
@given(
    steps=st.lists(st.floats(-0.02, 0.02), min_size=1, max_size=40),
    beta=st.floats(10.0, 5000.0),
    start=st.floats(0.0, 6.0),
    split=st.integers(2, 7),
)
def test_force_does_not_depend_on_how_finely_a_path_is_sampled(steps, beta, start, split):
    lines = np.array([-0.25, 2.79, -0.3, 2.89, beta])
    corners = np.concatenate([[0.0], np.cumsum(steps)])
    fine = np.concatenate([[0.0], *(np.linspace(a, b, split + 1)[1:] for a, b in pairwise(corners))])

    def force(u):
        zero = np.zeros_like(u)
        return loop_force(lines, np.arange(len(u)) * 1.0, u, zero, zero, start)

    assert np.max(np.abs(force(fine)[::split] - force(corners))) < 1e-9 * max(1.0, start)


def test_area_of_a_steady_loop_hardly_depends_on_beta():
    areas = [steady_loop_area(0.1, 0.1, beta) for beta in (400.0, 480.0)]
    assert abs(areas[1] / areas[0] - 1) < 0.01
