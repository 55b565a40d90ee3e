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
    words = f"First picture of {film.name}, {footage.width} x {footage.height} px, with the {len(places_px)} marks that are followed."
    return FilmFrame(_jpeg(picture), footage.width, footage.height, places_px, subset_px / 2, words)


def _jpeg(picture: Picture) -> str:
    import cv2

    bright = max(float(np.percentile(picture, _BRIGHTEST)), 1.0)
    grey = np.clip(picture * (255.0 / bright), 0, 255).astype(np.uint8)
    if grey.shape[0] > _MOST_HEIGHT:
        grey = cv2.resize(grey, None, fx=_MOST_HEIGHT / grey.shape[0], fy=_MOST_HEIGHT / grey.shape[0], interpolation=cv2.INTER_AREA)
    done, data = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    assert done
    return "data:image/jpeg;base64," + base64.b64encode(data.tobytes()).decode()
