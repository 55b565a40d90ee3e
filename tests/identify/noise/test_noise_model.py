"""Memory, scale and tails of a channel's noise, found from what a fit leaves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from identify.noise import windows
from identify.noise.noise_model import ChannelNoise, estimated, from_differences, log_likelihood, log_probability, spacing
from identify.noise.windows import LONGEST_MEMORY


def noise(chance, lag1, count=3000):
    drawn = 2.0 * chance.standard_t(5, size=count)
    for i in range(1, count):
        drawn[i] += lag1 * drawn[i - 1]
    return drawn


@pytest.mark.parametrize("lag1", [0.0, 0.3, 0.6])
def test_memory_and_scale_are_found(lag1):
    found = estimated(noise(np.random.default_rng(1), lag1), spacing(np.arange(3000)))
    assert found.lag1 == pytest.approx(lag1, abs=0.05)
    assert found.scale == pytest.approx(2.0 / np.sqrt(1.0 - lag1**2), rel=0.06)


def test_missing_samples_count_as_far_apart():
    chance = np.random.default_rng(2)
    kept = np.sort(chance.choice(3000, 1800, replace=False))
    found = estimated(noise(chance, 0.5)[kept], spacing(kept))
    assert found.lag1 == pytest.approx(0.5, abs=0.06)


def spread_of_memory(rest, kept):
    """Standard deviation over 60 draws of the correlation of neighbours, from differences, of four runs of 250 places."""
    chance, found = np.random.default_rng(9), []
    for _ in range(60):
        runs = []
        for _ in range(4):
            places = np.sort(chance.choice(250, kept, replace=False)) if rest == "missing" else np.arange(kept)
            runs.append((noise(chance, 0.5, 300)[50:][places], spacing(places)))
        found.append(from_differences(runs).lag1)
    assert np.mean(found) == pytest.approx(0.5, abs=0.04)
    return np.std(found)


@pytest.mark.parametrize(("lag1", "count"), [(-0.2, 300), (0.0, 300), (0.0, 60), (0.1, 300)])
def test_a_small_memory_is_right_on_the_average_from_differences(lag1, count):
    """Cut off at nought, that of white noise would be found at 0.03."""
    chance = np.random.default_rng(17)
    found = [from_differences([(noise(chance, lag1, count), spacing(np.arange(count)))]).lag1 for _ in range(200)]
    assert np.mean(found) == pytest.approx(lag1, abs=0.02)


def test_samples_missing_here_and_there_cost_little_more_than_themselves():
    """A prediction from whichever neighbours are there: mean products over other pairs for each distance would cost three times as much."""
    assert spread_of_memory("missing", 175) < 1.4 * spread_of_memory("at the end", 175)


@pytest.mark.parametrize("every", [2, 3])
def test_the_noise_of_every_second_or_third_frame_is_that_of_all(every):
    """As where a tracker fails on one field of an interlaced film: no two neighbours are there."""
    chance, kept = np.random.default_rng(12), np.arange(0, 1000, every)
    found = from_differences([(noise(chance, 0.8, 1050)[50:][kept], spacing(kept)) for _ in range(4)])
    assert (1.0 - found.white) * found.memory**every == pytest.approx(0.8**every, abs=0.12)  # two standard deviations
    assert found.scale == pytest.approx(2.0 * np.sqrt(5.0 / 3.0) / np.sqrt(1.0 - 0.8**2), rel=0.15)


@pytest.mark.parametrize(("held", "contrasts"), [(0b00000, False), (0b10010, False), (0b10010, True), (0b11111, True)])
def test_what_is_new_in_a_sample_is_its_conditional_likelihood(held, contrasts):
    """As the joint probability of the window over that of the samples before, of contrasts with a shift that nothing tells."""
    back = [0, *(place for place in range(1, 6) if held & (1 << (place - 1)))]
    values = np.random.default_rng(10).normal(size=6)
    new, g = windows._newness(5, held, contrasts), 17 * len(windows._WHITE) + 6
    memory, white = windows._memories(contrasts)[17], windows._WHITE[6]
    shift = 1e6 if contrasts else 0.0
    apart = np.abs(np.subtract.outer(back, back))
    joint = (1.0 - white) * memory**apart + white * np.eye(len(back)) + shift
    given = [multivariate_normal(cov=part).logpdf(values[at]) for part, at in ((joint, back), (joint[1:, 1:], back[1:])) if at]
    products = np.outer(values, values)[np.triu_indices(6)]
    found = -0.5 * (products[new.pairs] @ new.quadratic[:, g] + new.log_size[g] + np.log(2.0 * np.pi))
    assert found == pytest.approx(given[0] - (given[1] if len(given) == 2 else 0.0), abs=1e-4)


@pytest.mark.parametrize("memory", [-0.3, 0.6])
def test_whitened_samples_are_independent(memory):
    apart = spacing(np.array([0, 1, 2, 4, 5, 6, 7, 9]))
    places = np.cumsum(np.where(np.isfinite(apart), apart, 0.0))
    steps = np.abs(np.subtract.outer(places, places))
    covariance = 4.0 * (0.6 * memory**steps + 0.4 * (steps == 0))
    whiten = ChannelNoise(memory, 0.4, 2.0).whitened(np.eye(len(apart)), apart)
    assert whiten @ covariance @ whiten.T == pytest.approx(np.eye(len(apart)), abs=1e-9)


def test_a_drift_is_no_noise_with_a_long_memory():
    found = estimated(np.cumsum(np.random.default_rng(3).normal(size=2000)), spacing(np.arange(2000)))
    assert found.memory == LONGEST_MEMORY


def test_whitening_makes_independent_values_of_one():
    drawn = noise(np.random.default_rng(4), 0.6)
    white = ChannelNoise(0.6, scale=2.5).whitened(drawn, spacing(np.arange(3000)))
    assert np.corrcoef(white[1:], white[:-1])[0, 1] == pytest.approx(0.0, abs=0.05)
    assert np.std(white) == pytest.approx(np.sqrt(5.0 / 3.0), rel=0.1)


def test_the_likelihood_is_that_of_students_t():
    assert log_likelihood(np.array([0.0])) == pytest.approx(np.log(0.3796), abs=1e-3)


def both_parts(chance, count=4000):
    """Noise of unit variance, 40 % of it white, the rest with a memory of 0.8."""
    remembers = noise(chance, 0.8, count)
    return np.sqrt(0.6) * remembers / np.std(remembers) + np.sqrt(0.4) * chance.standard_t(5, count) * np.sqrt(3.0 / 5.0)


def test_a_white_part_is_told_from_one_that_remembers():
    drawn = both_parts(np.random.default_rng(5))
    found = estimated(drawn, spacing(np.arange(4000)))
    assert found.memory == pytest.approx(0.8, abs=0.06)
    assert found.white == pytest.approx(0.4, abs=0.12)  # a little less, for large values are trusted less
    assert found.lag1 == pytest.approx(0.48, abs=0.1)
    assert found.sigma == pytest.approx(1.0, rel=0.15)


def test_differences_tell_the_same_noise_beneath_a_slow_gap():
    drawn = both_parts(np.random.default_rng(6))
    slow = 5.0 * np.sin(np.linspace(0.0, 20.0, 4000))
    runs = [((drawn + slow)[part], spacing(np.arange(2000))) for part in (slice(0, 2000), slice(2000, None))]
    found = from_differences(runs)
    assert found.lag1 == pytest.approx(0.48, abs=0.1)
    assert found.scale == pytest.approx(1.0, rel=0.15)


def test_series_too_short_for_a_difference_have_no_noise():
    assert from_differences([(np.zeros(1), spacing(np.arange(1)))]).scale == 0.0
    assert from_differences([(np.ones(40), spacing(np.arange(40)))]).scale == 0.0


def test_a_run_that_stands_still_for_long_in_coarse_steps_has_the_noise_of_where_it_moves():
    chance, still = np.random.default_rng(8), np.zeros(200)
    found = from_differences([(np.concatenate([still, chance.normal(size=150)]), spacing(np.arange(350)))])
    assert found.lag1 < 0.2
    assert 0.4 < found.scale < 1.2


@pytest.mark.parametrize("kept", [np.arange(60), np.array([0, 1, 4, 5, 6, 11, 12, 40])])
def test_whitening_is_that_of_the_covariance_whatever_is_missing(kept):
    of, apart = ChannelNoise(0.7, 0.3, 1.5), spacing(kept)
    covariance = 1.5**2 * (0.7 * 0.7 ** np.abs(kept[:, None] - kept) + 0.3 * np.eye(len(kept)))
    columns = np.random.default_rng(7).normal(size=(len(kept), 3))
    white = of.whitened(columns, apart)
    assert white.T @ white == pytest.approx(columns.T @ np.linalg.solve(covariance, columns))
    residual, taken = columns[:, 0], log_likelihood(of.whitened(columns[:, 0], apart))
    assert log_probability(of, residual, apart) == pytest.approx(taken - 0.5 * np.linalg.slogdet(covariance)[1])
