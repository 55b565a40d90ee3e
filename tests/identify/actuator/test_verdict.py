"""Loops that the law does not describe, or that say too little, are not silently fitted."""

from collections.abc import Sequence

import numpy as np
import pytest

from identify.actuator.fit_actuator import fit_actuator
from identify.loops.loop_data import prepare
from measure import Loop
from simulate.loop import loop_force

T = np.arange(2000) / 400.0
WAVE = np.sin(2 * np.pi * T)
U = 0.25 + 0.05 * WAVE
V = 0.05 * 2 * np.pi * np.cos(2 * np.pi * T)
LINES = (-0.25, 2.79, -0.3, 2.89, 400.0)


def law(lines: Sequence[float] = LINES, u=U):
    return loop_force(np.array(lines), T, u, V, 0 * T, 2.8)


def fitted(force, u=U, noise=2e-3, **options):
    rng = np.random.default_rng(1)
    return fit_actuator([prepare(Loop(T, u, force + noise * rng.standard_normal(len(T))))], **options)


NOT_OK = {
    "an ellipse of viscous friction": (2.8 - 0.3 * V, {"at-bound", "model-does-not-apply"}),
    "a spring without a loop": (2.8 + 3.0 * (U - 0.25), {"data-bad"}),
    "nothing but noise": (2.8 + 0 * U, {"data-bad"}),
    "a loop pinched in the middle": (2.8 - 0.05 * np.sign(V) * WAVE**2, {"model-does-not-apply"}),
    "a loop on a cubic spring": (law() + 800.0 * (U - 0.25) ** 3, {"model-does-not-apply"}),
    "asymptotes that cross": (law([-1.5, 3.2, 1.0, 2.6, 400.0]), {"model-does-not-apply"}),
    "elongation and force from two clocks": (np.roll(law(), 50), {"model-does-not-apply"}),
    "a loop lower than its noise": (
        law([0.0, 2.8, 0.0, 2.801, 400.0]),
        {"data-bad", "model-does-not-apply", "not-identifiable", "at-bound"},
    ),
    "a rectangle": (law([-0.25, 2.79, -0.3, 2.89, 1e7]), {"at-bound", "not-identifiable"}),
}


@pytest.mark.parametrize("case", NOT_OK)
def test_what_is_no_loop_of_the_law_is_not_called_ok(case):
    force, words = NOT_OK[case]
    verdict = fitted(force).verdict
    assert verdict.word in words, verdict
    assert len(verdict.reason) > 20


def test_a_cubic_spring_is_named_by_the_elongation():
    assert "follows the elongation" in fitted(law() + 800.0 * (U - 0.25) ** 3).verdict.reason


def test_spikes_bring_the_advice_to_fit_robustly():
    spiky = law() + (np.random.default_rng(3).random(len(T)) < 0.02) * 1.0
    assert "--robust" in fitted(spiky).verdict.reason
    assert fitted(spiky, robust=True).estimates["beta_per_m"].value == pytest.approx(400.0, rel=0.05)


TRUE = {
    "position not tared": (U - 0.36, 1.0),
    "triangles of two cycles": (0.2 + 0.02 * (4 * np.abs((T * 0.4) % 1 - 0.5) - 1), 1.0),
    "mean position drifting by 60 % of the stroke": (U + 0.06 * T / 5, 1.0),
    "elongation in steps of 2 mm": (U, 2e-3),
}


@pytest.mark.parametrize("case", TRUE)
def test_oddities_of_the_motion_do_not_move_the_truth(case):
    u, step = TRUE[case]
    seen = np.round(u / step) * step if step < 1.0 else u
    fit = fitted(law(u=u), seen)
    assert fit.verdict.word == "ok"
    assert fit.estimates["beta_per_m"].value == pytest.approx(400.0, rel=0.05)
    assert fit.half_height_N == pytest.approx((0.1 - 0.05 * fit.centre_m) / 2, abs=2e-3)


def lagging(frequency):
    """A loop whose force comes 5 ms late."""
    wave = 2 * np.pi * frequency * T
    u = 0.25 + 0.05 * np.sin(wave)
    force = np.interp(T - 0.005, T, law(u=u))
    return prepare(Loop(T, u, force + 2e-3 * np.random.default_rng(2).standard_normal(len(T))))


def test_a_late_force_spoils_beta_unseen_at_one_frequency_and_shows_at_three():
    one = fit_actuator([lagging(1.0)])
    assert one.verdict.word == "ok"
    assert one.estimates["beta_per_m"].value == pytest.approx(330.0, abs=15.0)
    three = fit_actuator([lagging(f) for f in (0.4, 1.0, 3.0)])
    assert np.std(np.concatenate(three.residuals)) > 1.4 * 2e-3
