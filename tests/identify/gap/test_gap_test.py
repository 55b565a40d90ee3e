"""The tests that decide: quiet on noise, loud on a gap, and blind to how much noise there is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from identify.campaign.run import Run
from identify.estimation.least_squares import solve
from identify.estimation.problem import problem_of
from identify.gap.gap_test import gap_test, p_words
from identify.gap.localise import locate
from measure.tables.loop import Loop
from simulate.effects import HubInertia, ViscousFriction
from simulate.files.model_file import read_model
from simulate.loop import loop_force

MODEL = read_model(Path(__file__).resolve().parents[1].joinpath("rig.toml"))


def loops(seed, extra=(), sigma=2e-3):
    chance = np.random.default_rng(seed)
    law = MODEL.actuator
    lines = np.array([law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m])
    effects = extra or MODEL.effects
    runs = []
    for frequency in (0.5, 2.0):
        time = np.linspace(0.0, 3.0 / frequency, 8001)
        w = 2 * np.pi * frequency
        u = 0.1 + 0.03 * np.sin(w * time)
        force = loop_force(lines, time, u, 0.03 * w * np.cos(w * time), -0.03 * w**2 * np.sin(w * time), 2.84, effects)[::20]
        noisy = Loop(time[::20], u[::20] + chance.normal(0, 1e-5, 401), force + chance.normal(0, sigma, 401), name=f"{frequency} Hz")
        runs.append(Run(noisy))
    return runs


def test_the_gap_test_is_calibrated_on_noise_alone():
    chances = [gap_test(solve(problem_of(MODEL, loops(seed)))).p_value for seed in range(40)]
    assert sum(p < 0.05 for p in chances) <= 6
    assert min(chances) > 1e-3


def test_the_gap_test_does_not_mind_how_loud_the_noise_is():
    assert gap_test(solve(problem_of(MODEL, loops(3, sigma=2e-2)))).p_value > 1e-3


MORE = (HubInertia(0.746), ViscousFriction(0.12))


def test_a_missing_friction_is_a_gap_and_goes_with_speed():
    fit = solve(problem_of(MODEL, loops(1, MORE)))
    assert gap_test(fit).p_value < 1e-9
    places = locate(fit)
    assert sum(place.share_percent for place in places) == pytest.approx(100.0)
    assert places[0].run == "2.0 Hz"
    assert {place.phase for place in places} <= {"uncoiling", "coiling", "reversal"}


def test_a_probability_too_small_for_a_float_is_not_called_nought():
    assert p_words(0.0) == "p < 1e-300"
    assert p_words(8.14e-87) == "p = 8.1e-87"
    assert p_words(0.25) == "p = 0.25"
