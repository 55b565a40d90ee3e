"""Poses between the samples of a simulation, and how long one has to be."""

from __future__ import annotations

import numpy as np
import pytest

from identify.estimation.observation import RunRelease, between, duration_for, poses_at, rig_time
from simulate.effects import TimeOffset
from simulate.kernel.layout import POSE_SIZE

PLACES = np.array([0.0, 0.3, 2.5, 7.99, 11.0])


@pytest.mark.parametrize(("rows", "degree"), [(12, 5), (6, 5), (4, 3), (2, 1)])
def test_a_polynomial_through_the_nearest_samples_is_exact_also_at_the_ends(rows, degree):
    chance = np.random.default_rng(0)
    factors = chance.normal(size=(degree + 1, 3))
    at = PLACES[rows - 1 >= PLACES]
    x, places = np.arange(rows) / rows, at / rows
    table = np.vander(x, degree + 1, increasing=True) @ factors
    found = between(table, at)
    assert found == pytest.approx(np.vander(places, degree + 1, increasing=True) @ factors, abs=1e-9)


def samples(good, rows=12):
    made = np.arange(rows)[:, None] * np.arange(1.0, POSE_SIZE + 1.0)
    made[good:, 1] = np.nan
    return made


def test_behind_a_sample_that_is_not_finite_and_behind_the_last_one_nothing_is_seen():
    whole = poses_at(samples(12), PLACES)
    assert whole == pytest.approx(PLACES[:, None] * np.arange(1.0, POSE_SIZE + 1.0))
    cut = poses_at(samples(4), np.array([0.5, 3.0, 3.1, 8.0]))
    assert cut[:2] == pytest.approx(whole[1:2] / 0.3 * np.array([[0.5], [3.0]]))
    assert np.isnan(cut[2:]).all()
    assert poses_at(samples(4), np.array([0.5, 3.0])) == pytest.approx(cut[:2])
    assert poses_at(samples(2), np.array([0.3])) == pytest.approx(whole[1:2])
    beyond = poses_at(samples(12), np.array([10.5, 11.5]))
    assert np.isfinite(beyond[0]).all()
    assert np.isnan(beyond[1]).all()
    assert np.isnan(poses_at(samples(1), np.array([0.0, 2.0]))).all()


def test_a_simulation_covers_the_last_frame_and_a_margin_in_steps_that_runs_share():
    times = np.array([0.0, 0.31])
    lengths = [duration_for(times, RunRelease(instant_s=instant)) for instant in (0.0, 0.05, -0.05, 9.0)]
    step = lengths[3]
    assert np.array(lengths[:3]) / step == pytest.approx(np.round(np.array(lengths[:3]) / step))
    for length, instant in zip(lengths, (0.0, 0.05, -0.05), strict=False):
        assert 0.31 - instant + step <= length < 0.31 - instant + 2.0 * step
    assert lengths[0] - lengths[1] == pytest.approx(step)


def test_a_late_clock_is_set_right_unless_the_onset_sets_it():
    late, shown = (TimeOffset(0.02),), np.array([0.1, 0.2])
    moved = rig_time(late, shown) - shown
    assert np.abs(moved) == pytest.approx([0.02, 0.02])
    assert rig_time(late, shown, onset_s=0.15) == pytest.approx(shown)
    assert rig_time((), shown) == pytest.approx(shown)
