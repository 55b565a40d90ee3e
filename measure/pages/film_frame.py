"""One picture of a film with its marks, for a page: the picture as an address that holds it, the marks as shapes over it."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measure.footage.footage import Picture
from measure.footage.formats import open_footage

_MOST_HEIGHT, _QUALITY = 900, 80
_BRIGHTEST = 99.9


@dataclass(frozen=True)
class FilmFrame:
    """A picture and its marks. address : of the picture, which it holds. marks : (n, 2) places x, y in px. half : half a subset, px."""

    address: str
    width: int
    height: int
    marks: list[tuple[float, float]]
    half: float
    words: str


def film_frame(film: Path, places_px: list[tuple[float, float]], subset_px: int) -> FilmFrame:
    """The first picture of a film with the marks in it.

    Parameters
    ----------
    places_px : reference points of the marks in that picture. subset_px : side of the square that is followed.

    Raises
    ------
    InputError
        The film cannot be read.
    """
    footage = open_footage(film)
    picture = next(iter(footage.pictures()))[1]
    words = f"First picture of {film.name} around its {len(places_px)} marks; the whole is {footage.width} x {footage.height} px."
    left, top, right, bottom = _around(places_px, subset_px, footage.width, footage.height)
    marks = [(x - left, y - top) for x, y in places_px]
    return FilmFrame(_jpeg(picture[top:bottom, left:right]), right - left, bottom - top, marks, subset_px / 2, words)


def _around(places_px: list[tuple[float, float]], subset_px: int, width: int, height: int) -> tuple[int, int, int, int]:
    """Left, top, right and bottom of what is shown: the marks with as much again to every side; the whole picture without marks."""
    if not places_px:
        return 0, 0, width, height
    (x0, y0), (x1, y1) = (np.array(places_px).min(axis=0), np.array(places_px).max(axis=0))
    room = max(x1 - x0, y1 - y0, 4.0 * subset_px)
    return max(int(x0 - room), 0), max(int(y0 - room), 0), min(int(x1 + room), width), min(int(y1 + room), height)


def _jpeg(picture: Picture) -> str:
    import cv2

    bright = max(float(np.percentile(picture, _BRIGHTEST)), 1.0)
    grey = np.clip(picture * (255.0 / bright), 0, 255).astype(np.uint8)
    if grey.shape[0] > _MOST_HEIGHT:
        grey = cv2.resize(grey, None, fx=_MOST_HEIGHT / grey.shape[0], fy=_MOST_HEIGHT / grey.shape[0], interpolation=cv2.INTER_AREA)
    done, data = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    assert done
    return "data:image/jpeg;base64," + base64.b64encode(data.tobytes()).decode()
