"""A film to the platform's trajectory, in one call."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.marks import LOST, MISSING, Marks
from measure.correlation.tracking import check_subset
from measure.film.choosing import chosen_marks, found_marks
from measure.film.one_body import Body
from measure.film.part import capture_rate, part_of, sigma_factor
from measure.film.summary import summarise
from measure.film.tracked import Tracked
from measure.footage.footage import Footage, Picture
from measure.footage.integrity import IntegrityCheck
from measure.geometry.body import beside_cylinder, body_points
from measure.geometry.camera import Camera
from measure.geometry.film_project import Project
from measure.geometry.mark_places import places_on_body
from measure.geometry.reference_error import without_reference_error
from measure.geometry.rigid_body import CYLINDER, ONE_MARK, PERSPECTIVE, PLANE, Fit, contradicted, fit_platform, trajectory
from measure.geometry.rolling_shutter import at_one_instant
from measure.geometry.scale import camera_of, picture_scale

_ASTRAY, _ASTRAY_PX = 5.0, 0.3
"""Residual of a found mark to the rigid body, over the median of the marks and in px, from which it does not belong to it."""


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
        none; marks are found where it names none. Where it gives a part of the film, that part alone is used.
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
        No capture rate, no marks, a film too short, a part outside of the film.
    """
    fps = capture_rate(footage, project)
    check_subset(project.marks.subset_px)
    footage = part_of(footage, project)
    first = _first(footage)
    scale = picture_scale(project, first)
    check = IntegrityCheck(first=footage.first)

    def watched(frames: Iterator) -> Iterator:
        return watch(check.watch(frames))

    chosen = bool(project.marks.place_px)
    body, subset = (chosen_marks if chosen else found_marks)(footage, project, fps, first, watched, mask)
    seen = _without(body.marks, check.copies).widened(sigma_factor(footage))
    body = replace(body, marks=at_one_instant(seen, project.camera.readout_s, footage.height))
    origin = project.platform.origin_px or _middle(body.marks)
    fit, table = None, None
    if scale is not None:
        camera = camera_of(project, scale, origin, (footage.width, footage.height))
        body, fit = _fitted(body, camera, project, chosen)
        table = trajectory(body.marks, fit, project.platform.start_height_m, footage.name)
        body = replace(body, marks=_on_body(body.marks, camera, project.platform.radius_m, fit))
    project = _completed(project, footage, body.marks, fps, origin, subset)
    return Tracked(table, body.marks, fit, project, summarise(footage, project, scale, body, fit, table, check))


def _middle(marks: Marks) -> tuple[float, float]:
    return float(marks.reference_px[:, 0].mean()), float(marks.reference_px[:, 1].mean())


def _without(marks: Marks, copies: Sequence[int]) -> Marks:
    """The marks with the frames that are copies of the one before as missing: what they show is an old position."""
    which = np.zeros(marks.status.shape, bool)
    which[list(copies)] = True
    return marks.without(which, MISSING)


def _first(footage: Footage) -> Picture:
    for _, picture in footage.pictures():
        return picture
    raise InputError(f"{footage.name}: no frame could be read. Copy the film again from the camera.")


def _completed(project: Project, footage: Footage, marks: Marks, fps: float, origin: tuple[float, float], subset: int) -> Project:
    film = project.film.model_copy(update={"fps": fps, "exposure_s": project.film.exposure_s or footage.exposure_s})
    places = tuple((float(x), float(y)) for x, y in marks.reference_px)
    listed = project.marks.model_copy(update={"place_px": places, "subset_px": subset})
    platform = project.platform.model_copy(update={"origin_px": origin})
    return project.model_copy(update={"film": film, "marks": listed, "platform": platform})


def _fitted(body: Body, camera: Camera, project: Project, chosen: bool) -> tuple[Body, Fit]:
    """The rigid body fitted to the marks; without those beside its cylinder and, of marks that were found, those that go astray."""
    radius_m = project.platform.radius_m
    beside = beside_cylinder(body.marks, camera, radius_m)
    if not beside.all():
        body = body.without(beside, "its subset reaches beside the cylinder; check radius_m, origin_px, the scale and the subset")
    while True:
        points = body_points(body.marks, camera, radius_m)
        fit = fit_platform(body.marks, camera, points, free_channels(len(body.marks.names), project, camera))
        astray = np.zeros(len(body.marks.names), bool) if chosen else _astray(fit)
        if not astray.any():
            marks, fit = without_reference_error(body.marks, camera, points, fit)
            return replace(body, marks=marks), fit
        body = body.without(astray, "does not move as one body with the rest")


def _on_body(marks: Marks, camera: Camera, radius_m: float | None, fit: Fit) -> Marks:
    """The marks as the body explains them: with its misfit, without what it contradicts, at their reference points."""
    wrong = contradicted(marks, camera, body_points(marks, camera, radius_m), fit)
    seen = marks.widened(fit.widened if fit.is_rigid else 1.0).without(wrong, LOST)
    return places_on_body(seen, camera, radius_m, fit)


def _astray(fit: Fit) -> NDArray[np.bool_]:
    """The mark that leaves the rigid body farthest, where it does so many times farther than the others and can be spared."""
    residual = fit.mark_residual_px
    if len(residual) < 5 or not np.isfinite(residual).all():
        return np.zeros(len(residual), bool)
    far = residual > max(_ASTRAY * float(np.median(residual)), _ASTRAY_PX)
    return far & (residual == residual.max())


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
