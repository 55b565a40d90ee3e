"""A mark that jumps, turns or comes back is found again, and never at another place."""

from __future__ import annotations

import numpy as np
import pytest

from measure.correlation.steepest_descent import TRANSLATION
from measure.correlation.tracking import track_marks
from measure.footage.footage import from_array


@pytest.mark.parametrize("degrees", [17.0, 30.0, -25.0])
def test_a_mark_that_turns_at_once_is_found(speckled, degrees):
    angle = np.radians(degrees)
    film = np.array([speckled(seed=3, size=141, noise_seed=n, turn=angle if n > 2 else 0.0) for n in range(6)])
    marks = track_marks(from_array(film), [(85.0, 60.0)], 250.0)
    arm = np.array([85.0, 60.0]) - 70.0
    c, s = np.cos(angle), np.sin(angle)
    assert marks.observed.all()
    assert np.abs(marks.x_px[3:, 0] - 70.0 - (c * arm[0] - s * arm[1])).max() < 0.05
    assert np.abs(marks.y_px[3:, 0] - 70.0 - (s * arm[0] + c * arm[1])).max() < 0.05


def test_a_mark_that_moves_by_a_third_of_the_picture_in_a_frame_is_found(speckled):
    shifts = [(0.0, 0.0)] * 3 + [(47.0, -20.0), (0.0, 47.3)]
    film = np.array([speckled(shift, seed=3, size=141, noise_seed=n) for n, shift in enumerate(shifts)])
    marks = track_marks(from_array(film), [(55.0, 60.0)], 250.0)
    assert marks.observed.all()
    assert np.abs(np.column_stack([marks.x_px[:, 0] - 55.0, marks.y_px[:, 0] - 60.0]) - shifts).max() < 0.05


def test_a_mark_that_jumps_and_turns_is_found_over_the_whole_picture(speckled):
    angle = np.radians(24.0)
    film = np.array(
        [speckled((30.0, 18.0) if n > 2 else (0, 0), seed=3, size=201, noise_seed=n, turn=angle if n > 2 else 0.0) for n in range(5)]
    )
    marks = track_marks(from_array(film), [(80.0, 90.0)], 250.0)
    c, s = np.cos(angle), np.sin(angle)
    x, y = 100.0 + (c * -20.0 - s * -10.0) + 30.0, 100.0 + (s * -20.0 + c * -10.0) + 18.0
    assert marks.observed.all()
    assert np.hypot(marks.x_px[-1, 0] - x, marks.y_px[-1, 0] - y) < 0.05


def _dots(shift, covered, noise_seed):
    y, x = np.mgrid[:160, :300].astype(float)
    grey = np.full(x.shape, 180.0)
    for cx, cy in ((60, 100), (120, 100), (60, 50), (120, 50)):
        grey -= 140.0 / (1.0 + np.exp((np.hypot(x - cx - shift, y - cy) - 8.0) / 0.5))
    if covered:
        grey[80:120, int(40 + shift) : int(80 + shift)] = 90.0
    noise = np.random.default_rng(noise_seed).normal(0.0, 1.5, grey.shape)
    return np.rint(grey + noise).clip(0, 255).astype(np.uint8)


def test_one_of_four_equal_dots_that_comes_back_is_found_where_the_others_say():
    """Covered for 20 frames in which the body accelerates: its own path says nothing, and the other dots look the same."""
    shift = np.concatenate([np.zeros(4), 0.12 * np.arange(36) ** 2])
    film = np.array([_dots(s, 12 <= n < 32, n) for n, s in enumerate(shift)])
    places = [(60.0, 100.0), (120.0, 100.0), (60.0, 50.0), (120.0, 50.0)]
    marks = track_marks(from_array(film), places, 250.0, subset=25)
    assert not marks.observed[13:31, 0].any()
    assert marks.observed[33:, 0].all()
    assert marks.observed[:, 1:].all()
    off = np.hypot(marks.x_px - np.array(places)[:, 0] - shift[:, None], marks.y_px - np.array(places)[:, 1])
    assert np.nanmax(off) < 0.1
    assert "out-of-frame" not in set(marks.status[:, 0])


def _on_drum(turn, rise):
    """Places (6, 2) of six dots on a drum that turns and rises, px, and how narrow each has become, (6,)."""
    azimuth = np.tile([-0.5, 0.0, 0.5], 2)
    places = np.column_stack([100.0 + 90.0 * np.sin(azimuth + turn), np.repeat([250.0, 200.0], 3) - rise])
    return places, np.cos(azimuth + turn) / np.cos(azimuth)


def _drum(turn, rise, noise_seed, width):
    y, x = np.mgrid[:300, :width].astype(float)
    grey = np.full(x.shape, 180.0)
    for (cx, cy), narrow in zip(*_on_drum(turn, rise), strict=True):
        grey -= 70.0 * (1.0 - np.tanh(np.hypot((x - cx) / narrow, y - cy) - 8.0))
    noise = np.random.default_rng(noise_seed).normal(0.0, 1.5, grey.shape)
    return np.rint(grey + noise).clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize(("width", "back"), [(180, 0.24), (176, 0.2), (170, 0.1)])
def test_a_mark_that_comes_back_from_the_edge_of_the_picture_is_found_though_it_looks_another(width, back):
    """On a drum that has turned meanwhile a dot is narrower than it was last seen, and not quite where a flat body would have it."""
    turns = np.concatenate([np.zeros(4), np.linspace(0.0, 0.62, 26), np.full(14, 0.62), np.linspace(0.62, back, 16), np.full(8, back)])
    rises = np.concatenate([np.zeros(4), 2.2 * np.arange(len(turns) - 4.0)])
    film = np.array([_drum(turn, rise, n, width) for n, (turn, rise) in enumerate(zip(turns, rises, strict=True))])
    marks = track_marks(from_array(film), _on_drum(0.0, 0.0)[0].tolist(), 250.0, subset=25)
    right = [2, 5]
    assert (~marks.observed[30:44][:, right]).any(axis=0).all()
    assert marks.observed[-6:].all()
    off = np.stack([marks.x_px, marks.y_px], axis=-1) - [_on_drum(turn, rise)[0] for turn, rise in zip(turns, rises, strict=True)]
    assert np.nanmax(np.abs(off)) < 0.3


def test_a_mark_that_may_only_shift_is_not_taken_for_a_turned_one(speckled):
    film = np.array([speckled(seed=3, size=141, noise_seed=n, turn=0.5 if n > 2 else 0.0) for n in range(5)])
    marks = track_marks(from_array(film), [(70.0, 70.0)], 250.0, warp=TRANSLATION)
    assert not marks.observed[3:].any()
