"""The size of a gap is that of what moves neighbours alike; single samples far beyond the noise do not count."""

from __future__ import annotations

import numpy as np
import pytest

from identify.estimation.fit import Block
from identify.gap.size import gap_size, noise_of_channels, without_spikes
from identify.noise.noise_model import ChannelNoise

N = 400


def noise(seed):
    return np.random.default_rng(seed).normal(size=N)


def test_spikes_do_not_count():
    gaps = noise(1)
    spiky = gaps.copy()
    spiky[[50, 120, 333]] += (25.0, -18.0, 30.0)
    assert gap_size([spiky]) == pytest.approx(gap_size([gaps]), abs=0.02)
    assert len(without_spikes(spiky)) == N - 3


@pytest.mark.parametrize("seed", range(5))
def test_noise_counts_whole(seed):
    assert len(without_spikes(noise(seed))) == N


def test_a_slow_gap_and_one_that_sets_in_at_once_count_whole():
    time = np.arange(N)
    for gap in (20.0 * np.sin(time / 15.0), np.where(time > 200, 30.0, 0.0), 40.0 * np.exp(-(((time - 100) / 4.0) ** 2))):
        assert gap_size([noise(6) + gap]) == pytest.approx(float(np.sqrt(np.mean((noise(6) + gap) ** 2))))


def test_steps_of_a_converter_are_no_spikes():
    assert len(without_spikes(np.round(noise(7) / 1.5) * 1.5)) == N


def test_runs_count_by_their_samples():
    assert gap_size([np.zeros(100), np.full(300, 2.0)]) == pytest.approx(np.sqrt(3.0))


def test_the_noise_of_a_channel_is_what_is_left_of_it_without_outliers():
    left, model = noise(8), ChannelNoise()
    far = np.append(left, [9.0, -12.0, 7.0, 30.0])
    block = Block("run-1.csv", "z_m", slice(10, 10 + len(far)), np.arange(len(far)))
    (found,) = noise_of_channels([block], [2e-5], [model], [far])
    assert found.sigma == pytest.approx(2e-5 * found.over)
    assert found.over == pytest.approx(model.scale * float(np.sqrt(np.mean(left**2))))
    assert found.outliers_percent == pytest.approx(100.0 * 4 / len(far))
    assert (found.run, found.channel, found.rows, found.model) == ("run-1.csv", "z_m", block.rows, model)
