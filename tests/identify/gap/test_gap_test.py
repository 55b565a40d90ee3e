"""The tests that decide: quiet on noise, loud on a gap, and blind to how much noise there is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from calibration import consistent
from scipy.signal import lfilter

from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.estimation.fit import Block
from identify.estimation.least_squares import solve
from identify.estimation.noise_model import LARGEST_LAG1, spacing
from identify.gap.gap_test import Series, gap_test, is_noise, p_words, slow_p
from identify.gap.localise import locate
from identify.loops.differentiation import rounding_of
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


KINDS = ("white", "memory 0.5", "memory 0.8", "heavy tails", "quantised", "30 % missing")
BOTH = "memory 0.8, quantised"
STEPS = {"quantised": 1.0, BOTH: 1.5}


def noise(kind, chance, count=250):
    """One series of noise of a kind, with the distances of its samples."""
    rho = {"memory 0.5": 0.5, "30 % missing": 0.5, "memory 0.8": 0.8, BOTH: 0.8}.get(kind, 0.0)
    drawn = chance.standard_t(3, count + 50) if kind == "heavy tails" else chance.normal(size=count + 50)
    made = lfilter([1.0], [1.0, -rho], drawn)[50:]
    rounding = 0.0
    if kind in STEPS:
        ramp = np.linspace(0.0, 40.0, count)
        rounded = np.round((made + ramp) / STEPS[kind]) * STEPS[kind]
        made, rounding = rounded - ramp, rounding_of(rounded, 1.0)
    kept = np.sort(chance.choice(count, int(0.7 * count), replace=False)) if kind == "30 % missing" else np.arange(count)
    return Series(made[kept], spacing(kept), rounding)


def p_values(kind, draws, seed):
    """Of campaigns of four runs and three channels of noise alone."""
    chance = np.random.default_rng(seed)
    return np.array([slow_p([[noise(kind, chance) for _ in range(4)] for _ in range(3)]) for _ in range(draws)])


@pytest.mark.parametrize("kind", KINDS)
def test_noise_of_every_kind_is_called_a_gap_as_rarely_as_is_said(kind):
    found = p_values(kind, 20, 11)
    assert np.sum(found < 0.05) <= 4  # more of 20 happen once in 390 times
    assert found.min() > 1e-4


def test_noise_with_a_memory_that_was_rounded_is_noise_as_far_as_its_rounding_is_known():
    chance = np.random.default_rng(11)
    campaigns = [[[noise(BOTH, chance) for _ in range(4)] for _ in range(3)] for _ in range(20)]
    found = np.array([slow_p(rows) for rows in campaigns])
    assert np.sum(found < 0.05) <= 5
    assert found.min() > 1e-4
    unknown = [[[replace(one, rounding=0.0) for one in series] for series in rows] for rows in campaigns[:5]]
    assert np.median([slow_p(rows) for rows in unknown]) < 1e-3


def test_a_fit_is_tested_with_the_rounding_of_each_channel():
    chance = np.random.default_rng(16)
    one = noise(BOTH, chance)
    block = Block("a film", "z_m", slice(0, 250), np.arange(250), one.rounding)
    problem = SimpleNamespace(blocks=(block,), first_nuisance=0, first_zero=0)
    fit: Any = SimpleNamespace(problem=problem, part=lambda block: one.gaps, determined=0.0, q=np.empty(0), rms=1.0)
    assert gap_test(fit).slow_p == slow_p([[one]])
    assert gap_test(fit).slow_p != slow_p([[replace(one, rounding=0.0)]])


def test_a_loop_knows_by_how_much_of_its_noise_its_force_was_rounded():
    (run, _), step = loops(3), 1e-3
    rounded = Run(replace(run.table, force_N=np.round(run.table.force_N / step) * step))
    (block,) = problem_of(MODEL, [rounded]).blocks
    (loop,) = problem_of(MODEL, [rounded]).loops
    assert block.rounding == pytest.approx(step / np.sqrt(12.0) / loop.data.force_sigma_N)
    assert [one.rounding for one in problem_of(MODEL, [run]).blocks] == [0.0]


def test_rounding_that_is_coarser_than_what_differs_from_sample_to_sample_is_no_noise():
    chance = np.random.default_rng(15)
    rows = [[noise("memory 0.5", chance) for _ in range(3)] for _ in range(2)]
    coarse = [[replace(one, rounding=2.0) for one in series] for series in rows]
    assert slow_p(coarse) == slow_p(rows)
    assert slow_p([[replace(one, rounding=0.5) for one in series] for series in rows]) != slow_p(rows)


@pytest.mark.calibrate
@pytest.mark.parametrize("kind", KINDS)
def test_noise_of_every_kind_over_two_hundred_campaigns(kind):
    assert 0.03 <= np.mean(p_values(kind, 200, 12) < 0.05) <= 0.08


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
        white = drawn[1:] - min(rho, LARGEST_LAG1) * drawn[:-1]
        assert is_noise([white])
    gap = 9.0 * np.sin(np.linspace(0.0, 3.0 * np.pi, 250)) + chance.normal(size=250)
    assert not is_noise([gap[1:] - LARGEST_LAG1 * gap[:-1]])


def test_a_probability_too_small_for_a_float_is_not_called_nought():
    assert p_words(0.0) == "p < 1e-300"
    assert p_words(8.14e-87) == "p = 8.1e-87"
    assert p_words(0.25) == "p = 0.25"
