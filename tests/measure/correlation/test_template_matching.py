"""The search to a pixel against every place tried one by one."""

from __future__ import annotations

import numpy as np
import pytest

from measure.correlation.template_matching import correlation_map, is_unique, search, search_turned

SIZE, HALF = 9, 4


@pytest.fixture(scope="module")
def rough():
    return np.random.default_rng(11).integers(20, 230, (40, 46)).astype(np.uint8)


def scored(picture, patch, mask=None):
    """{(x, y): correlation} of a patch centred at every place where it fits."""
    part = slice(None) if mask is None else mask
    half = len(patch) // 2
    return {
        (x, y): np.corrcoef(picture[y - half : y + half + 1, x - half : x + half + 1][part].ravel(), patch[part].ravel())[0, 1]
        for y in range(half, picture.shape[0] - half)
        for x in range(half, picture.shape[1] - half)
    }


def around(x, y):
    return slice(y - HALF, y + HALF + 1), slice(x - HALF, x + HALF + 1)


@pytest.mark.parametrize("masked", [False, True])
def test_the_best_and_the_second_best_place_are_those_of_all_tried_one_by_one(rough, masked):
    mask = np.hypot(*(np.mgrid[:SIZE, :SIZE] - HALF)) < 4.2 if masked else None
    noisy = np.clip(rough[around(30, 22)] + np.random.default_rng(1).normal(0.0, 30.0, (SIZE, SIZE)), 0, 255).astype(np.uint8)
    every = scored(rough, noisy, mask)
    for x, y, radius in ((28, 20, 5), (4, 4, 3), (41, 35, 3), (0, 39, 9), (45, 0, 7), (20, 20, None)):
        near = {place: r for place, r in every.items() if radius is None or max(abs(place[0] - x), abs(place[1] - y)) <= radius}
        best = max(near, key=lambda place: near[place])
        away = [r for place, r in near.items() if max(abs(place[0] - best[0]), abs(place[1] - best[1])) > HALF]
        peak = search(rough, noisy, x, y, radius, mask)
        assert peak is not None
        assert (peak.x, peak.y) == best
        assert peak.zncc == pytest.approx(near[best], abs=1e-4)
        assert peak.second == pytest.approx(max(away, default=-1.0), abs=1e-4)


@pytest.mark.parametrize("place", [(4, 4), (41, 4), (4, 35), (41, 35)])
def test_a_patch_in_a_corner_is_found_there_from_just_within_the_radius(rough, place):
    patch = rough[around(*place)]
    for dx, dy in ((3, 0), (-3, 0), (0, 3), (0, -3)):
        peak = search(rough, patch, place[0] + dx, place[1] + dy, 3)
        assert peak is not None
        assert (peak.x, peak.y, round(peak.zncc, 4)) == (*place, 1.0)


@pytest.mark.parametrize("way", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_another_place_counts_from_just_beyond_half_a_patch(way):
    """A pattern that repeats every five pixels has its like there, one that repeats every four pixels only nearer."""
    for period, counts in ((5, True), (4, False)):
        picture = np.tile(np.random.default_rng(2).integers(0, 255, (period, period)).astype(np.uint8), (12, 12))
        peak = search(picture, picture[around(20, 20)], 20 + 3 * way[0], 20 + 3 * way[1], 3)
        assert peak is not None
        assert peak.zncc == pytest.approx(1.0, abs=1e-5)
        assert (peak.second > 0.999) == counts


def test_a_window_that_just_holds_the_patch_has_one_place_and_a_smaller_one_none(rough):
    patch = rough[around(4, 4)]
    peak = search(rough[:SIZE, :SIZE], patch, 4, 4, None)
    assert peak is not None
    assert (peak.x, peak.y, peak.second) == (4, 4, -1.0)
    assert search(rough[: SIZE - 1, :SIZE], patch, 4, 4, None) is None
    assert search(rough[:SIZE, : SIZE - 1], patch, 4, 4, None) is None
    assert search(rough, patch, -30, 20, 5) is None


def test_the_correlation_is_numpys_and_a_place_a_hundredth_as_rough_has_none(rough):
    picture = rough.copy()
    picture[:, 30:] = 120 + (picture[:, 30:] - 120.0) / 12.0
    patch = rough[around(12, 15)]
    scores = correlation_map(picture, patch)
    for (x, y), expected in scored(picture, patch).items():
        if x < 30 - HALF:
            assert scores[y - HALF, x - HALF] == pytest.approx(expected, abs=1e-4)
        elif x >= 30 + HALF:
            assert scores[y - HALF, x - HALF] == -1.0
    assert scores.shape == (40 - SIZE + 1, 46 - SIZE + 1)
    picture[:, 30:] = 120 + (rough[:, 30:] - 120.0) / 5.0
    assert correlation_map(picture, patch).min() > -1.0


@pytest.mark.parametrize("degrees", [-30, -10, 20])
@pytest.mark.parametrize(("radius", "masked"), [(6, False), (6, True), (None, False)])
def test_a_turned_patch_is_found_with_its_angle(speckled, degrees, radius, masked):
    """About the middle of the picture, to which the patch of a place beside it turns."""
    before, after = speckled(size=101, grain=2.5), speckled(size=101, grain=2.5, turn=np.radians(degrees), noise_seed=1)
    half, place = 13, np.array([66, 44])
    patch = before[place[1] - half : place[1] + half + 1, place[0] - half : place[0] + half + 1]
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    there = 50 + np.array([[c, -s], [s, c]]) @ (place - 50)
    mask = (np.mgrid[: 2 * half + 1, : 2 * half + 1][1] < 18) if masked else None
    if mask is not None:
        patch = np.where(mask, patch, np.random.default_rng(2).integers(0, 255, patch.shape)).astype(np.uint8)
    peak, angle = search_turned(after, patch, there[0] + 4, there[1] - 4, radius, mask)
    assert peak is not None
    assert np.degrees(angle) == pytest.approx(degrees)
    assert np.abs([peak.x, peak.y] - there).max() < 1.0
    assert peak.zncc > 0.9


def test_a_turned_patch_that_fits_nowhere_is_not_found(rough):
    assert search_turned(rough[:7, :7], rough[:17, :17], 3, 3, None) == (None, 0.0)
    assert search_turned(rough, rough[:9, :9], -40, 3, 5) == (None, 0.0)


@pytest.mark.parametrize("masked", [False, True])
def test_a_patch_is_unique_until_its_like_stands_elsewhere(speckled, masked):
    picture = speckled(grain=3.0)
    patch = picture[10:31, 10:31].copy()
    mask = np.hypot(*(np.mgrid[:21, :21] - 10)) < 9 if masked else None
    assert is_unique(picture, patch, 0.93, mask)
    assert not is_unique(picture, patch, 0.1, mask)
    picture[40:61, 44:65] = patch if mask is None else np.where(mask, patch, picture[40:61, 44:65])
    assert not is_unique(picture, patch, 0.93, mask)
