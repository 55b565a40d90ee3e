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


def hardly_known(seed):
    """A matrix (4, 4) of parameters of very different units, the last of which does what the first does, and a step."""
    chance = np.random.default_rng(seed)
    table = chance.normal(size=(9, 4)) * [1.0, 30.0, 1e-3, 1.0]
    table[:, 3] = table[:, 0] + 1e-3 * chance.normal(size=9)
    return table.T @ table, chance.normal(size=4) / [1.0, 30.0, 1e-3, 1.0]


@pytest.mark.parametrize("seed", range(5))
def test_a_matrix_is_known_by_its_factors(seed):
    matrix, step = hardly_known(seed)
    found = Factored.of(matrix)
    assert found.over(step) == pytest.approx(step @ matrix @ step, rel=1e-6)
    assert found.inverse @ matrix == pytest.approx(np.eye(4), abs=1e-2)
    assert found.length(step) == pytest.approx(np.sqrt(np.sum(np.diag(matrix) * step**2)))


@pytest.mark.parametrize("share", [0.9, 0.3, 1e-2, 1e-4])
@pytest.mark.parametrize("seed", range(5))
def test_no_step_of_the_same_length_promises_more_than_a_shortened_one(seed, share):
    matrix, step = hardly_known(seed)
    found, chance = Factored.of(matrix), np.random.default_rng(seed)
    best = found.shortened(step, share * found.length(step))
    assert found.length(best) == pytest.approx(share * found.length(step), rel=1e-2)
    others = [best + 10.0 ** chance.uniform(-6.0, 0.0) * chance.normal(size=4) * np.abs(best) for _ in range(300)]
    others = [other * found.length(best) / found.length(other) for other in [*others, step]]
    left = found.over(step - best)
    assert min(found.over(step - other) for other in others) > left - 1e-6 * found.over(step)


def test_what_is_hardly_known_is_left_first():
    found = Factored.of(hardly_known(0)[0])
    both, along = np.array([1.0, 0.0, 0.0, 1.0]), np.array([100.0, 0.0, 0.0, -100.0])  # two that do the same
    shorter = found.shortened(both + along, found.length(both))
    assert shorter[0] + shorter[3] == pytest.approx(2.0, abs=0.02)
    assert np.abs(shorter[0] - shorter[3]) < 0.1


@pytest.mark.parametrize("length", [np.inf, 1.0, 1.0 - 1e-12])
def test_a_step_that_is_not_too_long_is_left_as_it_is(length):
    step = np.array([0.6, 0.8])
    assert Factored.of(np.eye(2)).shortened(step, length) is step


@pytest.mark.parametrize(
    ("promised", "length", "lengths"),
    [
        (2.4, np.inf, [10.0, 5.0, 2.5, 1.25, 0.625, 0.3125, 0.15625]),  # of 10 units: a share s promises 100 (1 - (1 - s)^2)
        (3.2, np.inf, [10.0, 5.0, 2.5, 1.25, 0.625, 0.3125]),
        (2.4, 1.0, [1.0, 0.5, 0.25, 0.125]),
        (30.0, 0.5, [2.0]),  # shorter ones promise less
        (90.0, 0.5, [8.0]),
        (99.0, 0.6, [9.6]),
        (99.9, 0.6, [10.0]),
        (100.1, 0.5, []),
        (100.1, np.inf, []),
    ],
)
def test_ever_shorter_steps_are_offered_while_they_promise_enough(promised, length, lengths):
    steps = list(Factored.of(np.array([[100.0]])).ever_shorter(np.ones(1), promised, length))
    assert [reached for reached, _ in steps] == pytest.approx(lengths)
    assert [float(step[0]) for _, step in steps] == pytest.approx(np.array(lengths) / 10.0, rel=2e-3)


@pytest.mark.parametrize("seed", range(20))
def test_variances_of_parameters_that_do_the_same_stay_positive(seed):
    """Three of any size, one that does what the first does and one what all of them do: a plain inverse has negative ones here."""
    chance = np.random.default_rng(seed)
    table = chance.normal(size=(200, 3)) * 10.0 ** chance.uniform(0.0, 5.0, 3)
    table = np.column_stack([table, table[:, 0] * chance.normal(), table @ chance.normal(size=3)])
    variances = np.diag(Factored.of(table.T @ table + 1e-8 * np.eye(5)).inverse)
    assert np.all(variances > 0.0)
