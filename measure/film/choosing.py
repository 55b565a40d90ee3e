"""The marks of a film, tracked: those that the project names, or those that are found where the film moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.marks import Marks
from measure.correlation.steepest_descent import WARP_NAMES
from measure.correlation.tracking import track_marks, why_unusable
from measure.film.moving_places import find_motion, places_that_move, places_with_texture
from measure.film.one_body import Body, LeftOut, one_body
from measure.footage.footage import Footage, Picture
from measure.geometry.film_project import Project

_MOST = 12
"""Marks that are looked for."""

Watch = Callable[[Iterator], Iterator]
Mask = NDArray[np.bool_]


def chosen_marks(footage: Footage, project: Project, fps: float, first: Picture, watch: Watch, mask: Mask | None) -> tuple[Body, int]:
    """Track the marks that the project names; one that cannot be tracked is left out.

    Parameters
    ----------
    footage : Footage
    project : Project
    fps : float
        Capture rate, frames per second.
    first : (height, width) array
        The first frame.
    watch : function
        Wraps the stream of frames.
    mask : (height, width) array of bool, optional
        Pixels of the first frame that belong to marks.

    Returns
    -------
    body : Body
    subset : int
        Side of the subset, px.

    Raises
    ------
    InputError
        None of the marks can be tracked.
    """
    subset, places = project.marks.subset_px, project.marks.place_px
    reasons = [why_unusable(first, place, subset, mask) for place in places]
    usable = [place for place, reason in zip(places, reasons, strict=True) if not reason]
    if not usable:
        raise InputError("\n".join(reasons))
    names = [f"m{i + 1}" for i, reason in enumerate(reasons) if not reason]
    marks = _tracked(footage, project, usable, fps, subset, watch, mask)
    left = tuple(LeftOut(*place, reason.partition(": ")[2]) for place, reason in zip(places, reasons, strict=True) if reason)
    return Body(replace(marks, names=names), left), subset


def found_marks(footage: Footage, project: Project, fps: float, first: Picture, watch: Watch, mask: Mask | None) -> tuple[Body, int]:
    """Find places where the film moves, track them, and keep those that move as one body.

    Where nothing differs from the first frame, places with texture are tracked, to tell whether they move at all.

    Parameters
    ----------
    footage, project, fps, first, watch, mask
        As in `chosen_marks`.

    Returns
    -------
    body : Body
    subset : int
        Side of the subset, px; smaller than usual where the body is small and the project gives none.

    Raises
    ------
    InputError
        No place has texture enough.
    """
    fixed = "subset_px" in project.marks.model_fields_set
    places, subset = places_that_move(find_motion(footage), project.marks.subset_px, _MOST, fixed)
    places = [place for place in places if not why_unusable(first, place, subset, mask)]
    if not places:
        subset = project.marks.subset_px
        places = [place for place in places_with_texture(first, subset, _MOST) if not why_unusable(first, place, subset, mask)]
    if not places:
        raise InputError(f"{footage.name}: no place in the first frame has texture enough to be tracked. Name the marks with --mark X,Y.")
    return one_body(_tracked(footage, project, places, fps, subset, watch, mask)), subset


def _tracked(
    footage: Footage, project: Project, places: list[tuple[float, float]], fps: float, subset: int, watch: Watch, mask: Mask | None
) -> Marks:
    warp = next(count for count, name in WARP_NAMES.items() if name == project.marks.warp)
    exposure_s = footage.per_frame * (project.film.exposure_s or footage.exposure_s or 0.0)  # over the step from picture to picture
    return track_marks(footage, places, fps, subset, warp, exposure_s, watch=watch, mask=mask)
