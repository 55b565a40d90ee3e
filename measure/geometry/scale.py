"""From pixels to millimetres, and where up is: measured in the first frame or given, with what is not known of it.

The scale of a film outweighs all errors of tracking: a rule 20 mm behind the marks, seen from 1 m, is 2 %.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from measure.common.errors import InputError
from measure.footage.footage import Picture
from measure.geometry.camera import Camera
from measure.geometry.film_project import Point, Project
from measure.geometry.picture_lines import pitch_along, plumb_line


@dataclass(frozen=True)
class Sized:
    """What turns the picture into metres. relative_sigma : of mm_per_px, one standard deviation. up_sigma_deg : of up_deg.

    said : how the scale was found, in words.
    """

    mm_per_px: float
    relative_sigma: float
    up_deg: float
    up_sigma_deg: float
    said: str


def sized(project: Project, picture: Picture) -> Sized | None:
    """The scale and the vertical that a project gives, or measures in the first frame; None without any scale.

    Raises
    ------
    InputError
        Two points that coincide, no graduation or no plumb line where they were said to be, a depth without a distance.
    """
    if not project.has_scale():
        return None
    scale = project.scale
    up, up_sigma = (scale.up_deg, 0.0) if scale.plumb_px is None else plumb_line(picture, scale.plumb_px)
    found = _measured(project, picture)
    return replace(_at_the_platform(found, project), up_deg=up, up_sigma_deg=up_sigma)


def _measured(project: Project, picture: Picture) -> Sized:
    """The scale where it was measured."""
    scale, camera = project.scale, project.camera
    if scale.mm_per_px is not None:
        return Sized(scale.mm_per_px, scale.relative_sigma, 0.0, 0.0, "given")
    if scale.from_px_mm is not None:
        return _two_points(project)
    if scale.rule_px_mm is not None:
        pitch_px, sigma_px = pitch_along(picture, scale.rule_px_mm[:4])
        sigma = math.hypot(sigma_px / pitch_px, scale.relative_sigma)
        return Sized(scale.rule_px_mm[4] / pitch_px, sigma, 0.0, 0.0, f"from a rule, {pitch_px:.4f} +- {sigma_px:.4f} px a division")
    assert camera.focal_px is not None
    assert camera.distance_m is not None
    sigma = math.hypot(camera.focal_sigma_px / camera.focal_px, camera.distance_sigma_m / camera.distance_m)
    return Sized(1000.0 * camera.distance_m / camera.focal_px, sigma, 0.0, 0.0, "from the distance and the calibrated focal length")


def _two_points(project: Project) -> Sized:
    scale = project.scale
    assert scale.from_px_mm is not None
    x1, y1, x2, y2, length = scale.from_px_mm
    apart = math.hypot(x2 - x1, y2 - y1)
    if apart < 2.0 or length <= 0.0:
        raise InputError(
            f"--scale-from: the points are {apart:.3g} px apart and the length is {length:g} mm; "
            "give two distinct points X1,Y1,X2,Y2 and the LENGTH_MM between them."
        )
    sigma = math.hypot(math.sqrt(2.0) * scale.point_sigma_px / apart, scale.length_sigma_mm / length, scale.relative_sigma)
    return Sized(length / apart, sigma, 0.0, 0.0, f"from two points {apart:.1f} px apart")


def _at_the_platform(found: Sized, project: Project) -> Sized:
    """The scale carried from the depth where it was measured to that of the platform's origin: times D / (D + depth)."""
    scale, distance = project.scale, project.camera.distance_m
    if not scale.depth_mm and not scale.depth_sigma_mm:
        return found
    if distance is None:
        raise InputError("scale.depth_mm needs the camera's distance; give distance_m in [camera].")
    farther = 1000.0 * distance + scale.depth_mm
    if farther <= 0.0:
        raise InputError(f"scale.depth_mm: {scale.depth_mm:g} mm is behind the camera, which is {distance:g} m away. Mend one of them.")
    sigma = math.hypot(found.relative_sigma, scale.depth_sigma_mm / farther, abs(scale.depth_mm) / farther * _off(project))
    return replace(found, mm_per_px=found.mm_per_px * 1000.0 * distance / farther, relative_sigma=sigma)


def _off(project: Project) -> float:
    """Relative uncertainty of the distance, which the carried part of the scale shares."""
    return project.camera.distance_sigma_m / (project.camera.distance_m or math.inf)


def view(project: Project, size: Sized, origin_px: Point, picture: tuple[int, int]) -> Camera:
    """The camera; picture : width and height, px, whose middle is the principal point unless given.

    A calibrated focal length and a scale give the distance, f S, where none is given.
    """
    camera, m_per_px = project.camera, size.mm_per_px / 1000.0
    distance = camera.distance_m or (camera.focal_px * m_per_px if camera.focal_px else math.inf)
    middle = ((picture[0] - 1) / 2, (picture[1] - 1) / 2)
    principal = None if math.isinf(distance) else camera.principal_px or middle
    focal = camera.focal_px or distance / m_per_px
    return Camera(m_per_px, origin_px, math.radians(size.up_deg), distance, principal, focal, _lens(project, focal))


def _lens(project: Project, focal: float) -> tuple[float, ...]:
    if project.camera.distortion and not np.isfinite(focal):
        raise InputError("camera.distortion needs the focal length it was found with; give focal_px in [camera].")
    return project.camera.distortion
