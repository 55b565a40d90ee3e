"""The arithmetic of the iterations against plain NumPy and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import convolve, map_coordinates

from measure.correlation.criteria import BLUR_PX
from measure.correlation.gauss_newton import compose, step_px
from measure.correlation.reference_image import blurred, reference
from measure.correlation.refinement import Match, refine, surface_near
from measure.correlation.spline import BLUR, FILTER, REACH, coefficients, sample, sample_shifted
from measure.correlation.steepest_descent import AFFINE, TRANSLATION

CENTRE, SUBSET = 36, 31
WARP = np.array([1.1, 0.2, 30.3, -0.1, 0.9, -7.7])


def moved(warp, points):
    return points @ warp.reshape(2, 3)[:, :2].T + warp[[2, 5]]


def as_warp(dp):
    """A small warp as a matrix and a shift, by the documentation of `compose`."""
    if len(dp) == 2:
        return np.array([1.0, 0.0, dp[0], 0.0, 1.0, dp[1]])
    if len(dp) == 3:
        return np.array([np.cos(dp[2]), -np.sin(dp[2]), dp[0], np.sin(dp[2]), np.cos(dp[2]), dp[1]])
    return np.array([1.0 + dp[2], dp[3], dp[0], dp[4], 1.0 + dp[5], dp[1]])


STEPS = [(0.3, -0.7), (0.3, -0.7, 0.2), (0.3, -0.7, 0.1, -0.2, 0.05, -0.15)]


@pytest.mark.parametrize("dp", STEPS)
def test_a_composed_warp_after_the_small_one_is_the_warp_itself(dp):
    points = np.random.default_rng(0).uniform(-20.0, 20.0, (30, 2))
    small = as_warp(np.array(dp))
    assert moved(compose(WARP, np.array(dp)), moved(small, points)) == pytest.approx(moved(WARP, points), abs=1e-12)


def test_a_step_is_the_largest_motion_that_one_of_its_parts_gives_a_pixel():
    assert step_px(np.array([0.3, -0.4]), 10) == pytest.approx(0.5)
    assert step_px(np.array([0.3, -0.4, -0.02]), 10) == pytest.approx(0.5)
    assert step_px(np.array([0.03, -0.04, -0.02]), 10) == pytest.approx(0.2)
    for k in range(2, 6):
        dp = np.zeros(6)
        dp[k] = -0.03
        assert step_px(dp, 15) == pytest.approx(0.45)


def test_between_the_pixels_stands_scipys_quintic_spline(speckled):
    picture = speckled()
    whole = convolve(picture.astype(float), np.outer(FILTER, FILTER).astype(float), mode="nearest")
    c, half = coefficients(picture, 4, 6, 60, 58, FILTER), 7
    y, x = (axis.ravel() for axis in np.mgrid[-half : half + 1, -half : half + 1])
    for warp in (WARP + np.array([0, 0, 4.4, 0, 0, 42.2]), np.array([1.0, 0.0, 33.25, 0.0, 1.0, 35.5])):
        out = np.empty(x.size, np.float32)
        assert sample(c, 4.0, 6.0, half, warp, out)
        there = moved(warp, np.column_stack([x, y]))
        expected = map_coordinates(whole, [there[:, 1], there[:, 0]], order=5, prefilter=False)
        assert out == pytest.approx(expected, abs=0.005)
    assert sample_shifted(c, 4.0, 6.0, half, 33.25, 35.5, out)
    assert out == pytest.approx(expected, abs=0.005)


@pytest.mark.parametrize("period_px", [3.0, 4.0, 6.0, 10.0, 25.0])
def test_through_the_spline_a_wave_keeps_what_a_gaussian_blur_leaves_of_it(period_px):
    w, n = 2.0 * np.pi / period_px, np.arange(-REACH, REACH + 1)
    spline = (66.0 + 52.0 * np.cos(w) + 2.0 * np.cos(2.0 * w)) / 120.0
    expected = np.exp(-0.5 * (w * BLUR_PX) ** 2)
    assert (FILTER * np.cos(w * n)).sum() * spline == pytest.approx(expected, abs=0.012)
    assert (BLUR * np.cos(w * n)).sum() == pytest.approx(expected, abs=0.003)


def subset_of(picture, at, half=SUBSET // 2):
    (rows, columns), (x, y) = picture.shape, at
    out = np.empty((2 * half + 1) ** 2, np.float32)
    assert sample_shifted(coefficients(picture, 0, 0, columns, rows, FILTER), 0.0, 0.0, half, x, y, out)
    return out.astype(float)


def refined(picture, mark, scale=None) -> Match:
    near = surface_near(picture, mark.half, mark.start)
    assert near is not None
    found = refine(near, mark, mark.start, scale)
    assert found is not None
    assert found.settled
    return found


@pytest.mark.parametrize("scale", [None, 0.5])
def test_gain_and_correlation_are_those_of_a_straight_line_through_the_grey_values(speckled, scale):
    """At the place that is found, one picture's grey values against the other's."""
    before, noise = speckled(noise=0.0), np.random.default_rng(3).normal(0.0, 4.0, (72, 72))
    after = np.rint(0.7 * speckled((0.3, -0.2), noise=0.0) + 12.0 + noise).clip(0, 255).astype(np.uint8)
    found = refined(after, reference(before, CENTRE, CENTRE, SUBSET, TRANSLATION), scale)
    f, g = subset_of(before, (CENTRE, CENTRE)), subset_of(after, (found.warp[2], found.warp[5]))
    slope, offset = np.polyfit(f, g, 1)
    residual = g - slope * f - offset
    tolerance = 1.0 if scale is None else 4.0
    assert found.gain == pytest.approx(slope, rel=0.005 * tolerance)
    assert found.zncc == pytest.approx(np.corrcoef(f, g)[0, 1], abs=1e-3 * tolerance)
    assert found.noise == pytest.approx(residual.std(), rel=0.03 * tolerance)


def test_the_covered_share_is_what_is_covered_and_the_standard_deviation_grows_for_it(speckled):
    mark = reference(speckled(), CENTRE, CENTRE, SUBSET)
    bare, after = speckled((0.2, 0.1), noise_seed=1), speckled((0.2, 0.1), noise_seed=1)
    after[:, 41:46] = 250
    whole, covered = refined(bare, mark, 1.0), refined(after, mark, 1.0)
    assert whole.hidden < 0.01
    assert covered.hidden == pytest.approx(6.0 / SUBSET, abs=1.2 / SUBSET)
    ratio = np.trace(covered.covariance) / covered.noise**2 * whole.noise**2 / np.trace(whole.covariance)
    assert 1.1 < ratio < 2.5


def test_the_slopes_of_a_prepared_mark_are_those_of_the_picture(speckled):
    picture = speckled(noise=0.0)
    mark = reference(picture, CENTRE, CENTRE, SUBSET, AFFINE)
    h = 0.05
    fx = (subset_of(picture, (CENTRE + h, CENTRE)) - subset_of(picture, (CENTRE - h, CENTRE))) / (2.0 * h)
    fy = (subset_of(picture, (CENTRE, CENTRE + h)) - subset_of(picture, (CENTRE, CENTRE - h))) / (2.0 * h)
    y, x = (axis.ravel() for axis in np.mgrid[-15:16, -15:16])
    assert mark.values == pytest.approx(subset_of(picture, (CENTRE, CENTRE)), abs=0.01)
    for found, expected in zip(mark.descent, (fx, fy, fx * x, fx * y, fy * x, fy * y), strict=True):
        assert found == pytest.approx(expected, abs=0.02 * np.abs(expected).max())


def test_a_blurred_mark_is_the_mean_over_its_way(speckled):
    picture = speckled(noise=0.0, size=101)
    mark = reference(picture, 50, 50, SUBSET)
    for motion, way in (((6.0, -3.0), (6.0, -3.0)), ((80.0, 60.0), (19.2, 14.4))):
        parts = [subset_of(picture, (50 + part * way[0], 50 + part * way[1])) for part in np.linspace(-0.5, 0.5, 161)]
        smeared = blurred(mark, np.array(motion))
        assert smeared.values == pytest.approx(np.mean(parts, axis=0), abs=1.5)
        assert smeared.basis is mark.basis
