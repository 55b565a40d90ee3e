"""The tests that decide: quiet on noise, loud on a gap, and blind to how much noise there is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration import consistent
from scipy.signal import lfilter

from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.criteria import FAST_NOISE, GAP_P
from identify.estimation.least_squares import solve
from identify.gap import gap_test as module
from identify.gap.gap_test import Series, _by_chance, _by_channel, _noise_of, gap_test, is_noise, p_words, slow_p
from identify.gap.localise import locate
from identify.noise import noise_model
from identify.noise.noise_model import spacing
from identify.noise.windows import LONGEST_MEMORY
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
    chances = [gap_test(solve(problem_of(MODEL, loops(seed)))).p_value for seed in range(15)]
    assert sum(p < 0.05 for p in chances) <= 3  # more of 15 happen once in 180 times
    assert min(chances) > 1e-3


@pytest.mark.calibrate
def test_the_gap_test_is_calibrated_on_noise_alone_over_many_campaigns(calibration_seed, share_of):
    first, number = 1000 * calibration_seed, share_of(200)
    chances = [gap_test(solve(problem_of(MODEL, loops(first + seed)))).p_value for seed in range(number)]
    assert consistent(sum(p < 0.05 for p in chances), number, 0.03, 0.08)
    assert min(chances) > 1e-5


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


def test_the_noise_of_loops_is_told_from_what_does_not_come_again():
    """A missing friction is quick where the motion turns, and would pass for noise with a memory."""
    fit = solve(problem_of(MODEL, loops(1, MORE)))
    (force,) = _by_channel(fit)
    assert _noise_of(force).lag1 < 0.1
    assert _noise_of([replace(one, not_repeated=None) for one in force]).lag1 > 0.5
    assert slow_p([[replace(one, not_repeated=None) for one in force]], fit.determined) > 1e-9 > gap_test(fit).slow_p


def test_a_gap_that_is_quick_for_a_while_as_behind_a_stop_is_no_noise(monkeypatch):
    chance, rows, time = np.random.default_rng(18), [], np.arange(250)
    for _ in range(4):
        ring = np.where(time > 200, 9.0 * np.exp(-(time - 200) / 30.0) * np.cos((time - 200) / 1.6), 0.0)
        rows.append(Series(chance.normal(size=250) + ring, spacing(time)))
    found = slow_p([rows])
    assert found < GAP_P
    monkeypatch.setattr(noise_model, "_LOUD", np.inf)
    assert slow_p([rows]) > 100.0 * found


KINDS = ("white", "memory 0.5", "memory 0.8", "heavy tails", "quantised", "30 % missing")
MIXED = ("memory 0.8, quantised", "memory 0.8, half of it white", "memory 0.5, 1 % outliers")
MEMORIES = {"30 % missing": 0.5}
STEPS = {"quantised": 1.0, "memory 0.8, quantised": 1.5}


def noise(kind, chance, count=250):
    """One series of noise of a kind, with the distances of its samples."""
    rho = MEMORIES.get(kind, float(kind[7:10]) if kind.startswith("memory") else 0.0)
    drawn = chance.standard_t(3, count + 50) if kind == "heavy tails" else chance.normal(size=count + 50)
    made = lfilter([1.0], [1.0, -rho], drawn)[50:]
    if kind.endswith("white"):
        made = made + np.std(made) * chance.normal(size=count)
    if kind.endswith("outliers"):
        made = np.where(chance.random(count) < 0.01, made + 8.0 * np.std(made) * chance.normal(size=count), made)
    if kind in STEPS:
        ramp = np.linspace(0.0, 40.0, count)
        made = np.round((made + ramp) / STEPS[kind]) * STEPS[kind] - ramp
    kept = np.sort(chance.choice(count, int(0.7 * count), replace=False)) if kind == "30 % missing" else np.arange(count)
    return Series(made[kept], spacing(kept))


def p_values(kind, draws, seed):
    """Of campaigns of four runs and three channels of noise alone."""
    chance = np.random.default_rng(seed)
    return np.array([slow_p([[noise(kind, chance) for _ in range(4)] for _ in range(3)]) for _ in range(draws)])


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_noise_of_every_kind_is_called_a_gap_as_rarely_as_is_said(kind):
    found = p_values(kind, 12, 11)
    assert np.sum(found < 0.05) <= 3  # more of 12 happen once in 450 times
    assert found.min() > 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("kind", MIXED)
def test_noise_of_two_kinds_at_once_is_no_gap(kind):
    found = p_values(kind, 12, 17)
    assert np.sum(found < 0.05) <= 4
    assert found.min() > 1e-4


def test_a_measurement_without_noise_shows_no_gap_that_is_a_tenth_of_the_noise_it_is_taken_to_have():
    wave = np.sin(np.linspace(0.0, 4.0 * np.pi, 250))
    assert slow_p([[Series(0.02 * wave, spacing(np.arange(250)))]]) > 0.05
    assert slow_p([[Series(2.0 * wave, spacing(np.arange(250)))]]) < 1e-6


@pytest.mark.calibrate
@pytest.mark.parametrize("kind", KINDS)
def test_noise_of_every_kind_over_two_hundred_campaigns(kind):
    assert 0.03 <= np.mean(p_values(kind, 200, 12) < 0.05) <= 0.08


@pytest.mark.calibrate
@pytest.mark.slow
@pytest.mark.parametrize("kind", MIXED)
def test_noise_of_two_kinds_at_once_over_two_hundred_campaigns(kind):
    assert np.mean(p_values(kind, 200, 12) < 0.05) <= 0.15


def test_noise_is_drawn_once_for_all_that_remembers_alike_however_loud(monkeypatch):
    rows = [noise("memory 0.5", np.random.default_rng(23)) for _ in range(4)]
    drawn = []
    one_draw = module._drawn_ratio
    monkeypatch.setattr(module, "_drawn_ratio", lambda channels, chance: drawn.append(channels) or one_draw(channels, chance))
    _by_chance.cache_clear()
    found = slow_p([rows])
    once = len(drawn)
    assert once > 0
    louder = slow_p([[Series(3.0 * one.gaps, one.apart) for one in rows]])
    assert louder == pytest.approx(found, rel=1e-9)
    assert len(drawn) == once
    slow_p([[Series(one.gaps[:-20], one.apart[:-20]) for one in rows]])
    slow_p([[noise("white", np.random.default_rng(24)) for _ in range(4)]])
    assert len(drawn) == 3 * once


def test_a_slow_gap_beside_noise_with_a_memory_is_seen():
    chance = np.random.default_rng(13)
    wave = np.sin(np.linspace(0.0, 4.0 * np.pi, 250))
    rows = [[noise("memory 0.5", chance) for _ in range(4)] for _ in range(3)]
    found = [[Series(one.gaps + 1.5 * np.std(one.gaps) * wave, one.apart) for one in series] for series in rows]
    assert slow_p(found) < 1e-3


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_innovations_of_noise_are_noise_and_those_of_a_smooth_gap_are_none(rho):
    """Whitened by as much memory as the noise model has at most: a motion's gap is slower than that."""
    chance = np.random.default_rng(14)
    for _ in range(40):
        drawn = np.asarray(lfilter([1.0], [1.0, -rho], chance.normal(size=300)))[50:]
        white = drawn[1:] - min(rho, LONGEST_MEMORY) * drawn[:-1]
        assert is_noise([white])
    gap = 9.0 * np.sin(np.linspace(0.0, 3.0 * np.pi, 250)) + chance.normal(size=250)
    assert not is_noise([gap[1:] - LONGEST_MEMORY * gap[:-1]])


def test_a_series_that_is_too_short_without_its_outliers_tells_nothing():
    gaps = np.random.default_rng(19).normal(size=16)
    gaps[7] = 40.0
    assert slow_p([[Series(gaps, spacing(np.arange(16)))]]) == 1.0


def test_a_probability_too_small_for_a_float_is_not_called_nought():
    assert p_words(0.0) == "p < 1e-300"
    assert p_words(8.14e-87) == "p = 8.1e-87"
    assert p_words(0.25) == "p = 0.25"


def test_a_memory_longer_than_the_noise_can_have_is_no_noise_by_its_slowest_part():
    """What is left of a memory of 0.95 once one of 0.85 is taken out, frequency by frequency."""
    turn = np.exp(-1j * np.linspace(0.0, np.pi, 2001)[1:])
    power = np.abs(1.0 - LONGEST_MEMORY * turn) ** 2 / np.abs(1.0 - 0.95 * turn) ** 2
    slow, slowest = (np.sqrt(power[:n].mean() / power[n:].mean()) for n in (500, 100))
    assert slow == pytest.approx(1.4, abs=0.05)
    assert slowest == pytest.approx(2.1, abs=0.05)
    assert slow < FAST_NOISE < slowest
