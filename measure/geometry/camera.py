"""From the platform to the picture: the camera in front of the rig, its lens, and rotations of the platform.

World: x to the right, y away from the camera, z up; the pose is counted from the first frame. Picture: x to the right,
y down, pixel centres at whole numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Camera:
    """A pinhole camera that looks along +y, with a lens.

    Attributes
    ----------
    m_per_px : float
        Size of a pixel at the depth of the platform's origin, m.
    origin_px : (x, y)
        That origin in the first frame, px.
    up_rad : float
        Direction of up in the picture, clockwise from the picture's own, rad.
    distance_m : float
        From the camera to the origin, m; infinite for a camera without perspective.
    principal_px : (x, y) or None
        Where the optical axis meets the picture, px; the origin where it is None.
    focal_px : float
        Focal length, px.
    distortion : tuple of float
        k1, k2, p1, p2, k3 as cv2.calibrateCamera gives them; none where it is empty.
    """

    m_per_px: float
    origin_px: tuple[float, float] = (0.0, 0.0)
    up_rad: float = 0.0
    distance_m: float = np.inf
    principal_px: tuple[float, float] | None = None
    focal_px: float = np.inf
    distortion: tuple[float, ...] = ()

    def project(self, points: Array) -> Array:
        """Project points of the world into the picture.

            x_px = p_x + (X + X_0) / S / (1 + Y / D),    y_px = p_y - (Z + Z_0) / S / (1 + Y / D)

        with S the pixel's size, D the distance, p the principal point, and (X_0, Z_0) the first frame's origin relative
        to the optical axis.

        Parameters
        ----------
        points : (..., 3) array
            Relative to the platform's origin in the first frame, m.

        Returns
        -------
        (..., 2) array
            px.
        """
        principal, right, up = self._axes()
        away = (self.without_distortion(np.array(self.origin_px)) - principal) * self.m_per_px
        nearer = 1.0 / (1.0 + points[..., 1] / self.distance_m)
        across = (points[..., 0] + away @ right) * nearer / self.m_per_px
        above = (points[..., 2] + away @ up) * nearer / self.m_per_px
        return self.with_distortion(principal + across[..., None] * right + above[..., None] * up)

    def place(self, picture_px: Array, depth: Array) -> Array:
        """Points of the world at known depths; the inverse of `project`.

        Parameters
        ----------
        picture_px : (..., 2) array
            px.
        depth : (...) array
            y of the points, m.

        Returns
        -------
        (..., 3) array
            m.
        """
        principal, right, up = self._axes()
        away = (self.without_distortion(np.array(self.origin_px)) - principal) * self.m_per_px
        offset = (self.without_distortion(picture_px) - principal) * self.m_per_px * (1.0 + depth / self.distance_m)[..., None]
        return np.stack([offset @ right - away @ right, depth, offset @ up - away @ up], axis=-1)

    def with_distortion(self, ideal_px: Array) -> Array:
        """Apply the distortion of the lens.

            x_d = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2),    y_d alike,    x = (x_px - p) / f

        Brown, Close-range camera calibration, Photogrammetric Engineering 37 (1971) 855.

        Parameters
        ----------
        ideal_px : (..., 2) array
            Where a lens without distortion puts the points, px.

        Returns
        -------
        (..., 2) array
            px.
        """
        if not self.distortion:
            return ideal_px
        principal = self._axes()[0]
        x, y = np.moveaxis((ideal_px - principal) / self.focal_px, -1, 0)
        k1, k2, p1, p2, k3 = (*self.distortion, 0.0, 0.0, 0.0, 0.0, 0.0)[:5]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        bent = [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y]
        return principal + self.focal_px * np.stack(bent, axis=-1)

    def without_distortion(self, picture_px: Array) -> Array:
        """Remove the distortion of the lens from (..., 2) px, by fixed-point iteration; the inverse of `with_distortion`."""
        ideal = np.asarray(picture_px, float)
        for _ in range(20 if self.distortion else 0):
            ideal = ideal + picture_px - self.with_distortion(ideal)
        return ideal

    def _axes(self) -> tuple[Array, Array, Array]:
        """Principal point, and the world's right and up as unit vectors in the picture."""
        s, c = np.sin(self.up_rad), np.cos(self.up_rad)
        principal = np.array(self.origin_px if self.principal_px is None else self.principal_px)
        return principal, np.array([c, s]), np.array([s, -c])


def on_cylinder(camera: Camera, picture_px: Array, radius_m: float) -> Array:
    """Points on the near side of an upright cylinder about the platform's origin, from the first frame.

        X = R sin psi,    Y = -R cos psi

    Parameters
    ----------
    camera : Camera
    picture_px : (..., 2) array
        In the first frame, px.
    radius_m : float
        R, m.

    Returns
    -------
    (..., 3) array
        m; NaN where a point is beside the cylinder.
    """
    depth = np.full(picture_px.shape[:-1], -radius_m)
    for _ in range(50):
        across = camera.place(picture_px, depth)[..., 0]
        inside = np.clip(1.0 - (across / radius_m) ** 2, 0.0, 1.0)
        depth = -radius_m * np.sqrt(inside)
    points = camera.place(picture_px, depth)
    points[np.abs(points[..., 0]) >= radius_m] = np.nan
    return points


def rotation(theta: Array) -> Array:
    """Rotation matrix of (theta_x, theta_y, theta_z): the rotation theta_z about the vertical first, then the tilt.

        R = exp([theta_x, theta_y, 0]) exp([0, 0, theta_z])

    In quaternions this is theta_z = 2 atan2(q_z, q_w).

    Parameters
    ----------
    theta : (..., 3) array
        rad.

    Returns
    -------
    (..., 3, 3) array
    """
    from scipy.spatial.transform import Rotation

    theta = np.asarray(theta, float)
    flat = theta.reshape(-1, 3)
    swing = Rotation.from_rotvec(flat * [1.0, 1.0, 0.0])
    twist = Rotation.from_rotvec(flat * [0.0, 0.0, 1.0])
    return (swing * twist).as_matrix().reshape(*theta.shape[:-1], 3, 3)


def angles(matrix: Array) -> Array:
    """(theta_x, theta_y, theta_z) of rotation matrices; the inverse of `rotation`.

    Parameters
    ----------
    matrix : (..., 3, 3) array

    Returns
    -------
    (..., 3) array
        rad; theta_z within half a turn.
    """
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(matrix.reshape(-1, 3, 3))
    _, _, z, w = turn.as_quat().T
    theta_z = 2.0 * np.arctan2(z, w)
    theta_z -= 2.0 * np.pi * np.round(theta_z / (2.0 * np.pi))
    swing = turn * Rotation.from_rotvec(np.outer(theta_z, [0.0, 0.0, 1.0])).inv()
    return np.column_stack([swing.as_rotvec()[:, :2], theta_z]).reshape(*matrix.shape[:-2], 3)
