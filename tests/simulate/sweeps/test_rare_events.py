"""Subset simulation against failures whose probability is known."""

import numpy as np
import pytest
from scipy.stats import norm

from simulate.sweeps.rare_events import subset_simulation

ALONG = np.array([1, -1, 1, -1, 1, -1]) / np.sqrt(6)


def plane(places):
    return places @ ALONG


@pytest.mark.parametrize("probability", [1e-5, 1e-6])
def test_a_rare_failure_is_found_within_a_factor_of_two_in_95_percent_and_lies_in_its_intervals(probability):
    limit = float(norm.isf(probability))
    found = [subset_simulation(plane, 6, limit, 2000, seed) for seed in range(60)]
    share = np.array([one.probability for one in found]) / probability
    assert np.mean((share > 0.5) & (share < 2.0)) >= 0.95
    assert np.mean(share) == pytest.approx(1.0, abs=0.15)
    assert np.mean([one.interval[0] < probability < one.interval[1] for one in found]) >= 0.85
    assert max(one.runs for one in found) < 16_000


def test_a_failure_on_two_sides_is_the_sum_of_both():
    found = [subset_simulation(lambda x: np.abs(plane(x)), 6, float(norm.isf(1e-4)), 2000, seed).probability for seed in range(20)]
    assert np.mean(found) == pytest.approx(2e-4, rel=0.2)


def test_a_failure_that_is_not_rare_is_counted_on_plain_draws():
    found = subset_simulation(plane, 6, float(norm.isf(0.3)), 1000, 0)
    assert found.thresholds == ()
    assert found.runs == 1000
    low, high = found.interval
    assert low < 0.3 < high
    assert found.variation == pytest.approx(np.sqrt(0.7 / 0.3 / 1000), rel=0.1)


def test_what_never_fails_gives_a_bound_and_says_so():
    found = subset_simulation(lambda x: -np.abs(x[:, 0]) - 1.0, 2, 0.0, 200, 0)
    assert not found.reached
    assert found.report["interval"][0] == 0.0
    assert found.probability < 1e-10


def test_states_of_infinite_size_are_failures():
    found = subset_simulation(lambda x: np.where(plane(x) > norm.isf(1e-3), np.inf, plane(x)), 6, 100.0, 1000, 1)
    assert found.probability == pytest.approx(1e-3, rel=0.5)


def test_the_same_seed_gives_the_same_digits():
    one, two = (subset_simulation(plane, 6, 4.0, 500, 5) for _ in range(2))
    assert one == two
