"""From pixels to millimetres, and where up is: given, or measured in the first frame, with its uncertainty.

The scale of a film outweighs all errors of tracking: a rule 20 mm behind the marks, seen from 1 m, is 2 %.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from measure.common.errors import InputError
from measure.footage.footage import Picture
from measure.geometry.camera import Camera
from measure.geometry.film_project import Point, Project
from measure.geometry.rule_and_plumb_line import pitch_along, plumb_line


@dataclass(frozen=True)
class PictureScale:
    """What turns the picture into metres.

    Attributes
    ----------
    mm_per_px : float
        Size of a pixel at the depth of the platform's origin, mm.
    relative_sigma : float
        Its uncertainty, one standard deviation.
    up_deg, up_sigma_deg : float
        Direction of up in the picture, clockwise from the picture's own, and its standard deviation, deg.
    source : str
        How the scale was found, in words.
    """

    mm_per_px: float
    relative_sigma: float
    up_deg: float
    up_sigma_deg: float
    source: str

    def summary(self) -> dict[str, Any]:
        """In numbers, as `--json` writes it; `source` is under `said`."""
        numbers = asdict(self)
        return {**numbers, "said": numbers.pop("source")}


def picture_scale(project: Project, picture: Picture) -> PictureScale | None:
    """The scale and the vertical that a project gives, or that are measured in the first frame.

    Parameters
    ----------
    project : Project
    picture : (height, width) array
        The first frame.

    Returns
    -------
    PictureScale or None
        None where the project has no scale.

    Raises
    ------
    InputError
        Two points that coincide, no graduation or no plumb line at the place given, a depth without a distance.
    """
    if not project.has_scale():
        return None
    scale = project.scale
    up, up_sigma = (scale.up_deg, 0.0) if scale.plumb_px is None else plumb_line(picture, scale.plumb_px)
    return replace(_at_the_platform(_measured(project, picture), project), up_deg=up, up_sigma_deg=up_sigma)


def _measured(project: Project, picture: Picture) -> PictureScale:
    """The scale at the depth where it was measured."""
    scale = project.scale
    if scale.mm_per_px is not None:
        return PictureScale(scale.mm_per_px, scale.relative_sigma, 0.0, 0.0, "given")
    if scale.from_px_mm is not None:
        return _from_two_points(project)
    if scale.rule_px_mm is not None:
        pitch_px, sigma_px = pitch_along(picture, scale.rule_px_mm[:4])
        sigma = math.hypot(sigma_px / pitch_px, scale.relative_sigma)
        source = f"from a rule, {pitch_px:.4f} +- {sigma_px:.4f} px a division"
        return PictureScale(scale.rule_px_mm[4] / pitch_px, sigma, 0.0, 0.0, source)
    return _from_lens(project)


def _from_two_points(project: Project) -> PictureScale:
    scale = project.scale
    assert scale.from_px_mm is not None
    x1, y1, x2, y2, length = scale.from_px_mm
    apart = math.hypot(x2 - x1, y2 - y1)
    if apart < 2.0:
        raise InputError(
            f"--scale-from: the points are {apart:.3g} px apart; give two distinct points X1,Y1,X2,Y2 and the LENGTH_MM between them."
        )
    sigma = math.hypot(math.sqrt(2.0) * scale.point_sigma_px / apart, scale.length_sigma_mm / length, scale.relative_sigma)
    return PictureScale(length / apart, sigma, 0.0, 0.0, f"from two points {apart:.1f} px apart")


def _from_lens(project: Project) -> PictureScale:
    camera = project.camera
    assert camera.focal_px is not None
    assert camera.distance_m is not None
    sigma = math.hypot(camera.focal_sigma_px / camera.focal_px, camera.distance_sigma_m / camera.distance_m)
    source = "from the distance and the calibrated focal length"
    return PictureScale(1000.0 * camera.distance_m / camera.focal_px, sigma, 0.0, 0.0, source)


def _at_the_platform(found: PictureScale, project: Project) -> PictureScale:
    """The scale carried from the depth where it was measured to that of the platform's origin: times D / (D + depth)."""
    scale, distance = project.scale, project.camera.distance_m
    if not scale.depth_mm and not scale.depth_sigma_mm:
        return found
    if distance is None:
        raise InputError("scale.depth_mm needs the camera's distance; give distance_m in [camera].")
    farther = 1000.0 * distance + scale.depth_mm
    if farther <= 0.0:
        raise InputError(f"scale.depth_mm: {scale.depth_mm:g} mm is behind the camera, which is {distance:g} m away. Mend one of them.")
    by_distance = abs(scale.depth_mm) / farther * project.camera.distance_sigma_m / distance
    sigma = math.hypot(found.relative_sigma, scale.depth_sigma_mm / farther, by_distance)
    return replace(found, mm_per_px=found.mm_per_px * 1000.0 * distance / farther, relative_sigma=sigma)


def camera_of(project: Project, scale: PictureScale, origin_px: Point, picture: tuple[int, int]) -> Camera:
    """The camera of a project. A calibrated focal length f and a scale S give the distance, f S, where none is given.

    Parameters
    ----------
    project : Project
    scale : PictureScale
    origin_px : (x, y)
        The platform's origin in the first frame, px.
    picture : (width, height)
        px; its middle is the principal point unless the project gives one.

    Returns
    -------
    Camera

    Raises
    ------
    InputError
        Distortion without a focal length.
    """
    camera, m_per_px = project.camera, scale.mm_per_px / 1000.0
    distance = camera.distance_m or (camera.focal_px * m_per_px if camera.focal_px else math.inf)
    middle = ((picture[0] - 1) / 2, (picture[1] - 1) / 2)
    principal = None if math.isinf(distance) else camera.principal_px or middle
    focal = camera.focal_px or distance / m_per_px
    if camera.distortion and not np.isfinite(focal):
        raise InputError("camera.distortion needs the focal length it was found with; give focal_px in [camera].")
    return Camera(m_per_px, origin_px, math.radians(scale.up_deg), distance, principal, focal, camera.distortion)
