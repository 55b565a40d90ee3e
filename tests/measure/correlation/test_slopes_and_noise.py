"""Splines, steepest-descent images and noise on pictures whose values are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import convolve1d

from measure.common.errors import InputError
from measure.correlation.spline import BLUR, FILTER, NOISE_LEFT, REACH, coefficients, sample, sample_shifted
from measure.correlation.steepest_descent import (
    covariance_of_unit_noise,
    curvatures,
    descent_images,
    orthonormal_basis,
    orthonormal_in_order,
    project_off,
)
from measure.correlation.texture import determined, pixel_noise, require_texture

HALF = 6
SIZE = 2 * HALF + 1
X, Y = (axis.ravel().astype(float) for axis in np.meshgrid(np.arange(-HALF, HALF + 1), np.arange(-HALF, HALF + 1)))


def plane(rows=60, columns=70):
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    return (1000 + 7 * x - 13 * y).astype(np.uint16)


@pytest.mark.parametrize("place", [(30.0, 30.0), (30.25, 29.6), (31.9, 28.05)])
def test_a_plane_stays_a_plane_between_its_pixels_under_shift_and_warp(place):
    c, out = coefficients(plane(), 5, 4, 50, 50, FILTER), np.empty(SIZE * SIZE, np.float32)
    assert sample_shifted(c, 5.0, 4.0, HALF, place[0], place[1], out)
    assert out == pytest.approx(1000.0 + 7.0 * (place[0] + X) - 13.0 * (place[1] + Y), abs=0.02)
    warp = np.array([1.1, 0.2, place[0], -0.1, 0.9, place[1]])
    assert sample(c, 5.0, 4.0, HALF, warp, out)
    expected = 1000.0 + 7.0 * (1.1 * X + 0.2 * Y + place[0]) - 13.0 * (-0.1 * X + 0.9 * Y + place[1])
    assert out == pytest.approx(expected, abs=0.02)


def test_a_subset_must_lie_in_its_window_with_two_pixels_before_and_three_behind():
    c, out = coefficients(plane(), 0, 0, 30, 30, FILTER), np.empty(SIZE * SIZE, np.float32)
    for place, inside in ((8.0, True), (7.99, False), (20.99, True), (21.0, False)):
        assert sample_shifted(c, 0.0, 0.0, HALF, place, 15.0, out) == inside
        assert sample_shifted(c, 0.0, 0.0, HALF, 15.0, place, out) == inside
        for centre in ((place, 15.0), (15.0, place)):
            warp = np.array([1.0, 0.0, centre[0], 0.0, 1.0, centre[1]])
            assert sample(c, 0.0, 0.0, HALF, warp, out) or not inside


def test_beyond_its_border_a_picture_goes_on_as_its_edge_whatever_the_window():
    picture = np.random.default_rng(0).integers(0, 255, (40, 50)).astype(np.uint8)
    padded = np.pad(picture, 30, "edge")
    outside = coefficients(picture, -8, -5, 30, 20, FILTER)
    assert outside == pytest.approx(coefficients(padded, 22, 25, 30, 20, FILTER), abs=1e-3)
    far = coefficients(picture, 35, 30, 30, 20, FILTER)
    assert far == pytest.approx(coefficients(padded, 65, 60, 30, 20, FILTER), abs=1e-3)


def test_shift_and_warp_give_the_same_values_on_a_rough_picture():
    c = coefficients(np.random.default_rng(1).integers(0, 255, (60, 60)).astype(np.uint8), 0, 0, 60, 60, FILTER)
    one, other = np.empty(SIZE * SIZE, np.float32), np.empty(SIZE * SIZE, np.float32)
    assert sample_shifted(c, 0.0, 0.0, HALF, 30.3, 27.7, one)
    assert sample(c, 0.0, 0.0, HALF, np.array([1.0, 0.0, 30.3, 0.0, 1.0, 27.7]), other)
    assert one == pytest.approx(other, abs=0.02)


def test_the_blur_keeps_the_level_and_leaves_the_stated_noise():
    assert BLUR.sum() == pytest.approx(1.0)
    assert len(BLUR) == len(FILTER) == 2 * REACH + 1
    assert pytest.approx(BLUR[::-1]) == BLUR
    noise = np.random.default_rng(2).normal(127.0, 10.0, (200, 200)).astype(np.uint8)
    c, out, seen = coefficients(noise, 0, 0, 200, 200, FILTER), np.empty(SIZE * SIZE, np.float32), []
    for place in range(20, 180, 16):
        assert sample_shifted(c, 0.0, 0.0, HALF, float(place), float(place), out)
        seen.append(out.copy())
    assert np.var(seen) == pytest.approx(100.0 * NOISE_LEFT, rel=0.15)


def surface(x, y):
    return np.sin(0.21 * x + 0.1) + np.cos(0.17 * y) + 0.01 * x * y


def slopes():
    return 0.21 * np.cos(0.21 * X + 0.1) + 0.01 * Y, -0.17 * np.sin(0.17 * Y) + 0.01 * X


@pytest.mark.parametrize("warp", [2, 3, 6])
def test_descent_images_are_what_a_small_change_of_each_parameter_does(warp):
    step = 1e-6
    moves = {
        2: [(1, 0), (0, 1)],
        3: [(1, 0), (0, 1), (-Y, X)],
        6: [(1, 0), (0, 1), (X, 0), (Y, 0), (0, X), (0, Y)],
    }[warp]
    expected = [(surface(X + step * dx, Y + step * dy) - surface(X, Y)) / step for dx, dy in moves]
    assert descent_images(*slopes(), X, Y, warp) == pytest.approx(np.stack(expected), abs=1e-4)


def test_curvatures_are_second_derivatives_along_and_across():
    inner = (np.abs(X) < HALF) & (np.abs(Y) < HALF)
    fx, fy = X + 0.5 * Y, 3.0 * Y + 0.5 * X
    for found, expected in zip(curvatures(fx, fy), (1.0, 0.5, 3.0), strict=True):
        assert found[inner] == pytest.approx(np.full(inner.sum(), expected))


def test_orthonormal_images_span_the_same_and_what_is_projected_off_is_gone():
    images = np.random.default_rng(3).normal(size=(4, 50))
    images[3] = images[0] - 2.0 * images[1]
    basis = orthonormal_basis(images)
    assert basis @ basis.T == pytest.approx(np.eye(3), abs=1e-10)
    assert project_off(images, basis) == pytest.approx(np.zeros((4, 50)), abs=1e-9)
    ordered = orthonormal_in_order(list(images[:3]))
    assert ordered @ ordered.T == pytest.approx(np.eye(3), abs=1e-12)
    assert ordered[0] == pytest.approx(images[0] / np.linalg.norm(images[0]))
    assert abs(ordered[1] @ images[0]) < 1e-9


def test_the_covariance_of_blurred_noise_is_that_of_many_draws():
    rows, kept = np.stack(slopes()), np.arange(SIZE * SIZE)
    covariance, inverse = covariance_of_unit_noise(rows, SIZE, kept)
    assert inverse == pytest.approx(np.linalg.inv(rows @ rows.T))
    chance = np.random.default_rng(4)

    drawn = convolve1d(convolve1d(chance.normal(size=(1500, 40, 40)), BLUR, axis=1), BLUR, axis=2)[:, 14 : 14 + SIZE, 14 : 14 + SIZE]
    found = drawn.reshape(1500, -1) @ rows.T @ inverse
    assert np.sqrt(np.diag(covariance)) / np.std(found, axis=0) == pytest.approx(np.ones(2), rel=0.08)


def test_the_noise_of_a_picture_is_found_beside_any_smooth_surface():
    x, y = np.meshgrid(np.arange(80.0), np.arange(80.0))
    noise = np.random.default_rng(5).normal(0.0, 3.0, (80, 80))
    assert pixel_noise(5.0 * x - 3.0 * y + 0.2 * x * x + noise) == pytest.approx(3.3, rel=0.05)
    assert pixel_noise(x + y) == pytest.approx(0.3)


def hessian(of, warp):
    images = descent_images(of[0], of[1], X, Y, warp)
    return images @ images.T


def test_texture_fixes_all_of_a_warp_an_edge_pair_less_and_a_flat_one_only_shifts():
    chance = np.random.default_rng(6)
    rough = 20.0 * chance.normal(size=(2, X.size))
    assert determined(hessian(rough, 6), HALF, X.size, 1.0).shape == (6, 6)
    crossed = np.where(np.abs(X) < 1, 30.0, 0.0), np.where(np.abs(Y) < 1, 30.0, 0.0)
    kept = determined(hessian(crossed, 6), HALF, X.size, 1.0)
    assert kept.shape == (6, 4)
    assert np.abs(kept[[2, 5], 2:]).max() < 1e-9
    assert determined(hessian(rough, 3), HALF, X.size, 1e4).shape == (3, 2)


def test_a_direction_kept_moves_the_subset_by_one_pixel_in_the_mean():
    kept = determined(hessian(20.0 * np.random.default_rng(7).normal(size=(2, X.size)), 3), HALF, X.size, 1.0)
    turn = kept[2, 2]
    assert np.sqrt(np.mean((turn * X) ** 2 + (turn * Y) ** 2)) == pytest.approx(1.0)


@pytest.mark.parametrize(("size", "is_refused"), [(1.0, True), (40.0, False)])
def test_a_subset_needs_contrast_and_slopes_in_both_directions(size, is_refused):
    f, (fx, fy) = size * surface(X, Y), (size * slope for slope in slopes())
    if is_refused:
        with pytest.raises(InputError, match="too little texture"):
            require_texture(f, fx, fy, np.dtype(np.uint8), 0.0, 0.0)
    else:
        require_texture(f, fx, fy, np.dtype(np.uint8), 0.0, 0.0)
        with pytest.raises(InputError, match="too little texture"):
            require_texture(f, fx, 0.0 * fy, np.dtype(np.uint8), 0.0, 0.0)
