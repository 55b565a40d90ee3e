"""The picture of a film on a page: around its marks, with the marks where they are."""

import base64
from pathlib import Path

import cv2
import numpy as np

from measure import open_footage, read_project
from measure.pages.film_frame import _around, film_frame

DEMO = Path(__file__).resolve().parents[3] / "datasets" / "demo"


def test_a_mark_stands_on_the_page_where_it_stands_in_the_film():
    marks = read_project(DEMO / "film.toml").marks
    places = [(float(x), float(y)) for x, y in marks.place_px]
    frame = film_frame(DEMO / "film.avi", places, marks.subset_px)
    kind, _, data = frame.address.partition(",")
    assert kind == "data:image/jpeg;base64"
    shown = cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_GRAYSCALE)
    assert shown is not None
    assert shown.shape == (frame.height, frame.width)
    whole = next(iter(open_footage(DEMO / "film.avi").pictures()))[1].astype(float)
    for (x, y), (u, v) in zip(places, frame.marks, strict=True):
        assert 0 < u < frame.width
        assert 0 < v < frame.height
        film = whole[int(y) - 8 : int(y) + 9, int(x) - 8 : int(x) + 9].ravel()
        page = shown[int(v) - 8 : int(v) + 9, int(u) - 8 : int(u) + 9].astype(float).ravel()
        assert np.corrcoef(film, page)[0, 1] > 0.95


def test_a_page_says_what_it_shows_of_the_film_and_how_large_a_subset_is():
    film = open_footage(DEMO / "film.avi")
    frame = film_frame(DEMO / "film.avi", [(60.0, 70.0), (80.0, 70.0)], 21)
    assert frame.half == 10.5
    assert frame.words == f"First picture of film.avi around its 2 marks; the whole is {film.width} x {film.height} px."
    assert frame.marks == [(60.0, 70.0), (80.0, 70.0)]
    assert (frame.width, frame.height) == (164, 154)


def test_around_marks_at_a_corner_the_picture_ends_where_the_film_does():
    assert _around([(3.0, 4.0), (20.0, 9.0)], 11, 100, 80) == (0, 0, 64, 53)
    assert _around([(90.0, 70.0)], 11, 100, 80) == (46, 26, 100, 80)
    assert _around([], 11, 100, 80) == (0, 0, 100, 80)
