"""What is said where asymptotes follow the speed: how a frequency became a speed, and when legs are faster than any loop was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from measure.common.arrays import Array
from simulate.deployment.deploy import warnings_of_rates
from simulate.deployment.rate_range import assumption_of, beyond_the_loops
from simulate.deployment.result import Deployment
from simulate.effects import RateDependentAsymptotes
from simulate.kernel.layout import SAMPLE_ELONGATION, SAMPLE_POSE, SAMPLE_SIZE
from simulate.model.rig import Rate

TIME = np.arange(11) / 10.0
AMPLITUDE_M = 0.05


def frequencies(*strokes):
    f = tuple(float(k + 1) for k in range(len(strokes)))
    speeds = tuple(np.pi * one * stroke for one, stroke in zip(f, strokes, strict=True))
    return Rate("frequency_Hz", b_l=(2.79, -0.1), frequency_Hz=f, stroke_m=strokes, mid_stroke_speed_m_per_s=speeds)


def test_a_polynomial_of_the_frequency_is_taken_against_the_speed_of_the_stroke_it_was_fitted_to():
    (said,) = assumption_of(frequencies(2 * AMPLITUDE_M, 2 * AMPLITUDE_M))
    assert said.endswith("v = 2 pi f A, with 2 A = 100 mm")
    assert assumption_of(Rate("frequency_Hz", stroke_m=(0.08,)))[0].endswith("2 A = 80 mm")


@pytest.mark.parametrize("rate", [None, Rate("speed_m_per_s", b_l=(2.79,), stroke_m=(0.1, 0.2)), Rate("frequency_Hz", b_l=(2.79,))])
def test_what_follows_the_speed_itself_or_knows_no_stroke_assumes_nothing(rate):
    assert assumption_of(rate) == []


@pytest.mark.parametrize(("longer", "named"), [(0.1019, False), (0.1021, True), (0.2, True)])
def test_strokes_that_differ_by_more_than_two_percent_are_named(longer, named):
    (said,) = assumption_of(frequencies(0.1, longer))
    assert (f"strokes from 100 to {1e3 * longer:.3g} mm" in said) == named
    assert ("--rate speed" in said) == named


def moving(speeds) -> Array:
    """(n, 6) elongations of legs that go at constant speeds, m/s."""
    return TIME[:, None] * np.asarray(speeds, dtype=float)


def measured(prototype, **changed):
    rate = Rate("speed_m_per_s", **{"b_l": (2.79, -0.1), "mid_stroke_speed_m_per_s": (0.3, 0.1, 0.2), **changed})
    return replace(prototype, actuator=replace(prototype.actuator, rate=rate))


def test_legs_that_are_faster_than_every_loop_either_way_are_named_with_when_and_how_fast(prototype):
    model, elongation = measured(prototype), moving([0.1, 0.0, 0.29, 0.0, 0.0, 0.0])
    assert beyond_the_loops(model, TIME, elongation) == []
    elongation[5:, 4] -= 0.05 * np.arange(6)
    (said,) = beyond_the_loops(model, TIME, elongation)
    assert "speeds from 0.1 to 0.3 m/s; from 0.6 s on legs are faster, up to 0.5 m/s" in said


@pytest.mark.parametrize("line", ["a_l", "b_l", "a_u", "b_u"])
def test_any_asymptote_that_follows_the_speed_is_extrapolated(prototype, line):
    lines = {name: (1.0, 0.1) if name == line else () for name in ("a_l", "b_l", "a_u", "b_u")}
    assert len(beyond_the_loops(measured(prototype, **lines), TIME, moving(np.full(6, 0.4)))) == 1


def test_without_a_polynomial_or_without_the_speeds_of_the_loops_nothing_is_extrapolated(prototype):
    fast, bare = moving(np.full(6, 9.0)), measured(prototype, b_l=())
    assert beyond_the_loops(prototype, TIME, fast) == []
    assert beyond_the_loops(bare, TIME, fast) == []
    assert beyond_the_loops(measured(prototype, mid_stroke_speed_m_per_s=()), TIME, fast) == []
    assert len(beyond_the_loops(bare.with_effect(RateDependentAsymptotes(b_l=(0.05, 0.02))), TIME, fast)) == 1


def test_a_deployment_says_it_of_the_samples_that_it_has(prototype):
    samples = np.zeros((11, SAMPLE_SIZE))
    samples[:, SAMPLE_POSE + 3], samples[:, SAMPLE_ELONGATION : SAMPLE_ELONGATION + 6] = 1.0, moving(np.full(6, 0.4))
    samples[8:, SAMPLE_ELONGATION + 3] = np.nan
    (said,) = Deployment(measured(prototype), TIME, samples, 5e-4, None).of_rates
    assert "from 0 s on legs are faster, up to 0.4 m/s" in said
    samples[2:] = np.nan
    assert len(Deployment(measured(prototype), TIME, samples, 5e-4, 0.2).of_rates) == 1
    samples[1:] = np.nan
    assert Deployment(measured(prototype), TIME, samples, 5e-4, 0.1).of_rates == []


def test_a_model_without_a_geometry_says_what_was_assumed_of_its_loops(prototype):
    bare = replace(prototype, geometry=None)
    assert warnings_of_rates(bare) == []
    assert len(warnings_of_rates(replace(bare, actuator=replace(bare.actuator, rate=frequencies(0.1))))) == 1
