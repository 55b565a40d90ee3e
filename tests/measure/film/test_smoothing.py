"""Speed, acceleration and instants against motions known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag, expm
from scipy.stats import multivariate_normal

from measure.film.smoothing import Smoothed, instants, smooth

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


RNG = np.random.default_rng(3)
UNEVEN = np.cumsum(RNG.uniform(0.01, 0.06, 24))
HEIGHTS = 0.3 + 0.2 * np.sin(6.0 * UNEVEN) + RNG.normal(0.0, 0.004, 24)
HEIGHTS[[0, 9, 10]] = np.nan
SIGMAS = np.where(np.arange(24) % 3, 0.004, 0.009)


def _prior(q):
    """Mean (3 n,) and covariance of all states together, from the motion's equation alone: van Loan's matrix exponential."""
    span, duration = np.nanmax(HEIGHTS) - np.nanmin(HEIGHTS) + 1e-9, UNEVEN[-1] - UNEVEN[0]
    parts, count = [np.diag([span, 10 * span / duration, 100 * span / duration**2]) ** 2], len(UNEVEN)
    answer = np.eye(3 * count)
    for i, dt in enumerate(np.diff(UNEVEN), start=1):
        drift, shaken = np.eye(3, k=1), np.diag([0.0, 0.0, q])
        both = expm(np.block([[-drift, shaken], [np.zeros((3, 3)), drift.T]]) * dt)
        move = both[3:, 3:].T
        parts.append(move @ both[:3, 3:])
        answer[3 * i : 3 * i + 3] += move @ answer[3 * i - 3 : 3 * i]
    mean = answer[:, :3] @ [HEIGHTS[1], 0.0, 0.0]
    return mean, answer @ np.asarray(block_diag(*parts)) @ answer.T


def _observed(q):
    """Prior mean and covariance of the states, that of the observations, and which are observed."""
    mean, covariance = _prior(q)
    at = 3 * np.flatnonzero(np.isfinite(HEIGHTS))
    return mean, covariance, at, covariance[np.ix_(at, at)] + np.diag(SIGMAS[at // 3] ** 2)


def test_the_smoothed_motion_is_what_all_observations_together_say_of_it():
    """The conditional mean of one large normal distribution, without any filter."""
    q = 40.0
    mean, covariance, at, of_seen = _observed(q)
    gain = np.linalg.solve(of_seen, covariance[at]).T
    value, left = mean + gain @ (HEIGHTS[at // 3] - mean[at]), covariance - gain @ covariance[at]
    made = smooth(UNEVEN, HEIGHTS, SIGMAS, q)
    assert made.value == pytest.approx(value.reshape(-1, 3), rel=1e-6, abs=1e-8)
    assert made.sigma == pytest.approx(np.sqrt(np.diag(left)).reshape(-1, 3), rel=1e-5)


def test_the_jerk_is_that_of_largest_likelihood():
    def likelihood(q):
        mean, _, at, of_seen = _observed(q)
        return multivariate_normal.logpdf(HEIGHTS[at // 3], mean=mean[at], cov=of_seen)  # type: ignore[arg-type]

    found = smooth(UNEVEN, HEIGHTS, SIGMAS).jerk_density
    assert likelihood(found) > max(likelihood(found * factor) for factor in (0.1, 0.7, 1.4, 10.0))


def _exact(position, velocity, acceleration):
    return Smoothed(TIME, np.column_stack([position, velocity, acceleration]), np.full((len(TIME), 3), 1e-3), 1.0)


def _stroke(begin=0.1, end=0.5):
    """Even acceleration of 3 m/s^2 from one instant, a stop within 20 ms at another, exactly known."""
    speed = np.interp(TIME, [begin, end, end + 0.02], [0.0, 3.0 * (end - begin), 0.0])
    return _exact(np.cumsum(speed) / 250.0, speed, np.gradient(speed, TIME))


def test_instants_of_a_motion_that_is_known_exactly():
    found = instants(_stroke())
    assert found.release_s == pytest.approx(0.1, abs=1e-9)
    assert found.fastest_s == pytest.approx(0.5)
    assert found.end_of_stroke_s == pytest.approx(0.508, abs=0.005)


def test_a_release_before_the_film_and_a_stop_after_it_are_not_named():
    assert instants(_stroke(begin=-0.05)).release_s is None
    assert instants(_stroke(begin=-0.003)).release_s == pytest.approx(-0.003, abs=1e-9)
    assert instants(_stroke(end=0.7)).end_of_stroke_s is None


def test_what_is_not_clear_of_its_sigma_is_not_named():
    stroke = _stroke()
    for times, speed_clear, brake_clear in ((200.0, True, True), (300.0, False, False)):
        sigma = np.full_like(stroke.sigma, 1.2 / 4.0 / 250.0 * times)
        found = instants(replace(stroke, sigma=np.column_stack([sigma[:, 0], sigma[:, 1], 1e-3 * sigma[:, 2]])))
        assert (found.fastest_s is not None, found.end_of_stroke_s is not None) == (speed_clear, brake_clear)
    vague = replace(stroke, sigma=stroke.sigma * [1.0, 1.0, 1e6])
    assert instants(vague).fastest_s is not None
    assert instants(vague).end_of_stroke_s is None


def test_a_speed_that_falls_at_first_has_no_release():
    speed = np.interp(TIME, [0.08, 0.1, 0.2, 0.21, 0.4], [0.0, 0.28, 0.1, 0.35, 1.0])
    assert instants(_exact(np.cumsum(speed) / 250.0, speed, np.gradient(speed, TIME))).release_s is None
