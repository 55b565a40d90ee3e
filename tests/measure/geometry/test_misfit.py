"""How far standard deviations are widened for the misfit of the marks, against misfits that were drawn."""

from __future__ import annotations

from math import erf

import numpy as np
import pytest

from measure.geometry.misfit import independent_frames, widening
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
