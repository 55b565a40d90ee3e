"""Errors of single coordinates of single marks, which leave no residual in the picture, show from frame to frame."""

from __future__ import annotations

import numpy as np
import pytest

from measure.geometry.own_noise import own_noise
from measure.geometry.reference_error import have_left
from measure.tables.trajectory import CHANNELS

FRAMES, DRAWS = 60, 10
MIDDLE_Y = np.zeros((6, 2), bool)
MIDDLE_Y[[1, 4], 1] = True
"""What an upright drum with quadrants has: edges along the rows of the middle marks, which stand in steps of a pixel's parts."""


def _white(drum, seed):
    return drum.sigma * np.random.default_rng([seed, 7]).normal(size=(drum.frames, 6, 2))


def _widened(drum, marks):
    noise = own_noise(marks, drum.fit(marks), have_left(marks))
    return marks if noise is None else noise.on(marks)


def _factors(drum, error_px):
    """By how much the standard deviations of every coordinate are widened, (6, 2)."""
    widened = _widened(drum, drum.seen(error_px))
    return np.sqrt(np.diagonal(widened.covariance_px2[5], axis1=1, axis2=2)) / drum.sigma


def test_white_noise_of_the_stated_size_widens_nothing(drum):
    drum = drum(frames=FRAMES)
    factors = [_factors(drum, _white(drum, seed)) for seed in range(DRAWS)]
    assert np.median(factors) < 1.05
    assert np.quantile(factors, 0.95) < 1.25


def test_a_coordinate_that_scatters_is_widened_alone(drum):
    """By five times the stated, in both stretches of the film."""
    drum = drum(frames=FRAMES)
    factors = [_factors(drum, np.where(MIDDLE_Y, 5.0, 1.0) * _white(drum, seed)) for seed in range(DRAWS)]
    median = np.median(factors, axis=0)
    assert median[MIDDLE_Y] == pytest.approx(5.0, rel=0.2)
    assert median[~MIDDLE_Y].max() < 1.4


def test_a_platform_that_shakes_is_not_noise_of_its_marks(drum):
    drum = drum(frames=FRAMES)
    shaken = drum.pose + np.random.default_rng(3).normal(size=(FRAMES, 6)) * [2e-4, 0.0, 2e-4, 0.0, 1e-3, 0.0]
    shake_px = drum.carried_px(shaken) - drum.places_px
    assert np.abs(shake_px).max() > 50 * drum.sigma
    factors = [_factors(drum, _white(drum, seed) + shake_px) for seed in range(DRAWS)]
    assert np.median(factors) < 1.1
    assert np.quantile(factors, 0.95) < 1.5


def test_weights_by_the_own_noise_make_the_pose_scatter_less_within_bars_that_hold(drum):
    drum, gaps, inside = drum(frames=FRAMES, turn_deg=5.0), [], []
    for seed in range(4):
        error = np.where(MIDDLE_Y, 8.0, 1.0) * _white(drum, seed)
        marks = drum.seen(error)
        fits = [drum.fit(marks), drum.fit(_widened(drum, marks))]
        at = [CHANNELS.index(channel) for channel in fits[0].free]
        gaps.append([(fit.pose - drum.pose)[1:, at] for fit in fits])
        sigma = np.sqrt(np.diagonal(fits[1].covariance, axis1=1, axis2=2))[1:]
        inside.append(np.abs(gaps[-1][1] / sigma) < 1.96)
    before, after = np.std(gaps, axis=2).mean(axis=0)
    assert (after < 0.95 * before).all()
    assert (after < 0.8 * before).any()
    assert 0.90 < np.mean(inside) < 0.985


def test_sightings_that_are_missing_say_nothing(drum):
    drum = drum(frames=FRAMES)
    error = np.where(MIDDLE_Y, 5.0, 1.0) * _white(drum, 1)
    whole = _factors(drum, error)
    marks = drum.seen(error)
    gone = np.zeros(marks.status.shape, bool)
    gone[20:26, 4], gone[:, 0] = True, True
    cut = np.sqrt(np.diagonal(_widened(drum, marks.without(gone, "lost")).covariance_px2[5], axis1=1, axis2=2)) / drum.sigma
    assert cut[4] == pytest.approx(whole[4], rel=0.25)
    assert np.isnan(cut[0]).all()


def test_short_films_and_single_marks_are_left_as_they_are(drum):
    short = drum(frames=20)
    assert (_factors(short, 5.0 * _white(short, 1)) == 1.0).all()


@pytest.mark.parametrize("early", [True, False])
def test_each_stretch_has_a_scatter_of_its_own_and_the_reference_image_that_of_the_first(drum, early):
    """The marks scatter by five times the stated in one half of the film alone."""
    drum = drum(frames=2 * FRAMES)
    loud = (np.arange(drum.frames) < FRAMES) == early
    marks = drum.seen(np.where(loud[:, None, None], 5.0, 1.0) * _white(drum, 4))
    noise = own_noise(marks, drum.fit(marks), have_left(marks))
    assert noise is not None
    inner = np.abs(np.arange(drum.frames) - FRAMES) > 24  # neither in a stretch of both
    deviation = np.sqrt(noise.variance)
    assert np.median(deviation[loud & inner]) == pytest.approx(5.0, rel=0.2)
    assert np.median(deviation[~loud & inner]) < 1.2
    reference = np.median(noise.reference_px2) / drum.sigma**2
    assert reference == pytest.approx(24.0, rel=0.4) if early else reference < 0.5
