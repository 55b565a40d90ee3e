"""The covariance of least squares on linear problems whose covariance is known, or drawn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from identify.estimation.covariance import Factored, clipped, own_shares, sandwich, scatter, shift_of, smoothed_power

N = 600
X = np.linspace(-1.0, 1.0, N)
TABLE = np.stack([np.ones(N), X, np.sin(40.0 * X)], axis=1) * [1.0, 30.0, 1e-3]
ALL = np.ones(3, dtype=bool)


def drawn(rho, number=60):
    """Errors and gaps of fits to noise of unit variance with a memory."""
    made = []
    for seed in range(number):
        noise = lfilter([np.sqrt(1.0 - rho**2)], [1.0, -rho], np.random.default_rng(seed).normal(size=N + 100))[100:]
        found = np.linalg.lstsq(TABLE, noise, rcond=None)[0]
        made.append((found, noise - TABLE @ found))
    return made


@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_standard_errors_are_those_that_repeated_fits_have_whatever_the_colour_of_the_noise(rho):
    fits = drawn(rho)
    seen = np.std([found for found, _ in fits], axis=0)
    said = np.sqrt(np.mean([np.diag(sandwich(TABLE, gap, [slice(0, N)], ALL)) for _, gap in fits], axis=0))
    assert np.all(said[:2] / seen[:2] < 1.6)
    assert np.all(said[:2] / seen[:2] > 0.75)


def test_noise_below_its_level_is_taken_at_its_level_and_louder_noise_as_it_is():
    gap = np.random.default_rng(3).normal(size=N)
    gap /= np.std(gap)
    quiet, loud = (sandwich(TABLE, size * gap, [slice(0, N)], ALL) for size in (0.01, 10.0))
    usual = np.linalg.inv(TABLE.T @ TABLE)
    assert np.diag(quiet) / np.diag(usual) == pytest.approx(np.ones(3), rel=0.5)
    assert np.diag(loud) / np.diag(quiet) == pytest.approx(100.0 * np.ones(3), rel=0.01)


def test_a_prior_narrows_its_own_parameter_to_its_spread():
    """Ten thousand times tighter than the measurements, so that nothing else counts."""
    whole = np.vstack([TABLE, [0.0, 1e5, 0.0]])
    gap = np.append(np.random.default_rng(4).normal(size=N), 0.0)
    assert np.sqrt(sandwich(whole, gap, [slice(0, N)], ALL)[1, 1]) == pytest.approx(1e-5, rel=1e-3)


def test_a_parameter_at_its_bound_is_no_error_of_the_others_and_keeps_a_variance_of_its_own():
    table = np.stack([X, X + 0.1 * np.sin(9.0 * X)], axis=1)
    gap = np.random.default_rng(5).normal(size=N)
    free = np.array([True, False])
    both, held = (sandwich(table, gap, [slice(0, N)], clear) for clear in (np.ones(2, bool), free))
    alone = sandwich(table[:, :1], gap, [slice(0, N)], np.ones(1, bool))
    assert held[0, 0] == pytest.approx(alone[0, 0])
    assert held[1, 1] == pytest.approx(both[1, 1])
    assert held[0, 1] == held[1, 0] == 0.0


def test_the_smoothed_power_of_white_noise_is_its_variance_at_every_frequency():
    power = np.mean([smoothed_power(np.random.default_rng(seed).normal(0.0, 2.0, 256)) for seed in range(60)], axis=0)
    assert len(power) == 257
    assert power[20:] == pytest.approx(4.0 * np.ones(237), rel=0.15)
    assert np.all(power[:20] < 9.0)


def test_the_power_of_a_slow_wave_is_at_its_frequency():
    power = smoothed_power(np.sin(2.0 * np.pi * 60.0 * np.arange(512) / 512.0))
    assert abs(int(np.argmax(power)) - 120) <= 24
    assert power[300:].max() < 0.01 * power.max()
    assert power[:40].max() < 0.01 * power.max()


def test_the_scatter_of_white_noise_is_the_normal_matrix():
    found = np.mean([scatter(TABLE[:, :2], np.random.default_rng(seed).normal(size=N)) for seed in range(20)], axis=0)
    normal = TABLE[:, :2].T @ TABLE[:, :2]
    assert np.diag(found) / np.diag(normal) == pytest.approx(np.ones(2), rel=0.35)


def test_parameters_bend_to_an_error_of_the_gaps_as_a_fit_does():
    change = np.random.default_rng(6).normal(size=N)
    assert shift_of(TABLE, change, ALL) == pytest.approx(-np.linalg.lstsq(TABLE, change, rcond=None)[0])
    held = shift_of(TABLE, change, np.array([True, False, True]))
    assert held[1] == 0.0
    assert held[[0, 2]] == pytest.approx(-np.linalg.lstsq(TABLE[:, [0, 2]], change, rcond=None)[0])


def test_outliers_are_cut_at_three_robust_standard_deviations_and_priors_are_left():
    gaps = np.concatenate([np.random.default_rng(7).normal(size=2000), [50.0, -50.0, 40.0]])
    cut = clipped(gaps, [slice(0, 1000), slice(1000, 2002)])
    assert cut[-3] == pytest.approx(3.0, abs=0.2)
    assert cut[-2] == -cut[-3]
    assert cut[-1] == 40.0


def test_the_own_share_is_the_sine_of_the_angle_to_what_others_can_do():
    angle = np.radians(20.0)
    table = np.array([[1.0, np.cos(angle), 0.0, 0.0], [0.0, 7.0 * np.sin(angle), 0.0, 0.0], [0.0, 0.0, 3.0, 0.0]])
    table[0, 1] *= 7.0
    assert own_shares(table) == pytest.approx([np.sin(angle), np.sin(angle), 1.0, 0.0])


@pytest.mark.parametrize("seed", range(5))
def test_a_damped_step_is_that_of_a_matrix_with_a_larger_diagonal_and_leaves_what_is_hardly_known(seed):
    chance = np.random.default_rng(seed)
    table = chance.normal(size=(9, 4)) * [1.0, 30.0, 1e-3, 1.0]
    table[:, 3] = table[:, 0] + 1e-3 * chance.normal(size=9)
    matrix, step = table.T @ table, chance.normal(size=4) / [1.0, 30.0, 1e-3, 1.0]
    found = Factored.of(matrix)
    assert found.over(step) == pytest.approx(step @ matrix @ step, rel=1e-6)
    assert found.inverse @ matrix == pytest.approx(np.eye(4), abs=1e-2)
    expected = np.linalg.solve(matrix + 0.1 * np.diag(np.diag(matrix)), matrix @ step)
    assert found.damped(step, 0.1) == pytest.approx(expected, rel=1e-6)
    along = np.array([1.0, 0.0, 0.0, -1.0])  # of two that do the same
    assert np.abs(found.damped(along, 0.1)[[0, 3]]).max() < 1e-3


@pytest.mark.parametrize("seed", range(20))
def test_variances_of_parameters_that_do_the_same_stay_positive(seed):
    """Three of any size, one that does what the first does and one what all of them do: a plain inverse has negative ones here."""
    chance = np.random.default_rng(seed)
    table = chance.normal(size=(200, 3)) * 10.0 ** chance.uniform(0.0, 5.0, 3)
    table = np.column_stack([table, table[:, 0] * chance.normal(), table @ chance.normal(size=3)])
    variances = np.diag(Factored.of(table.T @ table + 1e-8 * np.eye(5)).inverse)
    assert np.all(variances > 0.0)
