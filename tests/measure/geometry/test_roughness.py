"""Noise that all marks share shows in the course of the pose and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from measure.geometry.widening import roughness, scatter

TIME = np.linspace(0.0, 1.0, 600)
RISE = 0.4 * TIME**2 * (3.0 - 2.0 * TIME)
SIGMA = np.full(600, 1e-5)


@pytest.mark.parametrize("noise", [0.5, 1.0, 3.0])
def test_the_noise_of_a_smooth_motion_is_found_whatever_the_motion(noise):
    values = RISE + noise * 1e-5 * np.random.default_rng(1).normal(size=600)
    assert scatter(values, SIGMA) == pytest.approx(noise, rel=0.3)


def test_a_motion_without_noise_has_none_and_is_not_widened():
    assert scatter(RISE, SIGMA) < 0.1
    assert roughness(RISE, SIGMA) == 1.0


def test_noise_beyond_the_stated_is_there_in_the_reference_too():
    values = RISE + 2e-5 * np.random.default_rng(1).normal(size=600)
    assert roughness(values, SIGMA) == pytest.approx(np.sqrt(7.0), rel=0.3)


def test_frames_without_a_pose_and_short_films_tell_nothing_wrong():
    values = RISE + 1e-5 * np.random.default_rng(2).normal(size=600)
    values[70:75] = np.nan
    assert scatter(values, SIGMA) == pytest.approx(1.0, rel=0.3)
    assert np.isnan(scatter(values[:12], SIGMA[:12]))
    assert roughness(values[:12], SIGMA[:12]) == 1.0
