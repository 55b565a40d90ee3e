"""A film to the platform's trajectory, in one call."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.marks import Marks
from measure.correlation.reference_image import AFFINE, WARP_NAMES
from measure.correlation.template_matching import find_marks
from measure.correlation.tracking import check_subset, follow
from measure.film.summary import summarise
from measure.footage.footage import Footage, Picture
from measure.footage.integrity import Health
from measure.geometry.camera import Camera
from measure.geometry.film_project import Project
from measure.geometry.rigid_body import (
    CYLINDER,
    ONE_MARK,
    PERSPECTIVE,
    PLANE,
    Fit,
    body_points,
    fit_platform,
    trajectory,
)
from measure.geometry.scale import sized, view
from measure.tables.trajectory import Trajectory

_STILL_SHARE = 0.3
"""A mark that moves less than this share of what most do belongs to the background."""


_VAGUE = 4.0


@dataclass(frozen=True)
class Tracked:
    """What a film says: the platform's trajectory (None without a scale), all marks, the fit, the project, a summary."""

    trajectory: Trajectory | None
    marks: Marks
    fit: Fit | None
    project: Project
    summary: dict[str, Any]


def track(
    footage: Footage,
    project: Project,
    watch: Callable[[Iterator], Iterator] = iter,
    mask: NDArray[np.bool_] | None = None,
) -> Tracked:
    """Follow the marks of a film and fit the platform to them.

    footage : from `open_footage` or `from_array`. project : capture rate, marks, scale and camera; the film's own
    rate counts where the project gives none, and marks are found where it names none. watch : wraps the stream of
    frames, for a progress bar. mask : (rows, columns), pixels of the first
    frame that belong to marks. The result's project is complete: it repeats the run.

    Raises
    ------
    InputError
        No capture rate, no marks, a film too short.
    """
    fps = _rate(footage, project)
    check_subset(project.marks.subset_px)
    first = _first(footage)
    size = sized(project, first)
    health = Health()
    marks = _follow(footage, project, fps, first, lambda frames: watch(health.watch(frames)), mask)
    origin = project.platform.origin_px or (float(marks.reference_px[:, 0].mean()), float(marks.reference_px[:, 1].mean()))
    project = _completed(project, footage, marks, fps, origin)
    fit, table = None, None
    if size is not None:
        camera = view(project, size, origin, (footage.width, footage.height))
        fit = _fit(marks, camera, project)
        table = trajectory(marks, fit, project.platform.start_height_m, footage.name)
    return Tracked(table, marks, fit, project, summarise(footage, project, size, marks, fit, table, health))


def _rate(footage: Footage, project: Project) -> float:
    fps = project.film.fps or footage.fps
    if fps is None:
        raise InputError(
            f"{footage.name}: carries no capture rate of the camera (what a container says is the rate of playing). "
            "Give --fps with the rate the camera was set to."
        )
    return fps


def _first(footage: Footage) -> Picture:
    for _, picture in footage.pictures():
        return picture
    raise InputError(f"{footage.name}: no frame could be read. Copy the film again from the camera.")


def _follow(
    footage: Footage, project: Project, fps: float, first: Picture, watch: Callable[[Iterator], Iterator], mask: NDArray[np.bool_] | None
) -> Marks:
    warp = next(count for count, name in WARP_NAMES.items() if name == project.marks.warp)
    exposure_s = project.film.exposure_s or footage.exposure_s or 0.0
    if project.marks.place_px:
        return follow(footage, project.marks.place_px, fps, project.marks.subset_px, warp, exposure_s, watch=watch, mask=mask)
    places = find_marks(first, project.marks.subset_px)
    if not places:
        raise InputError(f"{footage.name}: no place in the first frame has texture enough to be followed. Name the marks with --mark X,Y.")
    marks = follow(footage, places, fps, project.marks.subset_px, AFFINE, exposure_s, watch=watch, mask=mask)
    return moving(marks)


def moving(marks: Marks) -> Marks:
    """The marks that move with the majority of the travel; what stands still is the background.

    A mark's travel is the diagonal of the box around its path. Marks not seen in half of the frames are left out too, and
    those whose sigma is many times the others': an edge of the platform behind a rod is not a mark.
    """
    often = marks.seen.mean(axis=0) >= min(0.5, marks.seen.mean(axis=0).max())
    sigma = np.array([np.median(marks.sigma_px[marks.seen[:, i], i]) if often[i] else np.inf for i in range(len(often))])
    often &= sigma <= _VAGUE * np.median(sigma[often])
    travel = np.array([_travel(marks, i) for i in range(len(marks.names))])
    kept = often & (travel >= _STILL_SHARE * travel[often].max())
    chosen = marks.only(kept)
    return dataclasses.replace(chosen, names=[f"m{i + 1}" for i in range(int(kept.sum()))])


def _travel(marks: Marks, i: int) -> float:
    seen = marks.seen[:, i]
    return float(np.hypot(np.ptp(marks.x_px[seen, i]), np.ptp(marks.y_px[seen, i]))) if seen.any() else 0.0


def _completed(project: Project, footage: Footage, marks: Marks, fps: float, origin: tuple[float, float]) -> Project:
    film = project.film.model_copy(update={"fps": fps, "exposure_s": project.film.exposure_s or footage.exposure_s})
    places = tuple((float(x), float(y)) for x, y in marks.reference_px)
    listed = project.marks.model_copy(update={"place_px": places})
    platform = project.platform.model_copy(update={"origin_px": origin})
    return project.model_copy(update={"film": film, "marks": listed, "platform": platform})


def _fit(marks: Marks, camera: Camera, project: Project) -> Fit:
    points = body_points(marks, camera, project.platform.radius_m)
    return fit_platform(marks, camera, points, free_channels(len(marks.names), project, camera))


def free_channels(count: int, project: Project, camera: Camera) -> Sequence[str]:
    """What a film with so many marks can tell, with the geometry that the project knows."""
    if count == 1:
        return ONE_MARK
    if project.platform.radius_m is None or count < 3:
        return PLANE
    return CYLINDER if np.isinf(camera.distance_m) or count < 4 else PERSPECTIVE
