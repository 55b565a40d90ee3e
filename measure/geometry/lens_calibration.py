"""The lens from pictures of a checkerboard: focal length, optical axis and distortion, with their uncertainty.

Zhang, A flexible new technique for camera calibration, IEEE Transactions on Pattern Analysis and Machine Intelligence 22
(2000) 1330; as in OpenCV.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.footage.footage import Footage, Picture

_FEWEST_VIEWS = 5
_LARGEST_RMS_PX = 1.0


@dataclass(frozen=True)
class Lens:
    """A calibrated lens.

    Attributes
    ----------
    focal_px, focal_sigma_px : float
        Focal length and its standard deviation, px.
    principal_px : (x, y)
        Where the optical axis meets the picture, px.
    distortion : (k1, k2, p1, p2)
    rms_px : float
        Root mean square residual of the corners, px.
    views, pictures : int
        Pictures in which the board was found, and all pictures.
    """

    focal_px: float
    focal_sigma_px: float
    principal_px: tuple[float, float]
    distortion: tuple[float, float, float, float]
    rms_px: float
    views: int
    pictures: int


def calibrate(film: Footage, columns: int, rows: int, pitch_mm: float) -> Lens:
    """Calibrate a lens from pictures of a checkerboard held at different slants; pixels are square and k3 is zero.

    Parameters
    ----------
    film : Footage
        The pictures, such as a folder of them.
    columns, rows : int
        Inner corners across and down.
    pitch_mm : float
        Side of a square, mm.

    Returns
    -------
    Lens

    Raises
    ------
    InputError
        The board is found in fewer than five pictures, or its corners do not fit a lens to a pixel.
    """
    if columns < 3 or rows < 3 or not pitch_mm > 0:
        raise InputError(
            f"--board {columns},{rows},{pitch_mm:g}: give inner corners across and down, three at least, and the squares' side in mm."
        )
    found = [corners for _, picture in film.pictures() if (corners := _corners(picture, columns, rows)) is not None]
    if len(found) < _FEWEST_VIEWS:
        raise InputError(
            f"{film.name}: a board of {columns} x {rows} inner corners is found in {len(found)} of {film.frames} pictures; "
            f"{_FEWEST_VIEWS} are needed. Check --board, and hold the board at different slants, whole in the picture."
        )
    lens = _fitted(found, columns, rows, pitch_mm, (film.width, film.height), film.frames)
    if not lens.rms_px < _LARGEST_RMS_PX:
        raise InputError(
            f"{film.name}: the corners miss a lens by {lens.rms_px:.2f} px. Use a flat board and sharp pictures of one camera setting."
        )
    return lens


def _corners(picture: Picture, columns: int, rows: int) -> NDArray[np.float32] | None:
    top = max(float(np.percentile(picture, 99.9)), 1.0)
    grey = np.clip(picture * (255.0 / top), 0, 255).astype(np.uint8)
    found, corners = cv2.findChessboardCornersSB(grey, (columns, rows), flags=cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE)
    return _sharpened(grey, corners.astype(np.float32), columns) if found else None


def _sharpened(grey: NDArray[np.uint8], corners: NDArray[np.float32], columns: int) -> NDArray[np.float32]:
    """Corners refined by the slopes around them; those of the search err by 0.2 px on exact pictures."""
    places = corners.reshape(-1, columns, 2)
    closest = min(float(np.linalg.norm(np.diff(places, axis=axis), axis=-1).min()) for axis in (0, 1))
    reach = max(round(0.3 * closest), 2)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-4)
    return cv2.cornerSubPix(grey, corners, (reach, reach), (-1, -1), stop).astype(np.float32)


def _fitted(found: list[NDArray], columns: int, rows: int, pitch_mm: float, size: tuple[int, int], pictures: int) -> Lens:
    board = np.zeros((columns * rows, 3), np.float32)
    board[:, :2] = np.mgrid[:columns, :rows].T.reshape(-1, 2) * pitch_mm
    start = np.array([[max(size), 0, (size[0] - 1) / 2], [0, max(size), (size[1] - 1) / 2], [0, 0, 1]], float)
    flags = cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_FIX_K3 | cv2.CALIB_USE_INTRINSIC_GUESS
    rms, matrix, distortion, _, _, spread, _, _ = cv2.calibrateCameraExtended(
        [board] * len(found), found, size, start, np.zeros(5), flags=flags
    )
    k1, k2, p1, p2 = (float(value) for value in np.ravel(distortion)[:4])
    axis = (float(matrix[0, 2]), float(matrix[1, 2]))
    sigma = max(float(value) for value in np.ravel(spread)[:2])
    if not math.isfinite(float(rms) + sigma):
        raise InputError("the pictures of the checkerboard do not determine the lens. Hold the board at different slants.")
    return Lens(float(matrix[0, 0]), sigma, axis, (k1, k2, p1, p2), float(rms), len(found), pictures)
