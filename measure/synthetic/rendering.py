"""Ray casting from the camera to the platform's cylinder, compiled."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

SPECKLE, QUADRANT, DOT = 0, 1, 2


@njit(cache=True, nogil=True)
def cast(
    width: int,
    height: int,
    rays: int,
    view: NDArray,
    turn: NDArray,
    position: NDArray,
    body: NDArray,
    marks: NDArray,
    dots: NDArray,
) -> NDArray[np.float64]:
    """Mean albedo of every pixel, from rays x rays straight lines through it.

    Parameters
    ----------
    width, height : int
        px.
    rays : int
        Along each side of a pixel.
    view : (8,) array
        Size of a pixel (m), principal point (2, px), cosine and sine of up, the origin relative to the optical axis
        (2, m), 1 / distance (1/m).
    turn, position : (3, 3) and (3,) arrays
        Pose of the platform, m.
    body : (4,) array
        Radius and half height (m), albedo of the platform and of the background.
    marks : (n, 7) array
        Azimuth (rad), height, half size (m), kind, grain (m), first and last speckle.
    dots : (m, 2) array
        Speckles of all marks, from the centre of their mark, m.

    Returns
    -------
    (height, width) array
    """
    made = np.full((height, width), body[3])
    left, right, top, bottom = _bounds(view, turn, position, body, width, height)
    for row in range(top, bottom):
        for column in range(left, right):
            total = 0.0
            for i in range(rays):
                for j in range(rays):
                    x = column + (j + 0.5) / rays - 0.5
                    y = row + (i + 0.5) / rays - 0.5
                    total += _ray(x, y, view, turn, position, body, marks, dots)
            made[row, column] = total / rays**2
    return made


@njit(cache=True, nogil=True)
def _bounds(view: NDArray, turn: NDArray, position: NDArray, body: NDArray, width: int, height: int) -> tuple[int, int, int, int]:
    """Part of the picture that the platform can cover, from the eight corners of the box around it."""
    left, right, top, bottom = 1e9, -1e9, 1e9, -1e9
    for corner in range(8):
        bx = body[0] * (1 - 2 * (corner & 1))
        by = body[0] * (1 - (corner & 2))
        bz = body[1] * (1 - 2 * ((corner & 4) >> 2))
        wx = turn[0, 0] * bx + turn[0, 1] * by + turn[0, 2] * bz + position[0]
        wy = turn[1, 0] * bx + turn[1, 1] * by + turn[1, 2] * bz + position[1]
        wz = turn[2, 0] * bx + turn[2, 1] * by + turn[2, 2] * bz + position[2]
        scale = 1.0 / (1.0 + wy * view[7]) / view[0]
        across, above = (wx + view[5]) * scale, (wz + view[6]) * scale
        x, y = view[1] + across * view[3] + above * view[4], view[2] + across * view[4] - above * view[3]
        left, right, top, bottom = min(left, x), max(right, x), min(top, y), max(bottom, y)
    return max(int(left) - 1, 0), min(int(right) + 3, width), max(int(top) - 1, 0), min(int(bottom) + 3, height)


@njit(cache=True, nogil=True, fastmath=True)
def _ray(x: float, y: float, view: NDArray, turn: NDArray, position: NDArray, body: NDArray, marks: NDArray, dots: NDArray) -> float:
    """Albedo that the ray through (x, y) of the picture meets.

    The ray is (a (1 + Y/D) - X_0, Y, b (1 + Y/D) - Z_0); in the platform's frame it meets X^2 + Y^2 = R^2.
    """
    px, py = (x - view[1]) * view[0], (y - view[2]) * view[0]
    a, b = px * view[3] + py * view[4], px * view[4] - py * view[3]
    ox, oy, oz = a - view[5] - position[0], -position[1], b - view[6] - position[2]
    dx, dy, dz = a * view[7], 1.0, b * view[7]
    qx, qy, qz = _turned(turn, ox, oy, oz)
    ex, ey, ez = _turned(turn, dx, dy, dz)
    qa, qb, qc = ex * ex + ey * ey, qx * ex + qy * ey, qx * qx + qy * qy - body[0] * body[0]
    root = qb * qb - qa * qc
    if root <= 0.0:
        return body[3]
    s = (-qb - math.sqrt(root)) / qa
    hx, hy, hz = qx + s * ex, qy + s * ey, qz + s * ez
    if abs(hz) > body[1]:
        return body[3]
    facing = -(hx * turn[1, 0] + hy * turn[1, 1]) / body[0]
    return _surface(math.atan2(hx, -hy), hz, body, marks, dots) * (0.75 + 0.25 * facing)


@njit(cache=True, nogil=True, inline="always")
def _turned(turn: NDArray, x: float, y: float, z: float) -> tuple[float, float, float]:
    """R' v."""
    return (
        turn[0, 0] * x + turn[1, 0] * y + turn[2, 0] * z,
        turn[0, 1] * x + turn[1, 1] * y + turn[2, 1] * z,
        turn[0, 2] * x + turn[1, 2] * y + turn[2, 2] * z,
    )


@njit(cache=True, nogil=True, fastmath=True)
def _surface(psi: float, z: float, body: NDArray, marks: NDArray, dots: NDArray) -> float:
    """Albedo at azimuth psi and height z of the cylinder: that of the mark there, or the body's."""
    for m in range(len(marks)):
        turned = psi - marks[m, 0]
        turned -= 2.0 * math.pi * round(turned / (2.0 * math.pi))
        u, v, half = turned * body[0], z - marks[m, 1], marks[m, 2]
        if abs(u) > half or abs(v) > half:
            continue
        if marks[m, 3] == QUADRANT:
            return 0.85 if u * v > 0.0 else 0.12
        if marks[m, 3] == DOT:
            return 0.12 if u * u + v * v < 0.49 * half * half else 0.85
        return 0.85 - 0.73 * _speckled(u, v, marks[m, 4], dots, int(marks[m, 5]), int(marks[m, 6]))
    return body[2]


@njit(cache=True, nogil=True, fastmath=True)
def _speckled(u: float, v: float, grain: float, dots: NDArray, first: int, last: int) -> float:
    """How dark: the sum of bumps (1 - (r / 2 grain)^2)^3, at most one. A bump is half as dark at r = 0.9 grain."""
    dark = 0.0
    for n in range(first, last):
        du, dv = u - dots[n, 0], v - dots[n, 1]
        r2 = (du * du + dv * dv) / (4.0 * grain * grain)
        if r2 < 1.0:
            dark += (1.0 - r2) ** 3
    return min(dark, 1.0)
