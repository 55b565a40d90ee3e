"""Motion of a shaker in a few harmonics: exact without noise, its errors as often as they say, and no corner rounded off."""

from __future__ import annotations

import numpy as np
import pytest

from identify.loops.harmonics import harmonic_motion

TIME = np.linspace(0.0, 3.3, 500)
W = 2.0 * np.pi * 1.07


def exact(w=W):
    """Level, drift and two harmonics: elongation, speed, acceleration."""
    c, s, c2 = np.cos(w * TIME + 0.4), np.sin(w * TIME + 0.4), np.cos(2.0 * w * TIME)
    u = 0.2 + 0.001 * TIME + 0.05 * s + 0.004 * c2
    v = 0.001 + 0.05 * w * c - 0.008 * w * np.sin(2.0 * w * TIME)
    return np.stack([u, v, -0.05 * w**2 * s - 0.016 * w**2 * c2])


def found(values, noise_m):
    made = harmonic_motion(TIME, values, noise_m)
    assert made is not None
    return made


def test_a_sine_with_an_overtone_and_a_drift_comes_back_with_both_derivatives():
    moved, _ = found(exact()[0] + np.random.default_rng(0).normal(0.0, 1e-6, 500), 1e-6)
    for row, size in zip(moved - exact(), (1e-6, 1e-5, 1e-4), strict=True):
        assert np.abs(row).max() < size


def test_errors_of_motion_are_those_that_repeated_records_have():
    fits = [found(exact()[0] + np.random.default_rng(seed).normal(0.0, 1e-4, 500), 1e-4) for seed in range(30)]
    seen = np.sqrt(np.mean([(moved - exact()) ** 2 for moved, _ in fits], axis=(0, 2)))
    said = np.sqrt(np.mean([np.sum(errors**2, axis=0) for _, errors in fits], axis=(0, 2)))
    assert said / seen == pytest.approx(np.ones(3), rel=0.25)


def test_the_frequency_is_no_better_known_than_the_noise_lets_it():
    """At the ends of a record its error moves the speed of a sine most: without it the stated error is a fifth smaller."""
    wave, speed = 0.2 + 0.05 * np.sin(W * TIME), 0.05 * W * np.cos(W * TIME)
    fits = [found(wave + np.random.default_rng(seed).normal(0.0, 1e-4, 500), 1e-4) for seed in range(30)]
    ends = np.r_[0:20, 480:500]
    seen = np.sqrt(np.mean([(moved[1] - speed)[ends] ** 2 for moved, _ in fits]))
    said = np.sqrt(np.mean([np.sum(errors[:, 1] ** 2, axis=0)[ends] for _, errors in fits]))
    assert 0.95 < said / seen < 1.25


@pytest.mark.parametrize("duty", [0.5, 0.3])
def test_a_triangle_in_coarse_noise_is_none(duty):
    rising = (1.07 * TIME + 0.1) % 1.0
    triangle = 0.2 + 0.05 * np.interp(rising, [0.0, duty, 1.0], [-1.0, 1.0, -1.0])
    assert harmonic_motion(TIME, triangle + np.random.default_rng(1).normal(0.0, 2e-3, 500), 2e-3) is None


def test_what_no_series_of_five_says_down_to_the_noise_is_none():
    assert harmonic_motion(TIME, np.sin(W * TIME**1.5), 1e-4) is None
    assert harmonic_motion(TIME, exact()[0] + np.random.default_rng(2).normal(0.0, 3e-4, 500), 1e-4) is None


def test_less_than_one_cycle_and_fewer_than_sixteen_samples_are_none():
    noise = np.random.default_rng(3).normal(0.0, 1e-4, 500)
    assert harmonic_motion(TIME, 0.2 + 0.05 * np.sin(0.2 * W * TIME) + noise, 1e-4) is None
    assert harmonic_motion(TIME[:15], (exact()[0] + noise)[:15], 1e-4) is None
