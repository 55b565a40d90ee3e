"""Where the reference points are once the body is known: sightings without what bent subsets and the reference picture get wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from measure.correlation.marks import LOST, Marks
from measure.geometry.body import Body, body_points
from measure.geometry.camera import Camera, on_cylinder, rotation
from measure.geometry.rigid_body import Fit

Array = NDArray[np.float64]


def places_on_body(marks: Marks, camera: Camera, radius_m: float | None, fit: Fit) -> Marks:
    """The marks with their positions as places of the reference points on the body.

        x = seen - s A e - (apparent - projected)

    s A e is what the error of the reference picture adds (`measure.geometry.reference_error`). A subset on a cylinder that turns
    is bent, and its refined place (apparent) leaves the reference point that the body carries (projected).

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
        With the covariances of the fit. A sighting that the body contradicts has the status lost, and no position; where there
        is no pose the positions are as they were.
    """
    x, y = np.moveaxis(np.stack([marks.x_px, marks.y_px], axis=-1) - fit.offset_px - _bent(marks, camera, radius_m, fit), -1, 0)
    return replace(marks, x_px=x, y_px=y, covariance_px2=fit.mark_covariance_px2).without(fit.astray, LOST)


def _bent(marks: Marks, camera: Camera, radius_m: float | None, fit: Fit) -> Array:
    """How far the refined places leave the reference points, (frames, marks, 2) px; zero without a pose."""
    body = Body(camera, body_points(marks, camera, radius_m), marks.response)
    at = marks.reference_px
    points = camera.place(at, np.zeros(len(at))) if radius_m is None else on_cylinder(camera, at, radius_m)
    pose = np.where(fit.has_pose[:, None], fit.pose, 0.0)
    carried = np.einsum("tij,nj->tni", rotation(pose[:, 3:]), points) + pose[:, None, :3]
    return np.where(fit.has_pose[:, None, None], body.project(pose) - camera.project(carried), 0.0)
