"""The platform as a rigid body with marks: where they sit on it, and where the refinement finds them under a pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.marks import Marks
from measure.correlation.shape_function_bias import Response
from measure.geometry.camera import Camera, on_cylinder, rotation

Array = NDArray[np.float64]

_STEP = 1e-5
"""Step of the central differences, m and rad."""


def body_points(marks: Marks, camera: Camera, radius_m: float | None) -> Array:
    """Positions of the marks' nodes on the platform, relative to its origin in the first frame.

    Parameters
    ----------
    marks : Marks
    camera : Camera
    radius_m : float or None
        Radius of an upright cylinder about the platform's origin that carries the marks, m; None puts all of them at
        the origin's depth.

    Returns
    -------
    (marks, 9, 3) array
        m.

    Raises
    ------
    InputError
        A mark beside the cylinder.
    """
    picture = marks.response.nodes_px
    if radius_m is None:
        return camera.place(picture, np.zeros(picture.shape[:2]))
    points = on_cylinder(camera, picture, radius_m)
    beside = np.isnan(points[..., 0]).any(axis=1)
    if beside.any():
        which = int(np.argmax(beside))
        raise InputError(
            f"mark {marks.names[which]} at {marks.reference_px[which, 0]:g},{marks.reference_px[which, 1]:g}: its subset reaches beside "
            f"the cylinder of {1000 * radius_m:g} mm radius about {camera.origin_px[0]:g},{camera.origin_px[1]:g}. "
            "Check radius_m, origin_px, the scale and the subset."
        )
    return points


def beside_cylinder(marks: Marks, camera: Camera, radius_m: float | None) -> NDArray[np.bool_]:
    """Which marks reach beside the cylinder that should carry them.

    Parameters
    ----------
    marks, camera, radius_m
        As in `body_points`.

    Returns
    -------
    (marks,) array of bool
    """
    if radius_m is None:
        return np.zeros(len(marks.names), bool)
    return np.asarray(np.isnan(on_cylinder(camera, marks.response.nodes_px, radius_m)[..., 0]).any(axis=1))


@dataclass(frozen=True)
class Body:
    """The platform in front of the camera. `points` : (marks, 9, 3) array, m, from `body_points`."""

    camera: Camera
    points: Array
    response: Response

    def project(self, poses: Array) -> Array:
        """Where the refinement finds the marks under some poses.

        Parameters
        ----------
        poses : (..., 6) array
            In the order of `CHANNELS`, m and rad, from the first frame.

        Returns
        -------
        (..., marks, 2) array
            px.
        """
        return self.response.apparent(self._nodes(poses))

    def carried(self, poses: Array) -> Array:
        """What some poses make of a small shift on each mark in the reference image.

        Parameters
        ----------
        poses : (..., 6) array
            As in `project`.

        Returns
        -------
        (..., marks, 2, 2) array
            px per px.
        """
        return self.response.stretch(self._nodes(poses))

    def _nodes(self, poses: Array) -> Array:
        """The marks' nodes under some poses, (..., marks, 9, 2), px."""
        world = np.einsum("...ij,nqj->...nqi", rotation(poses[..., 3:]), self.points) + poses[..., None, None, :3]
        return self.camera.project(world)

    def slopes(self, pose: Array, at: list[int]) -> tuple[Array, Array]:
        """Positions under a pose, and their derivatives with respect to some channels, by central differences.

        Parameters
        ----------
        pose : (6,) array
        at : list of k int
            Indices into `CHANNELS`.

        Returns
        -------
        positions : (marks, 2) array
            px.
        slopes : (marks, 2, k) array
            px per m or rad.
        """
        steps = _STEP * np.eye(6)[at]
        places = self.project(np.concatenate([pose[None], pose + steps, pose - steps]))
        ahead, behind = places[1 : 1 + len(at)], places[1 + len(at) :]
        return places[0], np.moveaxis((ahead - behind) / (2 * _STEP), 0, -1)
