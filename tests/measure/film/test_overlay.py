"""What is drawn into a film stands where it was measured."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from measure.film.overlay import drawn, overlaid, write_first_frame
from measure.film.status_colours import ENLARGED, STATUS_COLOURS
from measure.footage.footage import from_array

SUBSET = 21
X, Y = np.array([[30.0, 90.4], [32.0, np.nan]]), np.array([[60.0, 120.0], [58.0, np.nan]])


def bgr(colour):
    return [int(colour[k : k + 2], 16) for k in (5, 3, 1)]


def tracked_of(residual=(0.0, 0.0), has_fit=True) -> Any:
    """Two marks in two frames, the second one lost in the second frame; the first one's residual in px."""
    status = np.array([["ok", "ok"], ["ok", "lost"]])
    marks = SimpleNamespace(
        names=["m1", "m2"], x_px=X, y_px=Y, observed=status == "ok", status=status, time_s=np.array([0.5, 0.51]), first=50
    )
    residuals = np.zeros((2, 2, 2))
    residuals[:, 0] = residual
    fit = SimpleNamespace(used=marks.observed, residual_px=residuals) if has_fit else None
    return SimpleNamespace(marks=marks, fit=fit, project=SimpleNamespace(marks=SimpleNamespace(subset_px=SUBSET)))


FILM = np.full((2, 160, 130), 40, np.uint8)


def places(canvas, colour):
    rows, columns = np.nonzero((canvas == bgr(colour)).all(axis=2))
    return columns, rows


def test_a_box_goes_around_the_subset_of_each_mark_on_a_picture_three_times_as_large():
    canvas = drawn(FILM[0], tracked_of(has_fit=False), 0, 80.0)
    assert canvas.shape == (480, 390, 3)
    assert canvas[470, 380].tolist() == [127] * 3
    for x, y in zip(X[0], Y[0], strict=True):
        left, right = (round((x + side * SUBSET / 2 + 0.5) * 3 - 0.5) for side in (-1, 1))
        top, bottom = (round((y + side * SUBSET / 2 + 0.5) * 3 - 0.5) for side in (-1, 1))
        for row, column in ((top, left), (top, right), (bottom, left), (bottom, right), ((top + bottom) // 2, left)):
            assert canvas[row, column].tolist() == bgr(STATUS_COLOURS["ok"])
        assert canvas[bottom + 1, right].tolist() == [127] * 3
        assert canvas[bottom - 8, right - 8].tolist() == [127] * 3


def test_the_first_frame_is_written_pixel_for_pixel(tmp_path):
    written = cv2.imread(str(write_first_frame(from_array(FILM), tracked_of(has_fit=False), tmp_path / "first.png")))
    assert written is not None
    assert written.shape == (160, 130, 3)
    columns, rows = places(written, STATUS_COLOURS["ok"])
    assert (columns.min(), columns.max()) == (round(30 - 10.5), round(90.4 + 10.5))
    assert rows.max() == round(120 + 10.5)


def arrow(residual):
    """Columns and rows that an arrow changes, from the middle of its mark, below the captions."""
    with_arrow, without = (drawn(FILM[0], tracked_of(residual, has_fit), 0, 80.0)[80:] for has_fit in (True, False))
    rows, columns = np.nonzero((with_arrow != without).any(axis=2))
    return columns - (30.5 * 3 - 0.5), rows + 80 - (60.5 * 3 - 0.5)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_arrow_is_the_residual_enlarged(sign):
    along, beside = arrow((sign * 0.02, 0.0))
    assert (sign * along).max() == pytest.approx(3 * ENLARGED * 0.02, abs=3)
    assert (sign * along).min() == pytest.approx(0.0, abs=3)
    beside_it, upright = arrow((0.0, sign * 0.03))
    assert (sign * upright).max() == pytest.approx(3 * ENLARGED * 0.03, abs=3)
    assert (sign * upright).min() == pytest.approx(0.0, abs=3)
    assert max(np.abs(beside).max(), np.abs(beside_it).max()) < 15


def test_an_arrow_is_no_longer_than_two_subsets():
    assert arrow((50.0, 0.0))[0].max() == pytest.approx(3 * 2 * SUBSET, abs=4)
    assert arrow((-50.0, 0.0))[0].min() == pytest.approx(-90.0, abs=4)  # the border of the picture


def words_of(monkeypatch, tracked, frame):
    """What is written into a picture, by its colour, without the names at the marks."""
    said = []
    monkeypatch.setattr(cv2, "putText", lambda canvas, text, *rest: said.append((text, rest[3])))
    drawn(FILM[frame], tracked, frame, 80.0)
    return [one for one in said if one[0] not in ("m1", "m2")]


def test_frame_time_residual_and_what_is_not_seen_are_written(monkeypatch):
    found = words_of(monkeypatch, tracked_of((0.03, 0.04)), 1)
    assert [text for text, _ in found] == ["frame 51  0.5100 s", "residual 0.0354 px", f"arrows: residuals x {ENLARGED:g}", "m2 lost"]
    assert list(found[3][1]) == bgr(STATUS_COLOURS["lost"])
    assert [text for text, _ in words_of(monkeypatch, tracked_of(has_fit=False), 0)] == ["frame 50  0.5000 s"]


def test_the_film_is_as_long_as_what_was_measured_and_as_bright_as_its_first_picture_throughout():
    film = np.stack([FILM[0], FILM[0] // 2, FILM[0]])
    film[0, 100:, 100:] = 80
    shown = list(overlaid(from_array(film), tracked_of(has_fit=False)))
    assert len(shown) == 2
    assert shown[0][470, 380].tolist() == [255] * 3
    assert shown[1][470, 380].tolist() == [63] * 3
