"""Parameters in scales: values and places undo each other, bounds and slopes follow, and runs find their own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_loops import loop_data, triangles

from identify.actuator.rates_and_strokes import frequency_amplitude_correlation
from identify.campaign.prepared import LoopRun, beta_bounds, zero_parameters
from identify.campaign.run import Run
from identify.estimation.parameterisation import Unknowns, base_parameters, shifted
from identify.estimation.parameters import Change, Parameter, changed, lines_of, rate_parameters
from identify.estimation.rate import RatePolynomials
from identify.report.loop_result import closure, drift_per_cycle
from measure.tables.loop import Loop
from simulate.effects import HubInertia, ViscousFriction
from simulate.model.model import Actuator, Model

LINEAR = Parameter("a", 0.5, np.inf, -4.0, 4.0, start=2.0)
LOG = Parameter("beta_per_m", 80.0, np.inf, -9.0, 9.0, start=400.0, log=True)
MODEL = Model(Actuator(-0.04, 2.8, -0.03, 2.9, 400.0, 3.0), name="actuator")


@given(st.floats(-5.0, 5.0))
def test_the_place_of_a_value_undoes_the_value_of_a_place(q):
    for parameter in (LINEAR, LOG):
        assert parameter.place(parameter.value(q)) == pytest.approx(q, abs=1e-9)
        step = 1e-6
        slope = (parameter.value(q + step) - parameter.value(q - step)) / (2.0 * step)
        assert parameter.slope(q) == pytest.approx(slope, rel=1e-5)


def test_a_linear_and_a_logarithmic_parameter_have_these_values():
    assert LINEAR.value(3.0) == 3.5
    assert LOG.value(5.0) == pytest.approx(400.0 * np.e)
    assert LOG.shift(-5.0) == pytest.approx(400.0 / np.e - 400.0)
    assert LOG.place_of_shift(-400.0) == -np.inf
    assert LOG.place_of_shift(np.inf) == np.inf


def test_a_user_holds_bounds_and_leaves_parameters():
    first, second = changed([LINEAR, LOG], [Change("a", held=True, low=1.0), Change("a", high=4.0), Change("unknown", held=True)])
    assert (first.low, first.high, first.vary) == (-2.0, 4.0, False)
    assert second == LOG


def test_the_scales_of_the_law_are_parts_of_its_forces_and_beta_keeps_to_what_loops_tell():
    made = base_parameters(MODEL, (40.0, 4000.0))
    stroke = 100.0 / 400.0
    assert [one.scale for one in made] == pytest.approx([0.3 / stroke, 0.15, 0.3 / stroke, 0.15, 80.0, 0.15])
    assert [one.start for one in made] == pytest.approx([-0.04, 2.8, -0.03, 2.9, 400.0, 3.0])
    assert made[4].value(made[4].low) == pytest.approx(40.0)
    assert made[4].value(made[4].high) == pytest.approx(4000.0)
    assert [np.isfinite(one.spread) for one in made] == [False, False, False, False, False, True]
    assert all(one.spread == made[5].spread for one in base_parameters(MODEL, None))
    assert [one.log for one in made] == [False, False, False, False, True, False]


def test_a_law_is_shifted_number_by_number_and_six_legs_alike():
    six = Model(Actuator(-0.04, (2.0, 2.1, 2.2, 2.3, 2.4, 2.5), -0.03, 2.9, 400.0, 3.0), name="six")
    moved = shifted(six, np.array([0.0, 0.5, 0.0, -0.1, 100.0, 0.0])).actuator
    assert moved.b_l_N == pytest.approx((2.5, 2.6, 2.7, 2.8, 2.9, 3.0))
    assert (moved.a_l_N_per_m, moved.b_u_N, moved.beta_per_m, moved.initial_force_N) == pytest.approx((-0.04, 2.8, 500.0, 3.0))
    assert lines_of(six)[1] == pytest.approx(2.25)


def test_polynomials_in_the_scaled_rate_are_the_same_in_the_rate_itself():
    rate = RatePolynomials("frequency_Hz", 2, middle=3.0, half=2.0)
    own = rate.unscaled(np.array([1.0, -2.0, 0.5]))
    for frequency in (1.0, 3.0, 4.4):
        z = (frequency - 3.0) / 2.0
        assert np.polynomial.polynomial.polyval(frequency, own) == pytest.approx(1.0 - 2.0 * z + 0.5 * z**2)
    assert [one.name for one in rate_parameters(base_parameters(MODEL, None)[:1], 2)] == ["rate.a_l_N_per_m[1]", "rate.a_l_N_per_m[2]"]


HALF = 40
U = triangles(4, HALF)


def loop(name="loop", step_s=0.01, force=None, size=1.0):
    data = loop_data(size * U, 2.0 + U if force is None else force, half=HALF, step_s=step_s, name=name)
    return LoopRun(Run(Loop(data.time_s, data.elongation_m, data.force_N, name=name)), MODEL, data)


def test_the_rate_of_a_loop_is_scaled_to_the_rates_that_were_seen():
    data = loop().data
    assert RatePolynomials("frequency_Hz", 1, 1.0, 0.5).z_of(data) == pytest.approx((1.25 - 1.0) / 0.5)
    speed = 2.0 * np.pi * 1.25 * 0.05
    assert RatePolynomials("speed_m_per_s", 1, 0.1, 2.0).z_of(data) == pytest.approx((speed - 0.1) / 2.0)
    assert RatePolynomials().z_of(data) == 0.0


def test_lines_follow_the_rate_and_return_to_the_model_at_its_middle():
    rate = RatePolynomials("frequency_Hz", 2, 1.0, 0.5)
    unknowns = Unknowns(MODEL, (), (loop(),), rate=rate)
    q = np.zeros(len(unknowns.parameters))
    q[unknowns.first_rate : unknowns.first_rate + 2] = 0.3, -0.2
    scale = unknowns.scales[unknowns.first_rate]
    assert unknowns.lines_at(q) == pytest.approx(lines_of(MODEL))
    assert unknowns.lines_at(q, 0.5)[0] == pytest.approx(-0.04 + scale * (0.3 * 0.5 - 0.2 * 0.25))
    assert unknowns.lines_at(q, 0.5)[1:] == pytest.approx(lines_of(MODEL)[1:])
    of_frequency = unknowns.polynomials_at(q)["a_l"]
    assert np.polynomial.polynomial.polyval(1.25, of_frequency) == pytest.approx(unknowns.lines_at(q, 0.5)[0])


def test_zeros_of_loops_alone_count_from_their_mean_and_drifts_do_not():
    loops = (loop("one"), loop("other", step_s=0.02))
    unknowns = Unknowns(MODEL, (), loops, own_zeros=True)
    q = np.zeros(len(unknowns.parameters))
    own = slice(unknowns.first_zero, unknowns.first_effect)
    assert own.stop - own.start == 4
    q[own] = 1.0, 3.0, 5.0, 7.0
    zeros, drifts = unknowns.zeros_at(q)
    one = 0.05 * 2.1
    assert zeros == pytest.approx([-one, one])
    assert drifts == pytest.approx([5.0 * one / 3.2, 7.0 * one / 6.4])
    assert [unknowns.owner_of(k) for k in (0, own.start, own.stop - 1)] == [None, -1, -1]
    assert Unknowns(MODEL, (), loops[:1], own_zeros=True).zeros_at(q[:-2])[0] != 0.0


def test_a_zero_at_will_has_the_size_of_half_a_loop():
    zero, drift = zero_parameters([loop()], at_will=True)
    assert zero.scale == pytest.approx(0.05)
    assert drift.scale == pytest.approx(0.05 / 3.2)
    assert zero.spread > 1e3
    assert drift.spread == 1.0
    assert (zero.name, drift.name) == ("loop.zero_N", "loop.drift_N_per_s")


def test_beta_is_told_between_a_third_of_the_stroke_and_a_fiftieth_of_a_sample():
    low, high = beta_bounds([loop().data, loop(size=0.5).data])
    assert low == pytest.approx(0.3 / 0.1)
    assert high == pytest.approx(3.0 / (0.05 / 40.0 / 50.0))


def test_effects_stand_behind_the_law_in_their_order():
    unknowns = Unknowns(MODEL, (), (loop(),), effects=(HubInertia(0.2), ViscousFriction(0.1)))
    q = np.zeros(len(unknowns.parameters))
    rows = unknowns.rows_of("viscous-friction")
    assert unknowns.rows_of("hub-inertia").tolist() == [unknowns.first_effect]
    q[rows[0]] = 2.0
    hub, friction = unknowns.effects_at(q)
    assert hub.flat()[0] == 0.2
    assert friction.flat()[0] == pytest.approx(0.1 + 2.0 * unknowns.scales[rows[0]])
    q[rows[0]] = -1e9
    assert unknowns.effects_at(q)[1].flat()[0] == unknowns.parameters[rows[0]].value(unknowns.parameters[rows[0]].low)
    assert unknowns.index_of("hub-inertia.mass_kg") == unknowns.first_effect


def test_a_drift_is_told_per_cycle_and_a_loop_closes_by_it():
    drifting = loop(force=2.0 + U + 0.03 * np.arange(len(U)) / (2 * HALF)).data
    assert drift_per_cycle(drifting, drifting.force_N) == pytest.approx(0.03)
    assert closure(drifting) == pytest.approx(0.03)
    assert drift_per_cycle(drifting, drifting.elongation_m) == pytest.approx(0.0, abs=1e-12)


def test_frequencies_and_strokes_that_grow_together_are_said_to():
    loops = [loop(step_s=0.01 / k, size=float(k)).data for k in (1, 2, 3, 4)]
    assert frequency_amplitude_correlation(loops) == pytest.approx(1.0, abs=0.05)
    assert frequency_amplitude_correlation(loops[::-1]) == pytest.approx(1.0, abs=0.05)
