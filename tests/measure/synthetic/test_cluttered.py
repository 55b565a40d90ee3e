"""Made films of a thing before clutter: what they show is what they say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import binary_dilation, binary_erosion

from measure.synthetic.cluttered import cluttered_pictures, cluttered_scene


@pytest.fixture(scope="module", params=[1, 2, 5, 6])
def scene(request):
    return replace(cluttered_scene(request.param, 150, 170, 12), noise=0.0, light=1.0)


def film(scene, seed=1):
    return np.array(list(cluttered_pictures(scene, seed)), float)


def wider(where):
    return np.asarray(binary_dilation(where, iterations=3), bool)


def coarse(fine):
    """Means over the pixels, of which each has four times four finer ones."""
    return fine.reshape(fine.shape[0] // 4, 4, -1, 4).mean(axis=(1, 3))


def smooth_there(picture, apart=6.0):
    """Where a blur of half a pixel changes little."""
    return np.maximum.reduce([np.abs(np.roll(picture, step, axis) - picture) for step in (-1, 1) for axis in (0, 1)]) < apart


def test_the_thing_hides_the_background_and_nothing_else(scene):
    first, around = film(scene)[0], wider(scene.silhouette)
    beside, inside = coarse(scene.background), coarse(scene.thing)
    outer, inner = ~around & smooth_there(beside), binary_erosion(scene.silhouette, iterations=3) & smooth_there(inside)
    assert outer.sum() > 3000
    assert inner.sum() > 100
    assert np.abs(first - beside.clip(0, 255))[outer].max() < 4.0
    assert np.abs(first - inside.clip(0, 255))[inner].max() < 4.0


def test_a_shift_moves_the_thing_and_leaves_the_background(scene):
    still, moved = film(replace(scene, shift_px=np.array([[0.0, 0.0], [7.0, -5.0]])))
    there = np.roll(scene.silhouette, (-5, 7), (0, 1))
    inner = binary_erosion(there, iterations=3)
    assert np.array_equal(moved[inner], np.roll(still, (-5, 7), (0, 1))[inner])
    outer = ~wider(scene.silhouette | there)
    assert np.array_equal(moved[outer], still[outer])


def test_a_quarter_of_a_pixel_is_one_of_the_finer_ones(scene):
    moved = film(replace(scene, shift_px=np.array([[0.25, -0.5]])))[0]
    by_hand = replace(
        scene, shift_px=np.zeros((1, 2)), thing=np.roll(scene.thing, (-2, 1), (0, 1)), belongs=np.roll(scene.belongs, (-2, 1), (0, 1))
    )
    inner = slice(5, -5), slice(5, -5)
    assert np.abs(moved - film(by_hand)[0])[inner].max() <= 1.0


def test_noise_and_light_are_those_stated(scene):
    blank = replace(scene, background=np.full_like(scene.background, 120.0), belongs=np.zeros_like(scene.belongs), noise=2.5, light=0.8)
    frames = film(blank)
    assert frames[0].std() == pytest.approx(2.5, rel=0.05)
    assert frames[-1].mean() == pytest.approx(96.0, abs=0.2)
    assert frames[5].mean() == pytest.approx(120.0 * 0.8 ** (5 / 11), abs=0.2)
    assert not np.array_equal(film(blank, seed=2)[0], frames[0])


def test_the_thing_rests_near_one_border_and_goes_to_the_other(scene):
    rows = np.flatnonzero(scene.silhouette.any(axis=1))
    middle = 0.5 * (rows[0] + rows[-1])
    assert min(middle, 169.0 - middle) == pytest.approx(44.5, abs=0.6)
    assert middle + scene.shift_px[-1, 1] == pytest.approx(169.0 - middle, abs=1.1)
    assert np.all(scene.shift_px[:2] == 0.0)
    assert np.abs(scene.shift_px[-1, 0]) <= 15.0
    assert np.all(np.diff(scene.shift_px[1:, 1]) * np.sign(scene.shift_px[-1, 1]) > 0.0)
    columns = np.flatnonzero(scene.silhouette.any(axis=0))
    assert 20 <= rows[-1] - rows[0] <= 66
    assert 40 <= columns[-1] - columns[0] <= 92
    assert 14.0 < scene.thing.std() < 62.0
    height, width = rows[-1] - rows[0], columns[-1] - columns[0]
    filled, wide = scene.silhouette.sum() / (height * width), width / height
    assert min(abs(filled - full) + 0.5 * abs(wide - shape) for full, shape in ((0.785, 1.0), (1.0, 1.0), (1.0, 7 / 3))) < 0.1


def test_a_seed_gives_the_same_scene_and_another_one_another():
    one, same, other = (cluttered_scene(seed, 120, 130, 5) for seed in (3, 3, 4))
    assert np.array_equal(one.background, same.background)
    assert not np.array_equal(one.background, other.background)
