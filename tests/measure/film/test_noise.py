"""Noise that is kept from frame to frame is measured apart from the motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.optimize import minimize_scalar
from scipy.stats import t as student_t

from measure.film.noise import _JERK, _KEPT, _likelihoods, _student, channel_noises, noise_table
from measure.tables.trajectory import Trajectory


def _deployment(time, impact_s=0.35):
    """Ever faster to the stops, a jump in speed there, and ringing: m."""
    after = time - impact_s
    return np.where(after < 0, 0.4 * (time / impact_s) ** 2, 0.4 + 0.01 * np.exp(-8 * after) * np.sin(2 * np.pi * 22 * after))


def _made(lag1, sigma, seed, fps=1000.0, seconds=0.6):
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 1.0 / fps)
    channels = {}
    for channel, motion in (("x_m", 0.002 * np.sin(20 * time)), ("z_m", _deployment(time))):
        fresh, noise = rng.normal(size=len(time)), np.zeros(len(time))
        noise[0] = fresh[0]
        for k in range(1, len(time)):
            noise[k] = lag1 * noise[k - 1] + np.sqrt(1 - lag1**2) * fresh[k]
        channels[channel] = motion + sigma * noise
    return Trajectory(time, channels, {channel: np.full(len(time), sigma) for channel in channels})


@pytest.mark.parametrize("sigma", [2e-6, 5e-5])
@pytest.mark.parametrize("lag1", [0.0, 0.3, 0.6])
def test_the_correlation_is_found_beside_a_deployment_with_an_impact(lag1, sigma):
    for found in channel_noises(_made(lag1, sigma, seed=1)):
        assert abs(found.lag1 - lag1) < 0.15 + 3.0 * found.lag1_sigma, found
        assert 0.7 < found.sigma / sigma < 1.4, found
        assert found.stated_sigma == pytest.approx(sigma)


def test_its_standard_deviation_is_that_of_repeated_films():
    all_found = np.array([[one.lag1, one.lag1_sigma] for seed in range(12) for one in channel_noises(_made(0.3, 1e-4, seed))[:1]])
    assert 0.5 < all_found[:, 0].std() / all_found[:, 1].mean() < 2.0


def test_frames_without_a_pose_and_short_films_are_borne():
    table = _made(0.0, 1e-5, 0)
    holes = {channel: np.where(np.arange(len(table.time_s)) % 50 == 7, np.nan, values) for channel, values in table.channels.items()}
    assert all(abs(one.lag1) < 0.2 for one in channel_noises(Trajectory(table.time_s, holes)))
    short = Trajectory(table.time_s[:30], {"z_m": table.channels["z_m"][:30]})
    assert noise_table(short) == noise_table(None) == []


def test_a_motion_too_fast_for_its_frames_says_nothing_of_noise():
    time = np.arange(60) / 50.0
    wild = Trajectory(time, {"z_m": 0.4 * np.sign(np.sin(7.0 * np.arange(60)))})
    assert all(np.isnan(one.lag1) or one.sigma > 0.01 for one in channel_noises(wild))


def _coloured(lag1, sigma, channels=6, frames=600, seed=9):
    """Noise alone on a parabola, (frames, channels)."""
    fresh = np.random.default_rng(seed).normal(size=(frames, channels))
    noise = fresh.copy()
    for k in range(1, frames):
        noise[k] = lag1 * noise[k - 1] + np.sqrt(1 - lag1**2) * fresh[k]
    return sigma * noise


def _measured(values, **changed):
    names = ("x_m", "y_m", "z_m", "theta_x_rad", "theta_y_rad", "theta_z_rad")
    found = channel_noises(Trajectory(np.arange(len(values)) / 500.0, dict(zip(names, values.T, strict=False)), **changed))
    return np.array([[one.sigma, one.lag1, one.lag1_sigma] for one in found]), found


@pytest.mark.parametrize("lag1", [-0.3, 0.45])
def test_on_the_average_of_channels_noise_is_found_to_a_few_hundredths(lag1):
    values, found = _measured(_coloured(lag1, 2e-5))
    assert values[:, 0].mean() == pytest.approx(2e-5, rel=0.06)
    assert values[:, 1].mean() == pytest.approx(lag1, abs=0.05)
    assert 0.03 < values[:, 2].mean() < 0.09
    assert {one.frames for one in found} == {600}
    assert np.isnan([one.stated_sigma for one in found]).all()


def test_noise_has_the_unit_of_its_channel_and_does_not_depend_on_an_even_acceleration():
    noise = _coloured(0.3, 1.0, 3)
    bare, _ = _measured(noise)
    larger, _ = _measured(1e-4 * noise)
    assert larger == pytest.approx(bare * [1e-4, 1.0, 1.0], rel=1e-5)
    time = np.arange(600.0)[:, None]
    moved, _ = _measured(noise + 30.0 + 2.0 * time - 0.01 * time**2)
    assert moved == pytest.approx(bare, rel=1e-3)


def test_of_a_long_film_the_stretch_around_the_fastest_motion_counts():
    """Beyond 300 frames from it the noise is ten times as large."""
    values = _coloured(0.0, 1.0, 2, 1500)
    values[:400] *= 10.0
    values[1000:] *= 10.0
    values[700:] += 400.0
    found, table = _measured(values)
    assert found[:, 0] == pytest.approx(np.ones(2), rel=0.15)
    assert table[0].frames == 600
    begin = _coloured(0.0, 1.0, 2, 1500)
    begin[600:] *= 10.0
    begin[2:] += 3000.0
    assert _measured(begin)[0][:, 0] == pytest.approx(np.ones(2), rel=0.15)
    found, table = _measured(begin[::-1])
    assert found[:, 0] == pytest.approx(np.ones(2), rel=0.15)
    assert table[0].frames == 600


def test_a_film_with_too_few_poses_tells_nothing():
    values = _coloured(0.0, 1.0, 1, 100)
    values[::3] = np.nan
    assert _measured(values)[1] == []
    assert len(_measured(_coloured(0.0, 1.0, 1, 40))[1]) == 1
    assert _measured(_coloured(0.0, 1.0, 1, 39))[1] == []


def _all_at_once(values, kept, jerk):
    """Largest log likelihood of Student's distribution with four degrees of freedom, up to a constant, and its scale.

    The innovations come from the covariance of all frames together (Cholesky), the scale from scipy's search.
    """
    count = len(values)
    move = np.array([[1.0, 1.0, 0.5, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, kept]])
    shaken = jerk * np.array([[1 / 20, 1 / 8, 1 / 6], [1 / 8, 1 / 3, 1 / 2], [1 / 6, 1 / 2, 1.0]])
    added = block_diag(shaken, [[1.0 - kept**2]])
    spread, seen = [np.diag([100.0, 100.0, 100.0, 1.0])], np.array([1.0, 0.0, 0.0, 1.0])
    for _ in range(count - 1):
        spread.append(move @ spread[-1] @ move.T + added)
    covariance = np.empty((count, count))
    for t in range(count):
        ahead = seen
        for later in range(t, count):
            covariance[t, later] = covariance[later, t] = ahead @ spread[t] @ seen
            ahead = ahead @ move
    square, slope, level = np.polyfit(np.arange(8), values[:8], 2)
    frames = np.arange(count)
    lower = np.linalg.cholesky(covariance)
    innovation = np.linalg.solve(lower, values - (level + slope * frames + square * frames**2))[8:]

    def missed(log_scale):
        return -np.sum(student_t.logpdf(innovation * np.exp(-log_scale), 4) - log_scale)

    best = minimize_scalar(missed, bounds=(-25.0, 6.0), method="bounded", options={"xatol": 1e-10})
    return -float(best.fun) - float(np.log(np.diag(lower)[8:]).sum()), float(np.exp(best.x))  # type: ignore[attr-defined]


def test_the_likelihood_is_that_of_all_frames_together():
    """On a few points of the grid, of two blocks and two channels."""
    blocks = np.random.default_rng(8).normal(size=(2, 60, 2)) + 0.01 * np.arange(60.0)[None, :, None] ** 2
    likelihood, scale = _likelihoods(blocks)
    at = [(1, 3), (4, 9), (8, 14), (6, 20)]
    for block in range(2):
        for channel in range(2):
            one = blocks[block, :, channel]
            expected = np.array([_all_at_once(one, _KEPT[k], _JERK[j]) for k, j in at])
            found = np.array([likelihood[block, channel, k, j] for k, j in at])
            assert found - found[0] == pytest.approx(expected[:, 0] - expected[0, 0], abs=1e-4)
            ratio = np.array([scale[block, channel, k, j] for k, j in at]) / expected[:, 1]
            assert ratio == pytest.approx(np.full(4, ratio[0]), rel=1e-5)


def test_the_scale_of_normal_noise_is_its_standard_deviation():
    normal = np.random.default_rng(2).normal(0.0, 3.0, (20_000, 1, 1))
    assert _student(normal, np.ones((20_000, 1, 1)))[1].item() == pytest.approx(3.0, rel=0.02)
