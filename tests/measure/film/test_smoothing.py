"""Speed, acceleration and instants against motions known in closed form."""

from __future__ import annotations

import numpy as np

from measure.film.smoothing import instants, smooth

TIME = np.arange(150) / 250.0


def _deployment(noise, seed=0):
    """At rest until 0.08 s, then a swing of 0.4 m that ends against a stop at 0.48 s."""
    s = np.clip((TIME - 0.08) / 0.40, 0.0, 1.0)
    z = 0.4 * (1 - np.cos(0.5 * np.pi * s))
    speed = np.where((s > 0) & (s < 1), 0.4 * 0.5 * np.pi / 0.40 * np.sin(0.5 * np.pi * s), 0.0)
    return z + np.random.default_rng(seed).normal(0.0, noise, len(TIME)), speed


def test_speed_of_a_swing_comes_back_within_its_stated_sigma():
    z, speed = _deployment(1e-5)
    made = smooth(TIME, z, np.full(len(TIME), 1e-5))
    middle = (TIME > 0.15) & (TIME < 0.42)
    gap = (made.value[:, 1] - speed)[middle]
    assert np.abs(gap).max() < 0.02
    assert np.mean(np.abs(gap) < 2 * made.sigma[middle, 1]) > 0.85


def test_uniform_acceleration_is_found_and_not_smoothed_away():
    z = 0.5 * 3.0 * TIME**2 + np.random.default_rng(1).normal(0.0, 1e-5, len(TIME))
    made = smooth(TIME, z, np.full(len(TIME), 1e-5))
    assert np.abs(made.value[20:-20, 2] - 3.0).max() < 5 * made.sigma[20:-20, 2].max()
    assert np.abs(made.value[20:-20, 2] - 3.0).max() < 0.2


def test_a_gap_is_bridged_with_a_wider_sigma():
    z, _ = _deployment(1e-5)
    z[60:70] = np.nan
    made = smooth(TIME, z, np.full(len(TIME), 1e-5))
    assert np.isfinite(made.value).all()
    assert made.sigma[65, 0] > 3 * made.sigma[50, 0]


def test_release_and_end_of_stroke_are_found_to_two_frames():
    z, _ = _deployment(1e-5)
    found = instants(smooth(TIME, z, np.full(len(TIME), 1e-5)))
    assert found.release_s is not None
    assert found.end_of_stroke_s is not None
    assert abs(found.release_s - 0.08) < 3 / 250
    assert abs(found.end_of_stroke_s - 0.48) < 3 / 250


def test_a_platform_at_rest_has_no_release():
    z = np.random.default_rng(2).normal(0.0, 1e-5, len(TIME))
    found = instants(smooth(TIME, z, np.full(len(TIME), 1e-5)))
    assert found.end_of_stroke_s is None
