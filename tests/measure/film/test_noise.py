"""Noise that is kept from frame to frame is measured apart from the motion."""

from __future__ import annotations

import numpy as np
import pytest

from measure.film.noise import channel_noises, noise_table
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
