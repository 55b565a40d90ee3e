"""Where a film moves and where marks can be put, on pictures of which every pixel is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from measure.film.moving_places import Motion, find_motion, places_that_move, places_with_texture
from measure.footage.footage import from_array

ROWS, COLUMNS = 120, 160


def texture(seed, low=60, high=200):
    coarse = np.random.default_rng(seed).integers(low, high, (ROWS // 4, COLUMNS // 4)).astype(float)
    rough = np.kron(coarse, np.ones((4, 4)))
    return (rough + np.roll(rough, 1, 0) + np.roll(rough, 1, 1) + np.roll(rough, (1, 1), (0, 1))) / 4.0


def film_of(frames, begins=0, side=60, step=2):
    """A textured square that stands at first, then moves to the right by `step` px a frame, before a background at rest."""
    behind, own, noise = texture(1), texture(2), np.random.default_rng(3)
    made = []
    for n in range(frames):
        x = 20 + step * max(n - begins, 0)
        picture = behind.copy()
        picture[30 : 30 + side, x : x + side] = own[:side, :side]
        made.append(np.rint(picture + noise.normal(0.0, 1.0, picture.shape)).clip(0, 255).astype(np.uint8))
    return from_array(np.array(made))


def test_the_body_differs_from_the_first_frame_in_nearly_all_frames_and_the_background_in_those_in_which_it_is_covered():
    share = find_motion(film_of(13)).share
    assert np.mean(share[34:86, 24:36] > 0.9) > 0.95
    assert share[:24].max() == share[96:].max() == 0.0
    assert share[:, 112:].max() == 0.0
    covered = np.array([np.quantile(share[34:86, 80 + gone : 83 + gone], 0.3) for gone in (2, 8, 14, 20)])
    assert np.all(np.diff(covered) < 0.0)
    assert covered[0] > 0.7 > 0.35 > covered[3]


def test_frames_before_the_motion_do_not_count():
    assert np.mean(find_motion(film_of(13, begins=6)).share[34:86, 24:34] > 0.9) > 0.9


def test_a_long_film_is_compared_at_two_dozen_frames_up_to_its_last():
    film = film_of(60, begins=57, step=6)
    share = find_motion(film).share
    assert share.max() == 1.0
    assert set(np.unique(share)) <= {0.0, 0.5, 1.0}


@pytest.mark.parametrize(("px", "is_motion"), [(0.2, False), (1.0, True)])
def test_what_shakes_by_a_fifth_of_a_pixel_does_not_move(px, is_motion):
    x = np.arange(COLUMNS)
    still = 128.0 + np.clip(np.minimum(x, x[::-1]) / 8.0 - 1.0, 0.0, 2.0) * (gaussian_filter(texture(1), 2.0) - 128.0)
    shaken = (1.0 - px) * still + px * np.roll(still, 1, axis=1)
    frames = np.rint([still, *[shaken] * 5]).clip(0, 255).astype(np.uint8)
    assert find_motion(from_array(frames)).anything == is_motion


def motion_of(square, first=None):
    """All of a square moves, and nothing else."""
    share = np.zeros((ROWS, COLUMNS), np.float32)
    share[square] = 1.0
    return Motion(np.rint(texture(1) if first is None else first).astype(np.uint8), share)


def test_places_lie_on_what_moves_apart_by_a_subset_and_within_the_border():
    motion = motion_of((slice(10, 110), slice(40, 160)))
    places, subset = places_that_move(motion, 15, 30, fixed=True)
    assert subset == 15
    assert len(places) > 8
    for k, (x, y) in enumerate(places):
        assert 15 <= x < COLUMNS - 15
        assert 15 <= y < ROWS - 15
        assert x > 38
        assert all(max(abs(x - other[0]), abs(y - other[1])) > 15 for other in places[:k])
    assert places_that_move(motion, 15, 3, fixed=True)[0] == places[:3]


def test_the_first_place_is_that_of_the_strongest_slopes_in_both_directions():
    """Flat but for stripes, which fix one direction only, and a patch of texture."""
    first = np.full((ROWS, COLUMNS), 100.0)
    first[:, 20:60] = 100.0 + 90.0 * ((np.arange(40) // 5) % 2)
    first[50:71, 100:121] = texture(4)[50:71, 100:121]
    (x, y), *others = places_that_move(motion_of((slice(None), slice(None)), first), 21, 9, fixed=True)[0]
    assert (abs(x - 110.0) <= 2.0, abs(y - 60.0) <= 2.0) == (True, True)
    assert all(abs(x - 110.0) < 45.0 for x, _ in others)
    assert places_with_texture(first.astype(np.uint8), 21, 1) == [(x, y)]


@pytest.mark.parametrize(("side", "subset"), [(90, 31), (50, 23), (36, 15)])
def test_a_small_body_gets_a_smaller_subset_unless_it_is_fixed(side, subset):
    motion = motion_of((slice(20, 20 + side), slice(30, 30 + side)))
    places, found = places_that_move(motion, 31, 12, fixed=False)
    assert found == subset
    assert len(places) >= 2
    assert places_that_move(motion, 31, 12, fixed=True)[1] == 31


def test_where_nothing_moves_there_are_no_places():
    assert places_that_move(motion_of((slice(0), slice(0))), 31, 12, fixed=False) == ([], 31)
