"""The page on which marks, scale, plumb line, origin and time are chosen by eye, before a film is tracked."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from measure.correlation.texture import pixel_noise
from measure.film.moving_places import Motion, find_motion, places_that_move
from measure.film_pages.page import rendered
from measure.footage.footage import Footage, Picture
from measure.geometry.film_project import Project
from measure.pages.picture import brightest, embedded, reduced, shown

_STRIP = 24
_STRIP_PX = 160
_MOST_SUGGESTED = 8
_EVERY = 4
_QUALITY = 85
_MOVING_COLOUR = (14, 127, 255)
"""Of what moves, in the motion picture: blue, green, red."""


def choose_page(footage: Footage, project: Project, film: Path, page: Path) -> str:
    """The page for one film.

    Parameters
    ----------
    footage : Footage
        The film, or the part of it that is looked at.
    project : Project
        What is known already; the page begins with it and keeps what it cannot show.
    film, page : Path
        As they were typed, for the command lines that the page gives.

    Returns
    -------
    str
        HTML.
    """
    motion = find_motion(footage)
    frames = _looked_through(footage, motion.first)
    places, subset = places_that_move(motion, project.marks.subset_px, _MOST_SUGGESTED, "subset_px" in project.marks.model_fields_set)
    white = brightest(motion.first)
    data = {
        "film": {
            "name": film.name, "stem": film.stem or film.name, "word": shlex.quote(str(film)), "page": shlex.quote(str(page)),
            "width": footage.width, "height": footage.height, "first": footage.first, "fps": project.film.fps or footage.fps,
            "camera_fps": footage.fps, "steps": footage.times_s(frames["count"], 1.0),
        },
        "pictures": _pictures(frames, motion, white, footage.first),
        "strip": frames["strip"], "change": frames["change"],
        "noise": pixel_noise(motion.first), "assumed_noise": 1.5 if footage.bits == 8 else 1.0, "level": white / 255.0,
        "suggested": places, "suggested_subset": subset,
        "project": project.model_dump(by_alias=True, exclude_none=True, exclude_unset=True, mode="json"),
    }  # fmt: skip
    return rendered("choose.html.j2", ("view.js", "toml.js", "texture.js", "choose.js"), data, name=film.name, film=data["film"])


def _looked_through(footage: Footage, first: Picture) -> dict[str, Any]:
    """One way through the film: middle and last picture, a strip of small ones, and how much each differs from the first."""
    wanted = set(np.rint(np.linspace(0, max(footage.frames - 1, 1), _STRIP)).astype(int).tolist())
    before, white = first[::_EVERY, ::_EVERY].astype(np.float32), brightest(first)
    at, middle, last, change, strip = 0, first, first, [], []
    for number, picture in footage.pictures():
        change += [None] * (number - len(change))
        change.append(float(np.abs(picture[::_EVERY, ::_EVERY] - before).mean()))
        if number in wanted:
            strip.append({"frame": number, "src": embedded(reduced(shown(picture, white), _STRIP_PX), _QUALITY)})
        if number <= footage.frames // 2:
            middle, at = picture, number
        last = picture
    return {"count": len(change), "middle": (at, middle), "last": (len(change) - 1, last), "change": change, "strip": strip}


def _pictures(frames: dict[str, Any], motion: Motion, white: float, begin: int) -> list[dict[str, Any]]:
    """The pictures that can be looked at; marks are set on the first, which therefore loses nothing."""
    middle, last = frames["middle"], frames["last"]
    return [
        {"label": f"first (frame {begin})", "src": embedded(shown(motion.first, white))},
        {"label": f"middle (frame {begin + middle[0]})", "src": embedded(shown(middle[1], white), _QUALITY)},
        {"label": f"last (frame {begin + last[0]})", "src": embedded(shown(last[1], white), _QUALITY)},
        {"label": "what moves", "src": embedded(_motion_picture(motion, white), _QUALITY)},
    ]


def _motion_picture(motion: Motion, white: float) -> NDArray[np.uint8]:
    """The first picture, darker, and coloured where later ones differ from it, the more the longer they do."""
    grey = cv2.cvtColor(shown(motion.first, white), cv2.COLOR_GRAY2BGR).astype(np.float32)
    share = motion.share[..., None]
    return np.rint((1.0 - 0.6 * share) * (0.7 * grey) + 0.6 * share * np.array(_MOVING_COLOUR, np.float32)).astype(np.uint8)
