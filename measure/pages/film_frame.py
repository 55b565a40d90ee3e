"""One picture of a film with its marks, for a page: the picture as an address that holds it, the marks as shapes over it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measure.footage.formats import open_footage
from measure.pages.picture import brightest, embedded, reduced, shown

_LARGEST, _QUALITY = 1200, 80


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
    seen = picture[top:bottom, left:right]
    address = embedded(reduced(shown(seen, brightest(seen)), _LARGEST), _QUALITY)
    return FilmFrame(address, right - left, bottom - top, marks, subset_px / 2, words)


def _around(places_px: list[tuple[float, float]], subset_px: int, width: int, height: int) -> tuple[int, int, int, int]:
    """Left, top, right and bottom of what is shown: the marks with as much again to every side; the whole picture without marks."""
    if not places_px:
        return 0, 0, width, height
    (x0, y0), (x1, y1) = (np.array(places_px).min(axis=0), np.array(places_px).max(axis=0))
    room = max(x1 - x0, y1 - y0, 4.0 * subset_px)
    return max(int(x0 - room), 0), max(int(y0 - room), 0), min(int(x1 + room), width), min(int(y1 + room), height)
