"""The marks once the body is known: sightings as places of the reference points that the body carries."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from measure.correlation.marks import Marks
from measure.geometry.body import Body, body_points
from measure.geometry.camera import Camera, on_cylinder, rotation
from measure.geometry.rigid_body import Fit

Array = NDArray[np.float64]


def places_on_body(marks: Marks, camera: Camera, radius_m: float | None, fit: Fit) -> Marks:
    """The marks with their positions as places of the reference points.

        x = seen - (apparent - projected)

    A subset on a cylinder that turns is bent, and its refined place (apparent) leaves the reference point that the body
    carries (projected). The residuals of the fit are those of these places too: seen - apparent = x - projected.

    Parameters
    ----------
    marks : Marks
    camera : Camera
    radius_m : float or None
        Of the cylinder that carries the marks, m, as in `body_points`.
    fit : Fit
        Of the body to these marks.

    Returns
    -------
    Marks
        In a frame without a pose the positions are as they were.
    """
    shift = _shift(marks, camera, radius_m, fit)
    return replace(marks, x_px=marks.x_px - shift[..., 0], y_px=marks.y_px - shift[..., 1])


def _shift(marks: Marks, camera: Camera, radius_m: float | None, fit: Fit) -> Array:
    """Apparent minus projected places, (frames, marks, 2) px; zero without a pose."""
    body = Body(camera, body_points(marks, camera, radius_m), marks.response)
    at = marks.reference_px
    points = camera.place(at, np.zeros(len(at))) if radius_m is None else on_cylinder(camera, at, radius_m)
    pose = np.where(fit.has_pose[:, None], fit.pose, 0.0)
    carried = np.einsum("tij,nj->tni", rotation(pose[:, 3:]), points) + pose[:, None, :3]
    return np.where(fit.has_pose[:, None, None], body.project(pose) - camera.project(carried), 0.0)
