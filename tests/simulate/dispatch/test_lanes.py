"""Numbers of runs side by side: the same operators and functions as of one number."""

import math

import numpy as np
import pytest
from numba import njit

from simulate.dispatch import lane_functions as lane_functions
from simulate.dispatch.counted_noise import normal, uniform
from simulate.dispatch.lanes import all_of, any_of, chosen, from_row, inverse_root, larger, rows_at, smaller
from simulate.kernel.mechanics import error_function

N = 8
LEFT = np.array([-30.0, -1.5, -1e-9, 0.0, 0.3, 2.0, 40.0, 650.0])
RIGHT = np.array([0.5, -2.0, 3.0, 4.0, -0.25, 1.0, 7.0, 0.1])


def computed(function):
    """What a function of two rows gives, with each product rounded by itself."""

    @njit
    def run(memory):
        w = rows_at(memory, N, False)
        w[2] = function(w[0], w[1])

    memory = np.concatenate([LEFT, RIGHT, np.zeros(N)])
    run(memory)
    return memory[2 * N :]


@pytest.mark.parametrize(
    "function",
    [
        njit(lambda a, b: a + 2.0 * b - a / b),
        njit(lambda a, b: -a * b),
        njit(lambda a, b: abs(a) + 1.0),
        njit(lambda a, b: larger(a, b) - smaller(a, 1.0)),
        njit(lambda a, b: max(a, 0.0) + min(b, 1.0)),
        njit(lambda a, b: b**2),
    ],
)
def test_operators_are_those_of_numbers_to_the_last_digit(function):
    assert computed(function).tolist() == [function(a, b) for a, b in zip(LEFT, RIGHT, strict=True)]


@pytest.mark.parametrize(
    ("function", "exact"),
    [
        (njit(lambda a, b: math.exp(a)), np.exp(LEFT)),
        (njit(lambda a, b: math.tanh(a)), np.tanh(LEFT)),
        (njit(lambda a, b: math.sqrt(abs(a))), np.sqrt(np.abs(LEFT))),
        (njit(lambda a, b: math.sin(a) + math.cos(b)), np.sin(LEFT) + np.cos(RIGHT)),
        (njit(lambda a, b: math.log(abs(b))), np.log(np.abs(RIGHT))),
        (njit(lambda a, b: abs(b) ** 1.5), np.abs(RIGHT) ** 1.5),
        (njit(lambda a, b: abs(a) ** b), np.abs(LEFT) ** RIGHT),
        (njit(lambda a, b: math.log(1.0 + 1e-9 * abs(b))), np.log(1.0 + 1e-9 * np.abs(RIGHT))),
    ],
)
def test_functions_are_those_of_the_library_to_some_last_digits(function, exact):
    np.testing.assert_allclose(computed(function), exact, rtol=5e-15, atol=0)


def test_a_stop_sets_in_as_the_error_function_of_the_library():
    @njit
    def run(memory):
        w = rows_at(memory, N, True)
        w[1] = error_function(w[0])

    for eight in np.linspace(0.0, 6.0, 4000).reshape(-1, N):
        memory = np.concatenate([eight, np.zeros(N)])
        run(memory)
        np.testing.assert_allclose(memory[N:], [math.erf(x) for x in eight], rtol=0, atol=1e-15)


def test_roots_of_a_sweep_are_those_of_the_library_to_the_last_digits():
    @njit
    def run(memory):
        w = rows_at(memory, 16, True)
        w[1], w[2] = math.sqrt(w[0]), inverse_root(w[0])

    at = np.concatenate([[0.0, 1e-300, 4e-12, 1.0, 2.0, 3.0, 1e300, -1.0], np.random.default_rng(0).uniform(0.0, 9.0, 8)])
    memory = np.concatenate([at, np.zeros(32)])
    run(memory)
    with np.errstate(all="ignore"):
        np.testing.assert_allclose(memory[16:32], np.sqrt(at), rtol=1e-15)
        np.testing.assert_allclose(memory[33:], 1.0 / np.sqrt(at[1:]), rtol=1e-15)


@njit
def _all_functions(memory):
    w = rows_at(memory, N, False)
    w[1], w[2], w[3], w[4] = math.sin(w[0]), math.cos(w[0]), math.exp(w[0]), math.tanh(w[0])
    w[5], w[6], w[7] = math.log(abs(w[0])), abs(w[0]) ** 2.5, abs(w[0]) ** 3


def found_at(at):
    """(7, n) values of the functions at so many places; their number is cut to whole blocks."""
    blocks = []
    for eight in np.asarray(at)[: len(at) // N * N].reshape(-1, N):
        memory = np.concatenate([eight, np.zeros(7 * N)])
        _all_functions(memory)
        blocks.append(memory.reshape(8, N)[1:])
    return np.concatenate(blocks, axis=1)


def test_waves_are_those_of_the_library_over_many_turns_and_beyond():
    at = np.concatenate(
        [np.linspace(-20.0, 20.0, 4001), np.linspace(-9.9e4, 9.9e4, 4000), [1e5, -1e7, 1e15], np.arange(-40, 40) * np.pi / 2]
    )
    found = found_at(at)
    for row, name in enumerate(("sin", "cos")):
        np.testing.assert_allclose(found[row], getattr(np, name)(at[: found.shape[1]]), rtol=1e-15, atol=5e-16)


def test_exponentials_are_those_of_the_library_as_far_as_numbers_go():
    at = np.concatenate([np.linspace(-700.0, 700.0, 2001), np.linspace(-2.0, 2.0, 2001), [1e-12, -1e-12, 1e-300, 0.0, 690.0, -650.0]])
    found = found_at(at)
    at = at[: found.shape[1]]
    np.testing.assert_allclose(found[2], np.exp(at), rtol=2e-15)
    np.testing.assert_allclose(found[3], np.tanh(at), rtol=1e-15)


def test_logarithms_and_powers_are_those_of_the_library_from_the_smallest_number_to_the_largest():
    near_one = 1.0 + np.concatenate([np.logspace(-15.0, -0.5, 300), -np.logspace(-15.0, -0.5, 300)])
    at = np.concatenate(
        [np.logspace(-307.0, 307.0, 1200), near_one, np.linspace(0.7, 1.5, 400), [5e-310, 1e-301, 1e301, 1e305, 0.0, 2.0, 4.0, 8.0]]
    )
    found = found_at(at)
    with np.errstate(all="ignore"):
        np.testing.assert_allclose(found[4], np.log(at), rtol=1e-15)
    plain = (at > 1e-90) & (at < 1e90)
    np.testing.assert_allclose(found[5:, plain], [at[plain] ** 2.5, at[plain] ** 3], rtol=3e-13)
    assert found[5:, at == 0.0].tolist() == [[0.0], [0.0]]


def splitmix64(seed, sample, place):
    """By Python's whole numbers: Steele, Lea and Flood 2014."""
    z = ((seed << 28) + (sample << 4) + place + 1) * 0x9E3779B97F4A7C15 % 2**64
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
    z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
    return ((z ^ z >> 31) >> 11) / 2**53 + 2.0**-54


def test_noise_that_is_counted_is_splitmix64_and_normal_by_box_and_muller():
    @njit
    def run(memory):
        w = rows_at(memory, N, False)
        w[2], w[3] = uniform(w[0], w[1], 5), normal(w[0], w[1], 2)

    seeds, samples = [0, 1, 2, 77, 2**24, 3, 4, 5], [0, 1, 0, 1000, 2**20, 7, 8, 9]
    memory = np.concatenate([seeds, samples, np.zeros(2 * N)]).astype(float)
    run(memory)
    even = [splitmix64(*both, 5) for both in zip(seeds, samples, strict=True)]
    assert memory[2 * N : 3 * N].tolist() == even
    radius = np.sqrt(-2.0 * np.log([splitmix64(*both, 4) for both in zip(seeds, samples, strict=True)]))
    np.testing.assert_allclose(memory[3 * N :], radius * np.cos(2.0 * np.pi * np.array(even)), rtol=1e-13, atol=1e-14)


def test_a_choice_is_made_lane_by_lane_and_a_mask_can_be_asked():
    @njit
    def run(memory):
        w = rows_at(memory, N, False)
        w[2] = chosen((w[0] > 0.0) & (w[1] < 1.0), w[0], -1.0)
        behind = from_row(w, 1)
        return any_of(behind[0] >= 7.0), all_of(behind[0] > -2.0), all_of(behind[0] >= -2.0)

    memory = np.concatenate([LEFT, RIGHT, np.zeros(N)])
    assert run(memory) == (True, False, True)
    assert memory[2 * N :].tolist() == np.where((LEFT > 0) & (RIGHT < 1), LEFT, -1.0).tolist()
