"""A film to the platform's trajectory, in one call."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.marks import Marks
from measure.correlation.steepest_descent import AFFINE, WARP_NAMES
from measure.correlation.template_matching import find_marks
from measure.correlation.tracking import check_subset, track_marks
from measure.film.summary import summarise
from measure.film.tracked import Tracked
from measure.footage.footage import Footage, Picture
from measure.footage.integrity import IntegrityCheck
from measure.geometry.body import body_points
from measure.geometry.camera import Camera
from measure.geometry.film_project import Project
from measure.geometry.rigid_body import CYLINDER, ONE_MARK, PERSPECTIVE, PLANE, Fit, fit_platform, trajectory
from measure.geometry.scale import camera_of, picture_scale

_STILL_SHARE = 0.3
"""A mark that moves less than this share of the largest motion belongs to the background."""

_UNCERTAIN = 4.0
"""Times the median standard deviation of all marks from which a mark that was found is left out."""


def track(
    footage: Footage,
    project: Project,
    watch: Callable[[Iterator], Iterator] = iter,
    mask: NDArray[np.bool_] | None = None,
) -> Tracked:
    """Track the marks of a film and fit the platform to them.

    Parameters
    ----------
    footage : Footage
        From `open_footage` or `from_array`.
    project : Project
        Capture rate, marks, scale, platform and camera. The rate that the camera reports counts where the project gives
        none; marks are found where it names none.
    watch : function, optional
        Wraps the stream of frames, for a progress bar.
    mask : (height, width) array of bool, optional
        Pixels of the first frame that belong to marks.

    Returns
    -------
    Tracked
        Its project is complete: it repeats the run.

    Raises
    ------
    InputError
        No capture rate, no marks, a film too short.
    """
    fps = _rate(footage, project)
    check_subset(project.marks.subset_px)
    first = _first(footage)
    scale = picture_scale(project, first)
    check = IntegrityCheck()
    marks = _tracked_marks(footage, project, fps, first, lambda frames: watch(check.watch(frames)), mask)
    origin = project.platform.origin_px or (float(marks.reference_px[:, 0].mean()), float(marks.reference_px[:, 1].mean()))
    project = _completed(project, footage, marks, fps, origin)
    fit, table = None, None
    if scale is not None:
        camera = camera_of(project, scale, origin, (footage.width, footage.height))
        fit = _fit(marks, camera, project)
        table = trajectory(marks, fit, project.platform.start_height_m, footage.name)
    return Tracked(table, marks, fit, project, summarise(footage, project, scale, marks, fit, table, check))


def _rate(footage: Footage, project: Project) -> float:
    fps = project.film.fps or footage.fps
    if fps is None:
        raise InputError(
            f"{footage.name}: carries no capture rate of the camera (the rate in a container is that of playing). "
            "Give --fps with the rate that the camera was set to."
        )
    return fps


def _first(footage: Footage) -> Picture:
    for _, picture in footage.pictures():
        return picture
    raise InputError(f"{footage.name}: no frame could be read. Copy the film again from the camera.")


def _tracked_marks(
    footage: Footage, project: Project, fps: float, first: Picture, watch: Callable[[Iterator], Iterator], mask: NDArray[np.bool_] | None
) -> Marks:
    """The marks that the project names, or those that are found and move."""
    warp = next(count for count, name in WARP_NAMES.items() if name == project.marks.warp)
    exposure_s = project.film.exposure_s or footage.exposure_s or 0.0
    subset = project.marks.subset_px
    if project.marks.place_px:
        return track_marks(footage, project.marks.place_px, fps, subset, warp, exposure_s, watch=watch, mask=mask)
    places = find_marks(first, subset)
    if not places:
        raise InputError(f"{footage.name}: no place in the first frame has texture enough to be tracked. Name the marks with --mark X,Y.")
    return moving(track_marks(footage, places, fps, subset, AFFINE, exposure_s, watch=watch, mask=mask))


def moving(marks: Marks) -> Marks:
    """Keep the marks that move most; what stands still is the background.

    A mark moves by the diagonal of the box around its path. Marks that are not observed in half of the frames are left out
    too, and those whose standard deviation is many times the others': an edge of the platform behind a rod is not a mark.

    Parameters
    ----------
    marks : Marks

    Returns
    -------
    Marks
        Named anew, m1, m2 ...
    """
    often = marks.observed.mean(axis=0) >= min(0.5, marks.observed.mean(axis=0).max())
    sigma = np.array([np.median(marks.sigma_px[marks.observed[:, i], i]) if often[i] else np.inf for i in range(len(often))])
    often &= sigma <= _UNCERTAIN * np.median(sigma[often])
    extent = np.array([_extent(marks, i) for i in range(len(marks.names))])
    kept = often & (extent >= _STILL_SHARE * extent[often].max())
    return dataclasses.replace(marks.only(kept), names=[f"m{i + 1}" for i in range(int(kept.sum()))])


def _extent(marks: Marks, i: int) -> float:
    at = marks.observed[:, i]
    return float(np.hypot(np.ptp(marks.x_px[at, i]), np.ptp(marks.y_px[at, i]))) if at.any() else 0.0


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
    """Which channels a film can determine.

    Parameters
    ----------
    count : int
        Number of marks.
    project : Project
        With radius_m of the platform or without it.
    camera : Camera
        With a finite distance or without it.

    Returns
    -------
    sequence of str
        x and z; with two marks theta_y; with three on a cylinder theta_z; with four and a distance all six.
    """
    if count == 1:
        return ONE_MARK
    if project.platform.radius_m is None or count < 3:
        return PLANE
    return CYLINDER if np.isinf(camera.distance_m) or count < 4 else PERSPECTIVE
