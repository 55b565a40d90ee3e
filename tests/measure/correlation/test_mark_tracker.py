"""One mark on its way through made pictures: where it is looked for, what becomes of it, and why it is not found."""

from __future__ import annotations

import numpy as np
import pytest

from measure.correlation.mark_tracker import cut
from measure.correlation.tracking import mark_tracker

SIZE = 140


def picture_of(speckled, shift=(0.0, 0.0), noise_seed=0):
    return speckled(shift, seed=3, size=SIZE, noise_seed=noise_seed)


@pytest.fixture
def tracker(speckled):
    return mark_tracker(picture_of(speckled), 70.3, 69.8, 25)


@pytest.fixture
def known(speckled, tracker):
    """One that has been observed at rest in four frames."""
    for n in range(4):
        assert tracker.observe(picture_of(speckled, noise_seed=n), n).status == "ok"
    return tracker


BLANK = np.full((SIZE, SIZE), 90, np.uint8)


def placed(tracker, frames, path):
    for frame in frames:
        tracker.places = [*tracker.places[-2:], (frame, np.array(path(frame), float))]
        tracker.warp[[2, 5]] = path(frame)
    return tracker


def even(n):
    return 70.0 + 3.0 * n, 70.0 - 1.5 * n


def faster(n):
    return 70.0 + 3.0 * n + 0.5 * n * n, 70.0 - n * n


def test_three_frames_in_a_row_are_continued_as_a_parabola_and_two_as_a_line(tracker):
    assert placed(tracker, [0], even).predicted(1)[[2, 5]] == pytest.approx(even(0))
    assert placed(tracker, [0, 1], even).predicted(2)[[2, 5]] == pytest.approx(even(2))
    assert placed(tracker, [2, 3, 4], faster).predicted(5)[[2, 5]] == pytest.approx(faster(5))
    assert placed(tracker, [1, 3, 5], even).predicted(6)[[2, 5]] == pytest.approx(even(6))


def test_while_it_is_hidden_a_mark_goes_on_evenly_for_ten_frames_and_no_farther(tracker):
    placed(tracker, [2, 3, 4], faster)
    step = np.subtract(faster(4), faster(3))
    assert tracker.predicted(6)[[2, 5]] == pytest.approx(faster(4) + 2 * step)
    assert tracker.predicted(14)[[2, 5]] == pytest.approx(faster(4) + 10 * step)
    assert tracker.predicted(40)[[2, 5]] == pytest.approx(faster(4) + 10 * step)


def test_a_prediction_leaves_rotation_and_stretch(tracker):
    tracker.warp[[0, 1, 3, 4]] = 0.9, 0.1, -0.1, 1.1
    placed(tracker, [0, 1], even)
    assert tracker.predicted(2)[[0, 1, 3, 4]] == pytest.approx([0.9, 0.1, -0.1, 1.1])


def test_a_mark_is_observed_where_it_is_and_its_frames_are_kept(speckled, tracker):
    for n, shift in enumerate([(0.0, 0.0), (1.2, 0.5), (2.9, 0.4), (5.0, -0.3)]):
        seen = tracker.observe(picture_of(speckled, shift, n), n)
        assert seen.status == "ok"
        assert [seen.x_px, seen.y_px] == pytest.approx([70.3 + shift[0], 69.8 + shift[1]], abs=0.05)
        assert seen.hidden == 0.0
        assert seen.zncc > 0.97
    assert [frame for frame, _ in tracker.places] == [1, 2, 3]
    assert tracker.missed == 0


def test_frames_without_it_are_counted_until_it_is_back(speckled, known):
    assert [known.observe(BLANK, n).status for n in (4, 5, 6)] == ["lost"] * 3
    assert known.missed == 3
    assert known.missed_again().status == "lost"
    assert known.missed == 4
    assert np.isnan(known.missed_again().x_px)
    assert known.observe(picture_of(speckled, (4.0, 2.0), 5), 9).status == "ok"
    assert known.missed == 0


@pytest.mark.parametrize(("way", "frames"), [((-9.0, 0.0), 9), ((9.0, 0.0), 9), ((0.0, -9.0), 9), ((0.0, 9.0), 9)])
def test_a_mark_that_leaves_over_any_border_is_out_of_frame(speckled, tracker, way, frames):
    seen = [tracker.observe(picture_of(speckled, (n * way[0], n * way[1]), n), n).status for n in range(frames)]
    assert seen[:6] == ["ok"] * 6
    assert seen[-1] == "out-of-frame"
    assert set(seen) == {"ok", "out-of-frame"}


def test_a_mark_that_is_out_of_frame_stays_so_until_it_is_found(speckled, tracker):
    for n in range(9):
        tracker.observe(picture_of(speckled, (-9.0 * n, 0.0), n), n)
    assert tracker.observe(BLANK, 9).status == "out-of-frame"
    back = [tracker.observe(picture_of(speckled, (-40.0, 0.0), n), n) for n in range(10, 17)]
    assert {one.status for one in back} == {"out-of-frame", "ok"}
    assert back[-1].x_px == pytest.approx(30.3, abs=0.05)


def test_a_mark_behind_something_with_a_texture_is_occluded(speckled, tracker):
    tracker.observe(picture_of(speckled), 0)
    covered = picture_of(speckled, noise_seed=1)
    covered[:, 70:] = speckled(seed=9, size=SIZE)[:, 70:]
    seen = tracker.observe(covered, 1)
    assert seen.status == "occluded"
    assert np.isnan([seen.x_px, seen.y_px]).all()


def test_a_lost_mark_is_found_where_it_is_looked_for_and_not_elsewhere(speckled, known):
    there = picture_of(speckled, (20.0, -15.0), 9)
    known.observe(BLANK, 4)
    assert known.look_at(BLANK, 4, np.array([90.0, 55.0])) is None
    assert known.look_at(there, 4, np.array([30.0, 110.0])) is None
    found = known.look_at(there, 4, np.array([93.0, 52.0]))
    assert found is not None
    assert [found.x_px, found.y_px] == pytest.approx([90.3, 54.8], abs=0.05)
    assert known.missed == 0


def test_the_subset_that_is_cut_out_is_the_nearest_whole_one_and_none_over_the_border():
    picture = np.arange(30 * 40, dtype=np.uint16).reshape(30, 40)
    warp = np.array([1.0, 0.0, 11.4, 0.0, 1.0, 16.7])
    found = cut(picture, warp, 4)
    assert found is not None
    assert np.array_equal(found, picture[13:22, 7:16])
    for x, y, fits in ((4, 4, True), (3, 9, False), (9, 3, False), (35, 25, True), (36, 9, False), (9, 26, False)):
        assert (cut(picture, np.array([1.0, 0.0, x, 0.0, 1.0, y]), 4) is not None) == fits


def quadrants(narrow, noise_seed):
    """Four squares whose grey levels cross, a sheet that turns away: ever narrower about its middle, before a darker ground."""
    y, x = np.mgrid[:120, :120] - 60.2
    sheet = 110.0 + 60.0 * np.tanh(x / narrow / 0.8) * np.tanh(y / 0.8)
    grey = np.where(np.abs(x) < 17.0 * narrow, sheet, 15.0) + np.random.default_rng(noise_seed).normal(0.0, 1.0, x.shape)
    return np.rint(grey).clip(0, 255).astype(np.uint8)


def test_quadrants_that_get_narrower_are_followed_as_such():
    """Nothing in their texture says so but the ground that enters beside them."""
    tracker = mark_tracker(quadrants(1.0, 0), 60.2, 60.2, 31)
    assert len(tracker.mark.loose) == 2
    for n in range(14):
        seen = tracker.observe(quadrants(1.0 - 0.03 * n, n), n)
        assert seen.status == "ok"
        assert [seen.x_px, seen.y_px] == pytest.approx([60.2, 60.2], abs=0.05)
    assert tracker.warp[0] == pytest.approx(0.61, abs=0.13)
    assert tracker.warp[4] == pytest.approx(1.0, abs=0.02)
