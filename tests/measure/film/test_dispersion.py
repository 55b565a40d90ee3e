"""Two deployments compared."""

from __future__ import annotations

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.film.dispersion import compare_trajectories
from measure.tables.trajectory import Trajectory

TIME = np.arange(150) / 250.0


def _deployment(time, height=0.4, seed=0, noise=1e-5):
    s = np.clip(time / 0.5, 0.0, 1.0)
    z = 0.252 + height * s**2 * (3 - 2 * s) + np.random.default_rng(seed).normal(0.0, noise, len(time))
    return Trajectory(TIME, {"z_m": z}, {"z_m": np.full(len(time), noise)})


def test_a_later_shutter_is_no_dispersion():
    found = compare_trajectories(_deployment(TIME), _deployment(TIME - 0.0137, seed=1), "late")
    assert abs(found.shift_s - 0.0137) < 5e-5
    assert found.sigma_shift_s is not None
    assert abs(found.shift_s - 0.0137) < 4 * found.sigma_shift_s
    assert found.channels["z_m"].summary()["rms_percent"] < 0.02


def test_a_deployment_that_goes_five_percent_higher_disperses_by_percents():
    found = compare_trajectories(_deployment(TIME), _deployment(TIME, height=0.42, seed=1), "higher")
    numbers = found.channels["z_m"].summary()
    assert 1.0 < numbers["rms_percent"] < 5.0
    assert 3.0 < numbers["max_percent"] <= 5.5
    assert abs(numbers["rms_of_noise"] - 1.4e-5) < 2e-6


def test_what_is_never_measured_together_cannot_be_compared():
    with pytest.raises(InputError, match="shares no channel"):
        compare_trajectories(_deployment(TIME), Trajectory(TIME, {"x_m": TIME}), "other")
