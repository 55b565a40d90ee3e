"""How far standard deviations are widened for the misfit of the marks, against misfits that were drawn."""

from __future__ import annotations

from math import erf

import numpy as np
import pytest
from scipy.special import polygamma

from measure.geometry.widening import _trigamma_inverse, independent_frames, moderated, widening
from measure.tables.trajectory import CHANNELS

FRAMES, FREEDOM, DRAWS = 60, 6, 200


def _residuals(rng, kept, shape=(FRAMES, FREEDOM)):
    """White residuals of unit variance of which a share of the variance is the same in all frames."""
    common, own = rng.normal(size=(1, *shape[1:])), rng.normal(size=shape)
    return np.sqrt(kept) * common + np.sqrt(1.0 - kept) * own


def _inside(kept, variance):
    """Share of errors of a pose within 1.96 of its widened standard deviations; variance(rng) : of each frame."""
    inside = []
    for seed in range(DRAWS):
        rng = np.random.default_rng([seed, 11])
        true = np.sqrt(variance(rng) * np.ones(FRAMES))
        bar = widening(_residuals(rng, kept) * true[:, None], np.full(FRAMES, FREEDOM))[1]
        inside.append(np.mean([erf(1.96 * ratio / np.sqrt(2.0)) for ratio in bar / true]))
    return float(np.mean(inside))


def test_white_misfit_of_the_stated_size_widens_nothing():
    bars = [widening(_residuals(np.random.default_rng(seed), 0.0), np.full(FRAMES, FREEDOM))[1] for seed in range(DRAWS)]
    assert np.mean(bars) < 1.03
    assert np.quantile(bars, 0.95) < 1.15


def test_a_misfit_that_all_frames_share_is_known_by_its_degrees_of_freedom_alone():
    """Student's quantile for six degrees of freedom is 2.447."""
    deviation, bar = widening(np.full((FRAMES, FREEDOM), 3.0), np.full(FRAMES, FREEDOM))
    assert deviation == pytest.approx(3.0, rel=1e-3)
    assert bar == pytest.approx(3.0 * 2.447 / 1.96, rel=2e-3)


@pytest.mark.parametrize("kept", [0.0, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("size", [1.0, 3.0])
def test_bars_hold_however_much_of_the_misfit_persists(kept, size):
    """Where the standard deviations are right as they are, a misfit that persists and is large by chance still counts."""
    assert 0.945 < _inside(kept, lambda _: size**2) < (0.98 if size == 1.0 else 0.97)


@pytest.mark.parametrize("kept", [0.0, 0.5])
def test_bars_hold_where_some_frames_are_worse_than_others(kept):
    assert 0.93 < _inside(kept, lambda rng: 4.0 * 4.0 / rng.chisquare(4.0, FRAMES)) < 0.97


def test_frames_that_are_worse_than_the_others_are_widened_alone():
    scale = np.where(np.arange(FRAMES) % 10 == 3, 20.0, 1.0)
    bar = widening(_residuals(np.random.default_rng(3), 0.0) * scale[:, None], np.full(FRAMES, FREEDOM))[1]
    assert bar[scale > 1.0].min() > 8.0
    assert np.median(bar[scale == 1.0]) < 1.4


def test_independent_frames_are_counted():
    known = np.ones(FRAMES, bool)
    assert independent_frames(np.ones((FRAMES, FREEDOM)), known, FREEDOM) == pytest.approx(1.0, abs=0.01)
    white = [independent_frames(_residuals(np.random.default_rng(seed), 0.0), known, FREEDOM) for seed in range(DRAWS)]
    half = [independent_frames(_residuals(np.random.default_rng(seed), 0.5), known, FREEDOM) for seed in range(DRAWS)]
    assert np.median(white) > 0.8 * FRAMES
    assert np.median(half) == pytest.approx(FRAMES**2 / (FRAMES + FRAMES * (FRAMES - 1) * 0.25), rel=0.2)


def test_a_frame_that_says_nothing_gets_the_median():
    freedom = np.where(np.arange(FRAMES) == 7, 0, FREEDOM)
    bar = widening(5.0 * _residuals(np.random.default_rng(4), 0.0), freedom)[1]
    assert bar[7] == np.median(bar[freedom > 0])
    assert (widening(np.zeros((FRAMES, 4)), np.zeros(FRAMES, int))[1] == 1.0).all()


@pytest.mark.parametrize("kept", [0.0, 1.0])
def test_bars_of_the_pose_of_a_drum_hold_whether_or_not_its_marks_err_alike_in_all_frames(drum, kept):
    """The marks are off by five times what they say."""
    drum, inside = drum(frames=6, turn_deg=5.0), []
    for seed in range(60):
        error = 5.0 * drum.sigma * _residuals(np.random.default_rng([seed, 5]), kept, (drum.frames, 6, 2))
        inside.append(_drum_inside(drum, error))
    assert 0.90 < np.mean(inside) < 0.97


def _drum_inside(drum, error_px):
    """Which errors of the pose are within 1.96 of their standard deviations."""
    fit = drum.fit(drum.seen(error_px))
    at = [CHANNELS.index(channel) for channel in fit.free]
    ratio = (fit.pose - drum.pose)[:, at] / np.sqrt(np.diagonal(fit.covariance, axis1=1, axis2=2))
    return np.abs(ratio[1:]) < 1.96


def _white(frames=60, count=8, size=6.0, seed=4):
    return size * np.random.default_rng(seed).normal(size=(frames, count))


def test_a_misfit_of_twice_the_size_widens_twice_as_much():
    """Where all frames are worse than chance allows; bars by the same factor."""
    freedom = np.full(60, 5)
    (deviation, bar), (twice, wider) = widening(_white(), freedom), widening(2.0 * _white(), freedom)
    assert twice / deviation == pytest.approx(np.full(60, 2.0), rel=1e-9)
    assert wider / bar == pytest.approx(np.full(60, 2.0), rel=1e-9)
    assert np.all(bar >= deviation)
    assert deviation.min() > 1.0


def test_on_the_average_a_misfit_is_found_to_its_size():
    found = [widening(_white(200, 5, seed=k), np.full(200, 5))[0] for k in range(5)]
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(6.0, rel=0.03)


def test_variances_of_many_degrees_of_freedom_stay_as_they_are_and_of_one_size_agree():
    square = np.array([4.0, 9.0, 25.0, 100.0])
    assert moderated(square, np.full(4, 1e5), np.inf)[0] == pytest.approx(square, rel=1e-3)
    alike, worth = moderated(np.full(30, 7.0), np.full(30, 1e4), np.inf)
    assert alike == pytest.approx(np.full(30, 7.0), rel=1e-3)
    assert worth > 1e5


def test_variances_of_few_degrees_of_freedom_are_drawn_to_what_they_share():
    """By the stated mean of both, each with its degrees of freedom."""
    chance = np.random.default_rng(6)
    true = 30.0 * 20.0 / chance.chisquare(20, 4000)
    square, nu = true * chance.chisquare(4, 4000) / 4.0, np.full(4000, 4.0)
    found, worth = moderated(square, nu, np.inf)
    assert worth == pytest.approx(20.0, rel=0.25)
    shared = ((worth + nu) * found - nu * np.maximum(square, square.min())) / worth
    assert shared.mean() == pytest.approx(30.0, rel=0.1)
    assert np.mean((found - true) ** 2) < 0.5 * np.mean((square - true) ** 2)


@pytest.mark.parametrize("value", [1e-3, 0.1, 1.0, 7.0, 300.0])
def test_the_inverse_of_trigamma_is_its_inverse(value):
    assert polygamma(1, _trigamma_inverse(value)) == pytest.approx(value, rel=1e-7)


def test_frames_that_err_alike_count_as_one_and_those_that_keep_a_part_as_their_correlation_says():
    """Of noise that keeps 0.7 from frame to frame: T / sum over the lags of 0.49^lag."""
    frames = np.ones(40, bool)
    alike = np.tile(_white(1), (40, 1))
    assert independent_frames(alike, frames, 8.0) == pytest.approx(1.0, abs=0.3)
    white = _white(400, 30)
    assert independent_frames(white, np.ones(400, bool), 30.0) > 300.0
    kept = white.copy()
    for t in range(1, 400):
        kept[t] = 0.7 * kept[t - 1] + np.sqrt(0.51) * white[t]
    assert independent_frames(kept, np.ones(400, bool), 30.0) == pytest.approx(400 * 0.51 / 1.49, rel=0.2)
