"""Marks through a film, and what becomes of them."""

from __future__ import annotations

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.correlation.marks import LOST, OK
from measure.correlation.steepest_descent import AFFINE, TRANSLATION
from measure.correlation.tracking import check_subset, track_marks, why_unusable
from measure.footage.footage import from_array
from measure.footage.formats import open_footage


def _film(speckled, shifts, size=140):
    return np.array([speckled(shift, seed=3, size=size, noise_seed=n) for n, shift in enumerate(shifts)])


@pytest.mark.parametrize("warp", [TRANSLATION, AFFINE])
@pytest.mark.parametrize("subset", [15, 29, 31])
def test_the_bar_moves_two_pixels_a_frame_until_it_is_hidden_and_then_it_is_said(subset, warp, real_footage):
    marks = track_marks(open_footage(real_footage / "obstruction" / "images"), [(64.0, 100.0)], 25.0, subset, warp)
    seen = marks.observed[:, 0]
    last = int(np.flatnonzero(seen)[-1])
    assert 12 <= last <= 18
    assert seen[: last + 1].all()
    assert np.abs(marks.x_px[: last + 1, 0] - 64.0 - 2.0 * np.arange(last + 1)).max() < 0.01
    assert np.isnan(marks.x_px[last + 1 :, 0]).all()
    assert set(marks.status[last + 1 :, 0]) <= {"occluded", "lost", "ambiguous"}


def test_the_mechanism_moves_as_another_program_says(real_footage):
    film = open_footage(real_footage / "mechanism" / "images")
    marks = track_marks(film, [(344.0, 212.0), (259.0, 405.0), (266.0, 41.0)], 25.0)
    assert marks.observed.all()
    for i in range(3):
        other = np.genfromtxt(real_footage / "mechanism" / "gold" / f"DICe_solution_{i}.txt", delimiter=",", skip_header=1)
        gap = np.stack([marks.x_px[:, i], marks.y_px[:, i]], axis=1) - other[:, 1:3] - other[:, 3:5]
        assert np.sqrt(np.mean(gap**2)) < 0.06


def test_fast_and_uneven_motion_is_followed_without_a_slip(speckled):
    x = np.concatenate([np.zeros(3), np.cumsum([12.0, 19.5, 17.3, 5.1, -3.7, -20.2, -14.4])])
    film = _film(speckled, [(s - 5, 0.37 * s) for s in x])
    marks = track_marks(from_array(film), [(65.0, 70.0)], 250.0, subset=31)
    error = np.hypot(marks.x_px[:, 0] - 65.0 - (x - x[0]), marks.y_px[:, 0] - 70.0 - 0.37 * (x - x[0]))
    assert (marks.status == OK).all()
    assert error.max() < 0.05


def test_a_platform_at_rest_lends_its_first_frames_to_the_reference(speckled):
    """Two pictures differ by the noise of both; against the mean of sixteen the difference has hardly more than one's."""
    errors = {}
    for rest in (1, 16):
        x = np.concatenate([np.zeros(rest), 0.37 * np.arange(1, 13)])
        film = _film(speckled, [(s, 0.0) for s in x])
        marks = track_marks(from_array(film), [(70.0, 70.0)], 250.0)
        assert marks.observed.all()
        errors[rest] = (np.std(marks.x_px[rest:, 0] - x[rest:]), np.median(marks.sigma_px[rest:]))
        assert abs(np.mean(marks.x_px[rest:, 0] - 70.0 - x[rest:])) < 0.02
    assert errors[16][1] < 0.85 * errors[1][1]


def test_slow_motion_from_the_first_frame_on_is_not_taken_for_rest(speckled):
    x = 0.02 * np.arange(20)
    marks = track_marks(from_array(_film(speckled, [(s, 0.0) for s in x])), [(70.0, 70.0)], 250.0)
    slope, offset = np.polyfit(x, marks.x_px[:, 0] - 70.0, 1)
    assert abs(slope - 1.0) < 0.03
    assert abs(offset) < 0.02


def test_a_covered_mark_has_no_position_and_comes_back(speckled):
    film = _film(speckled, [(0.5 * n, 0.0) for n in range(14)])
    film[5:9, 40:110, 40:110] = 128
    marks = track_marks(from_array(film), [(70.0, 70.0)], 250.0)
    assert not marks.observed[5:9].any()
    assert np.isnan(marks.x_px[5:9]).all()
    assert marks.observed[9:].all()
    assert np.abs(marks.x_px[9:, 0] - 70.0 - 0.5 * np.arange(9, 14)).max() < 0.05


def test_half_a_mark_behind_an_edge_is_not_taken_for_a_badly_lit_one(speckled):
    film = _film(speckled, [(0.3, 0.2)] * 16)
    for n, picture in enumerate(film):
        picture[:, 92 - 2 * n :] = 120
    marks = track_marks(from_array(film), [(70.0, 70.0)], 250.0, subset=41)
    assert not marks.observed[-1, 0]
    assert np.nanmax(np.abs(marks.x_px - 70.0)) < 0.05


def test_a_fast_mark_is_found_through_its_blur_when_the_exposure_is_known(speckled):
    """Shutter open half of the time, 12 px per frame: the picture is the mean over 6 px."""
    film = []
    for n in range(6):
        parts = [speckled((12.0 * n - 25.0 + part, 0.0), seed=3, size=140, noise=0.0).astype(float) for part in np.linspace(-2.9, 2.9, 30)]
        noise = np.random.default_rng(n).normal(0.0, 1.5, (140, 140))
        film.append(np.rint(np.mean(parts, axis=0) + noise).clip(0, 255).astype(np.uint8))
    film[0] = speckled((-25.0, 0.0), seed=3, size=140)
    marks = track_marks(from_array(np.array(film)), [(50.0, 70.0)], 250.0, subset=41, exposure_s=0.5 / 250.0)
    assert marks.observed.all()
    assert np.abs(marks.x_px[3:, 0] - 50.0 - 12.0 * np.arange(3, 6)).max() < 0.04


def test_a_mark_that_jumps_while_hidden_is_found_over_the_whole_picture(speckled):
    film = _film(speckled, [(0.0, 0.0)] * 4 + [(45.0, -30.0)] * 8)
    film[4:7, 50:90, 50:90] = 128
    film[4:6] = 128
    marks = track_marks(from_array(film), [(70.0, 70.0)], 250.0, subset=25)
    assert marks.observed[-1, 0]
    assert abs(marks.x_px[-1, 0] - 115.0) < 0.05


def test_a_mark_that_leaves_the_picture_is_out_of_frame(speckled):
    film = _film(speckled, [(-6.0 * n, 0.0) for n in range(14)])
    marks = track_marks(from_array(film), [(70.0, 70.0)], 250.0)
    assert marks.status[-1, 0] == "out-of-frame"
    error = np.abs(marks.x_px[:, 0] - 70.0 + 6.0 * np.arange(14))
    assert np.nanmax(error) < 0.05


def test_a_different_picture_is_not_the_mark(speckled):
    film = np.concatenate([_film(speckled, [(0, 0)] * 3), [speckled(seed=9, size=140)] * 3])
    marks = track_marks(from_array(film), [(70.0, 70.0)], 250.0)
    assert not marks.observed[3:].any()
    assert LOST in set(marks.status[3:, 0]) | {"occluded"}


def test_an_even_subset_has_no_centre(speckled):
    with pytest.raises(InputError, match="odd number"):
        track_marks(from_array(_film(speckled, [(0, 0)] * 2)), [(70.0, 70.0)], 250.0, subset=30)


def test_a_subset_has_from_9_to_301_pixels():
    check_subset(9)
    check_subset(301)
    for subset in (7, 10, 300, 303):
        with pytest.raises(InputError, match="from 9 to 301"):
            check_subset(subset)


def test_a_place_is_unusable_over_the_border_where_it_is_flat_and_under_a_mask(speckled):
    picture = speckled()
    picture[40:, 40:] = 90
    assert why_unusable(picture, (20.0, 20.0), 31) == ""
    assert why_unusable(picture, (15.4, 15.4), 31) == ""
    assert "border" in why_unusable(picture, (14.4, 20.0), 31)
    assert "texture" in why_unusable(picture, (56.0, 56.0), 31)
    assert "mask leaves 0 pixels" in why_unusable(picture, (20.0, 20.0), 31, np.zeros((72, 72), bool))


def test_a_frame_that_the_film_lacks_is_a_row_without_a_position(speckled):
    film = from_array(_film(speckled, [(0.2 * n, 0.0) for n in range(6)]))

    class Lacking(type(film)):
        def pictures(self):
            return (one for one in film.pictures() if one[0] not in (2, 3))

    marks = track_marks(Lacking(**film.__dict__), [(70.0, 70.0)], 100.0, names=["left"])
    assert marks.status[:, 0].tolist() == [OK, OK, "missing", "missing", OK, OK]
    assert marks.x_px[:, 0] == pytest.approx([70.0, 70.2, np.nan, np.nan, 70.8, 71.0], abs=0.03, nan_ok=True)
    assert marks.time_s == pytest.approx(np.arange(6) / 100.0)
    assert list(marks.names) == ["left"]


def test_one_frame_is_no_motion(speckled):
    with pytest.raises(InputError, match="two at least"):
        track_marks(from_array(_film(speckled, [(0, 0)])), [(70.0, 70.0)], 250.0)
