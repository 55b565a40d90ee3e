"""Motion out of noisy samples, against motions that are known."""

import numpy as np
import pytest

from identify.loops.differentiation import (
    cycles,
    dead_band,
    motion,
    noise_of,
    one_way,
    quantum_of,
    reversals,
)


@pytest.fixture
def rng():
    """Every test draws the same numbers, whichever tests ran before it in its process."""
    return np.random.default_rng(3)


def sine(rng, frequency=1.0, amplitude=0.05, rate=500.0, noise=1e-5, duration=4.0):
    t = np.arange(int(duration * rate)) / rate
    w = 2 * np.pi * frequency
    return t, amplitude * np.sin(w * t) + noise * rng.standard_normal(len(t)), w


def triangle(t, amplitude, frequency):
    phase = (t * frequency) % 1.0
    return amplitude * (4 * np.abs(phase - 0.5) - 1)


@pytest.mark.parametrize("frequency", [0.2, 1.0, 3.0])
def test_speed_and_acceleration_of_a_noisy_sinusoid_are_those_of_the_sinusoid(rng, frequency):
    t, u, w = sine(rng, frequency, duration=4.0 / frequency)
    found = motion(t, u)
    inner = slice(40, -40)
    speed, acceleration = 0.05 * w * np.cos(w * t), -0.05 * w**2 * np.sin(w * t)
    assert np.std((found.elongation_m - 0.05 * np.sin(w * t))[inner]) < 1e-5
    assert np.std((found.speed_m_per_s - speed)[inner]) < 3e-3 * 0.05 * w
    assert np.std((found.acceleration_m_per_s2 - acceleration)[inner]) < 0.05 * 0.05 * w**2


@pytest.mark.parametrize("frequency", [0.4, 1.0, 3.0])
def test_acceleration_of_a_wandering_sinusoid_is_not_too_small(rng, frequency):
    # no short series describes it; a cubic's acceleration was one per cent too small here, twenty standard errors of a hub's inertia
    fine = np.arange(int(4.4 / frequency * 3000)) / 3000.0
    wander = 0.01 * np.sin(4.4 * fine / fine[-1])
    u = 0.05 * np.sin(2 * np.pi * frequency * fine + 0.3 * np.sin(2.3 * frequency * fine)) + wander
    truth = np.gradient(np.gradient(u, fine), fine)[::10]
    seen = np.round((u[::10] + 2e-6 * rng.standard_normal(len(truth))) / 5e-6) * 5e-6
    inner = slice(20, -20)
    found = motion(fine[::10], seen).acceleration_m_per_s2
    assert np.polyfit(truth[inner], found[inner], 1)[0] == pytest.approx(1.0, abs=2e-3)


def test_smoothing_does_not_round_off_the_corner_of_a_ramp(rng):
    t = np.arange(4000) / 500.0
    u = triangle(t, 0.02, 0.5) + 1e-5 * rng.standard_normal(len(t))
    found = motion(t, u)
    assert np.max(np.abs(found.elongation_m - triangle(t, 0.02, 0.5))) < 1.2e-4  # a sample's way is 8e-5 m
    away = np.abs((t * 0.5 * 2) % 1.0 - 0.5) < 0.4
    assert np.std(np.abs(found.speed_m_per_s[away]) - 0.04) < 1e-3


def test_noise_of_the_elongation_is_found_whatever_the_motion(rng):
    for noise in (2e-6, 3e-5):
        t, u, _ = sine(rng, noise=noise)
        assert noise_of(t, u) == pytest.approx(noise, rel=0.1)


def test_jitter_of_the_clock_is_not_taken_for_noise(rng):
    t = np.cumsum(rng.uniform(0.5e-3, 3.5e-3, 2000))
    u = 0.3 * t + 1e-5 * rng.standard_normal(len(t))
    assert noise_of(t, u) == pytest.approx(1e-5, rel=0.15)
    assert np.std(motion(t, u).speed_m_per_s[50:-50] - 0.3) < 1e-3


def test_five_micrometres_of_quantisation_make_no_reversal(rng):
    t, u, _ = sine(rng, 0.2, amplitude=0.012, rate=1000.0, noise=1e-6, duration=10.0)
    seen = np.round(u / 5e-6) * 5e-6
    found = motion(t, seen)
    assert quantum_of(seen) == pytest.approx(5e-6, rel=1e-6)
    assert len(reversals(found.elongation_m, dead_band(found, 5e-6))) == 4
    assert len(reversals(seen, 0.0)) > 50


@pytest.mark.parametrize("seed", range(20))
def test_glitches_of_the_gauge_make_no_reversal(seed):
    t = np.arange(4000) / 500.0
    u = triangle(t, 0.02, 0.5)
    glitchy = u + np.where(np.random.default_rng(seed).random(len(t)) < 0.01, 3e-4, 0.0)
    turns, true = reversals(glitchy, 4e-4), reversals(u, 4e-4)
    assert len(turns) == len(true)
    assert np.max(np.abs(np.subtract(turns, true))) <= 3  # a glitch at the crest is higher than the crest for 3e-4 / 8e-5 samples
    path = one_way(glitchy, turns)
    assert len(reversals(path[turns[0] : turns[-1]], 0.0)) == len(turns) - 2
    assert np.array_equal(one_way(u, true), u)


def test_frequency_and_amplitude_come_from_the_signal(rng):
    t, u, _ = sine(rng, 1.3, amplitude=0.03, duration=6.0)
    found = cycles(t, motion(t, u + 0.004 * t).elongation_m, 1e-4)
    assert found.frequency_Hz == pytest.approx(1.3, rel=2e-3)
    assert found.amplitude_m == pytest.approx(0.03, rel=2e-2)
    assert len(found.spans) == 7


def test_frequency_is_finer_than_the_sample_step():
    t = np.arange(220) / 200.0  # 66.7 samples a cycle
    found = cycles(t, 0.05 * np.sin(2 * np.pi * 3.0 * t), 1e-4)
    assert found.frequency_Hz == pytest.approx(3.0, rel=1e-4)


def test_a_single_stroke_has_no_full_cycle():
    t = np.linspace(0.0, 1.0, 300)
    found = cycles(t, 0.1 * t, 1e-3)
    assert found.reversals == ()
    assert found.spans == ()
    assert np.isnan(found.frequency_Hz)
