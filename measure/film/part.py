"""What of a film is used: all of it or a part of its time, frames or fields, as the project says."""

from __future__ import annotations

import numpy as np

from measure.common.errors import InputError
from measure.footage.derived import Fields, Part, fields, part
from measure.footage.footage import Footage
from measure.geometry.film_project import Project

_OF_FIELDS = float(np.sqrt(2.0 / (0.5 * (1.0 + (9.0**2 + 9.0**2 + 1.0 + 1.0) / 16.0**2))))
"""Half of the rows of a field are interpolated from the others: they add no information, and their noise is the smaller."""


def sigma_factor(footage: Footage) -> float:
    """By how much the standard deviations of marks are larger than all rows of the pictures, taken to be independent, would give."""
    return _OF_FIELDS if footage.per_frame > 1 else 1.0


def capture_rate(footage: Footage, project: Project) -> float:
    """The rate of the project, or the one that the camera reports, frames per second.

    Raises
    ------
    InputError
        Neither is there.
    """
    fps = project.film.fps or footage.fps
    if fps is None:
        raise InputError(
            f"{footage.name}: carries no capture rate of the camera (the rate in a container is that of playing). "
            "Give --fps with the rate that the camera was set to."
        )
    return fps


def part_of(footage: Footage, project: Project) -> Footage:
    """The pictures of a film that a project asks for: its fields where it says so, between the instants that it gives.

    Parameters
    ----------
    footage : Footage
        A film; what has gone through here already is handed back as it is.
    project : Project

    Returns
    -------
    Footage

    Raises
    ------
    InputError
        Instants outside of the film, or no capture rate to find them by; fields of a film that is not interlaced.
    """
    if isinstance(footage, Part | Fields):
        return footage
    film = project.film
    pictures = fields(footage) if film.fields else footage
    if film.from_s is None and film.to_s is None:
        return pictures
    return part(pictures, capture_rate(footage, project), film.from_s, film.to_s)
