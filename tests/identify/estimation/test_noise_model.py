"""Memory, scale and tails of a channel's noise, found from what a fit leaves."""

from __future__ import annotations

import numpy as np
import pytest

from identify.estimation.noise_model import LARGEST_LAG1, ChannelNoise, estimated, log_likelihood, spacing


def noise(chance, lag1, count=3000):
    drawn = 2.0 * chance.standard_t(5, size=count)
    for i in range(1, count):
        drawn[i] += lag1 * drawn[i - 1]
    return drawn


@pytest.mark.parametrize("lag1", [0.0, 0.3, 0.6])
def test_memory_and_scale_are_found(lag1):
    found = estimated(noise(np.random.default_rng(1), lag1), spacing(np.arange(3000)))
    assert found.lag1 == pytest.approx(lag1, abs=0.05)
    assert found.scale == pytest.approx(2.0, rel=0.05)


def test_missing_samples_count_as_far_apart():
    chance = np.random.default_rng(2)
    kept = np.sort(chance.choice(3000, 1800, replace=False))
    found = estimated(noise(chance, 0.5)[kept], spacing(kept))
    assert found.lag1 == pytest.approx(0.5, abs=0.06)


def test_a_drift_is_no_noise_with_a_long_memory():
    found = estimated(np.cumsum(np.random.default_rng(3).normal(size=2000)), spacing(np.arange(2000)))
    assert found.lag1 == LARGEST_LAG1


def test_whitening_makes_independent_values_of_one():
    drawn = noise(np.random.default_rng(4), 0.6)
    white = ChannelNoise(0.6, 2.0).whitened(drawn, spacing(np.arange(3000)))
    assert np.corrcoef(white[1:], white[:-1])[0, 1] == pytest.approx(0.0, abs=0.05)
    assert np.std(white) == pytest.approx(np.sqrt(5.0 / 3.0), rel=0.1)


def test_the_likelihood_is_that_of_students_t():
    assert log_likelihood(np.array([0.0])) == pytest.approx(np.log(0.3796), abs=1e-3)
