"""Where a mark is to a pixel: zero-mean normalised cross-correlation (ZNCC) over a search window, with OpenCV."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]

_FLAT = 0.02
"""Share of the patch's variance below which a place counts as flat; there a correlation is a quotient of roundings."""

_ANGLES = tuple(float(angle) for angle in np.radians([-30.0, -20.0, -10.0, 10.0, 20.0, 30.0]))
"""Turns that are tried, rad: a patch is still known when it is turned by half a step more."""

_NEAR_PX = 4
"""Radius of the search at full resolution around what was found at half of it."""


@dataclass(frozen=True)
class Peak:
    """The best place in a search window.

    Attributes
    ----------
    x, y : int
        Centre of the patch there, px.
    zncc : float
        Correlation there, -1 to 1.
    second : float
        The best correlation at another place, at least half a patch away; where it comes close to `zncc` the place is
        ambiguous.
    """

    x: int
    y: int
    zncc: float
    second: float


def search(picture: NDArray, patch: NDArray, x: float, y: float, radius: int | None, mask: Mask | None = None) -> Peak | None:
    """Find a patch near (x, y), to the pixel.

        zncc = sum (f - mean f)(g - mean g) / sqrt(sum (f - mean f)^2 sum (g - mean g)^2)

    Parameters
    ----------
    picture : (rows, columns) array
        The current image.
    patch : (size, size) array
        What is searched for; size is odd.
    x, y : float
        Centre of the search, px.
    radius : int or None
        px around the centre; None searches the whole picture.
    mask : (size, size) array of bool, optional
        Pixels of the patch that count; all without it.

    Returns
    -------
    Peak or None
        None where the window holds no place for the patch.
    """
    half = len(patch) // 2
    rows, columns = picture.shape
    left, right, top, bottom = 0, columns, 0, rows
    if radius is not None:
        left, right = max(round(x) - radius - half, 0), min(round(x) + radius + half + 1, columns)
        top, bottom = max(round(y) - radius - half, 0), min(round(y) + radius + half + 1, rows)
    if right - left < len(patch) or bottom - top < len(patch):
        return None
    scores = correlation_map(picture[top:bottom, left:right], patch, mask)
    row, column = np.unravel_index(int(scores.argmax()), scores.shape)
    best = float(scores[row, column])
    away = max(half, 3)
    scores[max(row - away, 0) : row + away + 1, max(column - away, 0) : column + away + 1] = -1.0
    return Peak(int(column) + left + half, int(row) + top + half, best, float(scores.max()))


def search_turned(
    picture: NDArray, patch: NDArray, x: float, y: float, radius: int | None, mask: Mask | None = None
) -> tuple[Peak | None, float]:
    """Find a patch near (x, y) that has turned by up to 30 deg, in steps of 10 deg, by the pixels of its inscribed circle.

    The whole picture is searched at half its resolution first.

    Parameters
    ----------
    picture, patch, x, y, radius, mask
        As in `search`.

    Returns
    -------
    peak : Peak or None
        The best over all angles.
    angle : float
        That of the best, rad, positive from x to y.
    """
    turned = [_turned(patch, mask, angle) for angle in _ANGLES]
    if radius is not None:
        found = [search(picture, image, x, y, radius, circle) for image, circle in turned]
        return _best(found)
    coarse = _half(picture)
    rough, angle = _best([search(coarse, _half(image), 0, 0, None, _half(circle.astype(np.float32)) >= 0.5) for image, circle in turned])
    if rough is None:
        return None, 0.0
    image, circle = turned[_ANGLES.index(angle)]
    fine = search(picture, image, 2.0 * rough.x, 2.0 * rough.y, _NEAR_PX, circle)
    return (None if fine is None else Peak(fine.x, fine.y, fine.zncc, rough.second)), angle


def _best(found: list[Peak | None]) -> tuple[Peak | None, float]:
    scored = [(peak.zncc, angle, peak) for peak, angle in zip(found, _ANGLES, strict=True) if peak is not None]
    _, angle, peak = max(scored, key=lambda one: one[0], default=(0.0, 0.0, None))
    return peak, angle


def _turned(patch: NDArray, mask: Mask | None, angle: float) -> tuple[NDArray, Mask]:
    """A patch turned about its middle, and which of its pixels are known: those of the circle, and of the mask turned likewise."""
    size = len(patch)
    middle = size // 2
    y, x = np.mgrid[:size, :size] - middle
    known = np.hypot(x, y) <= middle
    matrix = cv2.getRotationMatrix2D((middle, middle), -np.degrees(angle), 1.0)
    image = cv2.warpAffine(patch.astype(np.float32), matrix, (size, size), borderMode=cv2.BORDER_REPLICATE)
    if mask is not None:
        known &= cv2.warpAffine(mask.astype(np.float32), matrix, (size, size)) >= 0.5
    return image, known


def _half(image: NDArray) -> NDArray:
    """A picture at half its resolution, of an odd side where it is a patch."""
    small = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    square = small.shape[0] == small.shape[1] and not small.shape[0] % 2
    return np.ascontiguousarray(small[:-1, :-1] if square else small)


def correlation_map(window: NDArray, patch: NDArray, mask: Mask | None = None) -> NDArray[np.float32]:
    """ZNCC of a patch at every place of a window where it fits; -1 where the window is flat.

    Parameters
    ----------
    window : (rows, columns) array
    patch : (size, size) array
    mask : (size, size) array of bool, optional

    Returns
    -------
    (rows - size + 1, columns - size + 1) array of float32
    """
    if window.dtype != np.uint8 or mask is not None:
        window, patch = window.astype(np.float32), patch.astype(np.float32)
    if mask is None:
        scores = cv2.matchTemplate(window, patch, cv2.TM_CCOEFF_NORMED)
        variance = _variance(window, len(patch))
    else:
        scores = cv2.matchTemplate(window, patch, cv2.TM_CCOEFF_NORMED, mask=mask.astype(np.float32))
        variance, patch = _variance_under(window, mask), patch[mask]
    flat = variance < _FLAT * float(patch.astype(np.float64).var())
    return np.where(flat | ~np.isfinite(scores), np.float32(-1.0), scores)


def _variance(window: NDArray, size: int) -> NDArray[np.float64]:
    """Variance of the grey values under a square of `size` px at every place where it fits."""
    sums, squares = cv2.integral2(window, sdepth=cv2.CV_64F, sqdepth=cv2.CV_64F)

    def inside(total: NDArray) -> NDArray:
        return (total[size:, size:] - total[:-size, size:] - total[size:, :-size] + total[:-size, :-size]) / size**2

    return inside(squares) - inside(sums) ** 2


def _variance_under(window: NDArray, mask: Mask) -> NDArray[np.float64]:
    """Variance of the grey values under a mask at every place where it fits."""
    weights, values = mask / mask.sum(), window.astype(np.float64)
    rows, columns = (n - size + 1 for n, size in zip(window.shape, mask.shape, strict=True))
    mean, square = (cv2.filter2D(image, cv2.CV_64F, weights, anchor=(0, 0))[:rows, :columns] for image in (values, values**2))
    return np.asarray(square - mean**2, dtype=np.float64)


def is_unique(picture: NDArray, patch: NDArray, distinct: float, mask: Mask | None = None) -> bool:
    """Whether the picture shows a patch that was taken from it at one place only, judged at half the resolution.

    Parameters
    ----------
    picture : (rows, columns) array
    patch : (size, size) array
    distinct : float
        Correlation from which another place looks like it.
    mask : (size, size) array of bool, optional

    Returns
    -------
    bool
    """
    half = [cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for image in (picture, patch)]
    coarse = None if mask is None else cv2.resize(mask.astype(np.float32), half[1].shape[::-1], interpolation=cv2.INTER_AREA) >= 0.5
    peak = search(half[0], np.ascontiguousarray(half[1]), 0, 0, None, coarse)
    return peak is not None and peak.second < distinct
