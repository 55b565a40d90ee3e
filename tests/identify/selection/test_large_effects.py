"""A large effect is not held back: neither by its prior, nor where an amplitude and a direction stand in for each other at a bound."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from identify.estimation.covariance import within_bounds
from identify.estimation.least_squares import solve, to_the_end
from identify.selection.findings import _stated
from identify.selection.promises import posed, promises
from identify.selection.weighing import weighed
from simulate.effects import CATALOGUE, BaseExcitation, EddyDamping

NAME = "eddy-damping"


@pytest.mark.slow
def test_a_brake_of_two_hundred_noticeable_sizes_brings_most_of_what_it_meets_in_films_alone(campaign, fitted):
    hidden = EddyDamping(damping_N_s_per_m=10.0, speed_m_per_s=0.25)
    at = weighed(fitted(campaign(hidden, 41, loops=(), deployments=({},), hold_out=False)))
    (promise,) = (one for one in promises(at, {NAME: CATALOGUE[NAME]}) if one.name == NAME)
    problem, start = posed(at, promise)
    found = weighed(to_the_end(solve(problem, start)))
    met = found.evidence.log_likelihood - at.evidence.log_likelihood
    assert found.leaves_noise
    assert found.log_z - at.log_z > 0.8 * met > 0.0
    assert promise.log_z - at.log_z > 0.5 * met


@pytest.mark.parametrize("seed", range(20))
def test_a_step_within_bounds_is_the_likeliest_one_where_a_single_bound_cuts_it(seed):
    chance = np.random.default_rng(seed)
    root = np.linalg.qr(chance.normal(size=(5, 5)))[0] * chance.uniform(0.2, 3.0, 5)
    step, covariance = chance.normal(size=5), root @ root.T
    low, high = np.full(5, -np.inf), np.full(5, np.inf)
    high[2] = step[2] - 1.0
    white = np.linalg.inv(np.linalg.cholesky(covariance))
    assert within_bounds(step, covariance, low, high) == pytest.approx(lsq_linear(white, white @ step, (low, high)).x, abs=1e-6)


def test_a_step_within_bounds_leaves_none_of_them():
    chance = np.random.default_rng(3)
    for _ in range(50):
        root, step = chance.normal(size=(6, 6)), 3.0 * chance.normal(size=6)
        low, high = -chance.uniform(0.1, 2.0, 6), chance.uniform(0.1, 2.0, 6)
        found = within_bounds(step, root @ root.T, low, high)
        assert np.all((low <= found) & (found <= high))


@pytest.mark.parametrize("amplitude", [0.886, -0.886])
def test_an_excitation_is_stated_with_an_axis_of_length_one_and_acts_the_same(amplitude):
    fitted = BaseExcitation(acceleration_m_per_s2=amplitude, frequency_Hz=16.7, phase_rad=3.03, axis=(0.65, -0.79, -1.0))
    stated, pose = fitted.as_stated(), np.zeros(7)
    assert np.linalg.norm(stated.axis) == pytest.approx(1.0)
    assert stated.axis[2] > 0.0
    assert stated.acceleration_m_per_s2 > 0.0
    for time in np.linspace(0.0, 0.6, 7):
        forces = np.zeros((2, 6))
        for effect, force in zip((fitted, stated), forces, strict=True):
            BaseExcitation.platform_wrench(time, pose, pose, np.array([*effect.flat(), 2.0]), force)
        assert forces[0] == pytest.approx(forces[1], abs=1e-12)
        assert np.any(forces[0])
    assert replace(fitted, axis=(0.0, 0.0, 0.0)).as_stated().axis == (0.0, 0.0, 0.0)


def test_an_amplitude_and_its_axis_that_stand_in_for_each_other_are_well_known_as_stated():
    fitted = BaseExcitation(acceleration_m_per_s2=0.8, frequency_Hz=16.7, phase_rad=0.5, axis=(0.5, -0.5, 1.0))
    low, high = (np.array(ends) for ends in zip(*BaseExcitation.bounds().values(), strict=True))
    stated, slopes = _stated(fitted, low, high)
    along = np.array([-0.8, 0.0, 0.0, *fitted.axis])  # a larger amplitude along a shorter axis
    assert slopes @ along == pytest.approx(np.zeros(6), abs=1e-4)
    assert stated.flat()[0] == pytest.approx(0.8 * np.linalg.norm(fitted.axis))
