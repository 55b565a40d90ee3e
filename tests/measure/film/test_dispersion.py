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


def _swing(time, offset=0.0, shift=0.0, sigma=1e-4):
    return Trajectory(
        time,
        {"z_m": 0.1 * np.sin(9.0 * (time - shift)), "x_m": 0.01 * np.sin(7.0 * (time - shift)) - offset},
        {"z_m": np.full(len(time), sigma), "x_m": np.full(len(time), 2 * sigma)},
    )


def test_a_difference_is_first_minus_second_on_the_firsts_clock():
    """The second film begins 0.03 s earlier in the motion and is at other instants; x is 2 mm less in it."""
    found = compare_trajectories(_swing(TIME), _swing(0.001 + TIME * 1.01, 0.002, shift=0.03), "other")
    assert found.shift_s == pytest.approx(0.03, abs=2e-5)
    x = found.channels["x_m"]
    assert x.values == pytest.approx(np.full(len(x.values), 0.002), abs=5e-6)
    assert x.sigma == pytest.approx(np.full(len(x.values), 2e-4 * np.sqrt(2.0)))
    assert x.time_s[0] == TIME[0]
    assert TIME[-1] - 0.03 < x.time_s[-1] < TIME[-1] - 0.02
    numbers = x.summary()
    assert (numbers["rms"], numbers["max_abs"]) == (pytest.approx(0.002, abs=5e-6), pytest.approx(0.002, abs=5e-6))
    assert x.span == pytest.approx(np.ptp(_swing(TIME).channels["x_m"]))
    assert numbers["rms_percent"] == pytest.approx(100.0 * numbers["rms"] / x.span)
    assert numbers["rms_of_noise"] == pytest.approx(2e-4 * np.sqrt(2.0))


def test_of_a_channel_that_hardly_moves_there_are_no_percents():
    noise = 1e-3 * np.sqrt(2.0)
    for span, known in ((19.0 * noise, False), (21.0 * noise, True)):
        still = Trajectory(TIME, {"z_m": np.linspace(0.0, span, len(TIME))}, {"z_m": np.full(len(TIME), 1e-3)})
        assert (compare_trajectories(still, still, "same").channels["z_m"].summary()["rms_percent"] is not None) == known
    bare = Trajectory(TIME, {"z_m": TIME})
    assert compare_trajectories(bare, bare, "same").channels["z_m"].summary()["rms_of_noise"] is None


def test_films_that_hardly_overlap_are_refused():
    with pytest.raises(InputError, match="hardly overlaps"):
        compare_trajectories(_swing(TIME), _swing(TIME + 5.0), "later")
    at_rest = Trajectory(TIME, {"z_m": np.zeros(len(TIME))})
    assert compare_trajectories(at_rest, at_rest, "same").sigma_shift_s is None


def test_the_table_of_differences_holds_each_channel_at_its_own_instants():
    second = _swing(TIME)
    second.channels["x_m"][10:20] = np.nan
    first = _swing(TIME)
    first.channels["x_m"][40] = np.nan
    frame = compare_trajectories(first, second, "other").to_frame()
    assert list(frame["time_s"]) == list(TIME)
    assert list(np.flatnonzero(np.isnan(frame["x_m"]))) == [40]
    assert not np.isnan(frame["z_m"]).any()
    assert frame["sigma_z_m"].iloc[3] == pytest.approx(1e-4 * np.sqrt(2.0))


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 3e-3])
def test_the_shift_is_as_well_known_as_its_scatter_over_many_films_and_not_drawn_to_the_middle_between_frames(noise):
    """Noise of 3 mm at 250 frames a second is half a metre a second, where the platform moves as fast."""
    true = 0.3 / 250.0

    def noisy(seed, shift):
        table = _swing(TIME, shift=shift)
        return Trajectory(TIME, {"z_m": table.channels["z_m"] + np.random.default_rng(seed).normal(0.0, noise, len(TIME))})

    found = [compare_trajectories(noisy(2 * seed, 0.0), noisy(2 * seed + 1, true), "other") for seed in range(40)]
    shifts = np.array([one.shift_s for one in found])
    stated = float(np.mean([one.sigma_shift_s or 0.0 for one in found]))
    assert 0.6 < np.std(shifts) / stated < 1.6
    assert abs(np.mean(shifts) - true) < 4.0 * stated / np.sqrt(len(found))
