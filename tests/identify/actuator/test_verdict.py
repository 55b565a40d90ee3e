"""Loops that the law does not describe, or that say too little, are not silently fitted."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from identify.actuator.fit_actuator import fit_actuator
from identify.loops.prepare import prepare
from measure import Loop
from simulate.effects import SensorLag
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
    assert fitted(spiky, robust=True, suggest=False).estimates["beta_per_m"].value == pytest.approx(400.0, rel=0.05)


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


@pytest.mark.parametrize("frequencies", [(1.0,), (0.4, 1.0, 3.0)])
def test_a_late_force_is_said_at_one_frequency_too_and_the_true_beta_not_excluded(frequencies):
    loops = [lagging(f) for f in frequencies]
    fit = fit_actuator(loops)
    assert fit.verdict.word == "approximate"
    assert {fault.word for fault in fit.faults} & {"lag", "filter"}
    assert fit.estimates["beta_per_m"].value < 350.0
    assert fit.estimates["beta_per_m"].ci95[1] > 400.0
    mended = fit_actuator(loops, (SensorLag,), suggest=False).estimates
    assert abs(mended["sensor-lag.delay_s"].value - 5e-3) < 4.0 * mended["sensor-lag.delay_s"].stderr


def test_a_loop_lower_than_its_noise_is_as_wide_as_it_should_be():
    lines = [0.0, 2.8, 0.0, 2.801, 400.0]
    fit = fitted(law(lines))
    for name, truth in zip(("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N"), lines, strict=False):
        assert abs(fit.estimates[name].value - truth) < 4.0 * fit.estimates[name].stderr
    low, high = fit.estimates["beta_per_m"].ci95
    assert fit.verdict.word != "ok" or high > 4.0 * low


def test_branches_of_a_rising_actuator_do_not_cross():
    """Asymptotes one below the other, and branches apart: they lie s a / beta beside them."""
    fit = fitted(law([20.0, 0.05, 20.0, 0.0, 100.0], U - 0.25) - 2.8 + 2.8, U - 0.25)
    assert fit.verdict.word == "ok"
    assert fit.estimates["beta_per_m"].value == pytest.approx(100.0, rel=0.05)


@pytest.mark.parametrize("frequency", [1.0, 0.7])
def test_loud_noise_and_hum_do_not_make_right_numbers_bad(frequency):
    w = 2 * np.pi * frequency * T
    u, v = 0.25 + 0.05 * np.sin(w), 0.05 * 2 * np.pi * frequency * np.cos(w)
    force = loop_force(np.array(LINES), T, u, v, 0 * T, 2.8)
    for spoiled, noise in ((force + 0.05 * np.sin(2 * np.pi * 50.0 * T + 0.3), 2e-3), (force, 0.05)):
        fit = fitted(spoiled, u, noise)
        assert fit.verdict.word == "ok", fit.verdict
        assert fit.estimates["beta_per_m"].ci95[0] < 400.0 < fit.estimates["beta_per_m"].ci95[1]


def test_loops_of_two_states_disagree_and_say_in_what():
    chance = np.random.default_rng(5)
    other = (-0.25, 2.79, -0.3, 2.89, 300.0)
    loops = [
        prepare(Loop(T, U + 1e-6 * chance.standard_normal(len(T)), law(lines) + 1e-3 * chance.standard_normal(len(T)), name))
        for name, lines in (("a.csv", LINES), ("b.csv", other))
    ]
    verdict = fit_actuator(loops, tare="auto").verdict
    assert verdict.word == "loops-disagree"
    assert "beta" in verdict.reason
    assert "b.csv" in verdict.reason
    same = [replace(data, force_N=law() + 1e-3 * chance.standard_normal(len(T))) for data in loops]
    assert fit_actuator(same, tare="auto").verdict.word == "ok"


def test_a_stroke_in_millimetres_among_metres_is_refused_by_its_unit():
    chance = np.random.default_rng(6)
    force = law() + 1e-3 * chance.standard_normal(len(T))
    loops = [prepare(Loop(T, U * factor, force, name)) for name, factor in (("m.csv", 1.0), ("mm.csv", 1e3))]
    verdict = fit_actuator(loops).verdict
    assert verdict.word == "data-bad"
    assert "mm.csv" in verdict.reason
    assert "--unit elongation=mm" in verdict.reason


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.calibrate) for seed in (1, 2))])
def test_a_constant_added_to_the_force_of_each_file_changes_nothing_but_the_level(seed):
    chance = np.random.default_rng(seed)
    waves = [0.25 + 0.05 * np.sin(2 * np.pi * f * T) for f in (0.8, 1.3, 2.0)]
    forces = [law(u=u) + 2e-3 * chance.standard_normal(len(T)) for u in waves]
    added = chance.uniform(-10.0, 10.0, 3)
    plain, moved = (
        fit_actuator([prepare(Loop(T, u, f + c, str(k))) for k, (u, f, c) in enumerate(zip(waves, forces, by, strict=True))], tare="auto")
        for by in (0.0 * added, added)
    )
    assert moved.verdict == plain.verdict
    for name, estimate in plain.estimates.items():
        by = added.mean() if name.startswith("b_") else 0.0
        assert moved.estimates[name].value - by == pytest.approx(estimate.value, rel=1e-9, abs=1e-9)
        assert moved.estimates[name].stderr == pytest.approx(estimate.stderr, rel=1e-6)
    turned = fit_actuator(
        [prepare(Loop(T, u, f, str(k))) for k, (u, f) in reversed(list(enumerate(zip(waves, forces, strict=True))))],
        tare="auto",
        suggest=False,
    )
    assert turned.estimates["beta_per_m"].value == pytest.approx(plain.estimates["beta_per_m"].value, rel=1e-9)
