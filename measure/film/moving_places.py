"""Where a film moves: places whose texture leaves them, so that marks are not put on what stands still.

A pixel of the moving body in the first frame looks different in nearly all frames after the motion began. A pixel of the
background does so only while the body passes over it. The share of frames in which a pixel differs from the first one
therefore says what it belongs to.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from measure.correlation.texture import pixel_noise
from measure.footage.footage import Footage, Picture

_SAMPLES = 24
"""Frames that are compared with the first one."""

_FINE_PX = 1.0
"""Blur under which pictures are compared."""

_OVER_NOISE = 5.0
"""Standard deviations of the difference from which a pixel has changed."""

_SHAKE_PX = 0.25
"""Motion of a still edge that counts as shake of the camera."""

_BESIDE_PX = 2
"""Distance up to which a pixel beside one that changes belongs to the same edge."""

_FEWEST_CHANGED = 30
"""Changed pixels from which a frame shows motion."""

_PURE, _COVERED = 0.8, 0.5
"""Shares of a subset's texture, and of its area, that must move for the subset to belong to the body."""

_SMALLER = (23, 15)
"""Subsets tried where the body is too small for the usual one, px."""

_ENOUGH = 3
"""Marks that give position and rotation with one to spare."""

_BLURRED_NOISE = 1.0 / (2.0 * np.sqrt(np.pi) * _FINE_PX)
_BLURRED_SLOPE = 1.0 / (8.0 * np.pi * _FINE_PX**4)
"""What the fine blur leaves of white noise: of its standard deviation, and of the variance of its slopes."""


@dataclass(frozen=True)
class Motion:
    """What moves in a film.

    Attributes
    ----------
    first : (height, width) array
        The first frame.
    share : (height, width) array of float32
        Share of the frames since the motion began in which a pixel differs from the first frame.
    """

    first: Picture
    share: NDArray[np.float32]

    @property
    def anything(self) -> bool:
        """Whether anything moves."""
        return bool((self.share > 0.0).any())


def find_motion(footage: Footage) -> Motion:
    """Compare up to 24 frames of a film with its first one.

    The frames stand closer together at the beginning, where the body has not yet left its place by far.

    Parameters
    ----------
    footage : Footage

    Returns
    -------
    Motion
    """
    wanted = set(np.rint(np.linspace(0.0, 1.0, _SAMPLES + 1) ** 2 * (max(footage.frames, 2) - 1)).astype(int).tolist())
    compared: list[NDArray[np.bool_]] = []
    first, before = None, None
    for frame, picture in footage.pictures():
        if first is None or before is None:
            first, before = picture, _Before(picture)
        elif frame in wanted:
            compared.append(before.changed(picture))
    assert first is not None
    return Motion(first, _share(compared, first.shape))


def _share(compared: list[NDArray[np.bool_]], shape: tuple[int, ...]) -> NDArray[np.float32]:
    began = next((k for k, changed in enumerate(compared) if changed.sum() >= _FEWEST_CHANGED), None)
    if began is None:
        return np.zeros(shape, np.float32)
    share = np.mean(compared[began:], axis=0, dtype=np.float32)
    return cv2.dilate(share, np.ones((2 * _BESIDE_PX + 1,) * 2, np.uint8))  # type: ignore[return-value]


class _Before:
    """The first frame, prepared to be compared with others."""

    def __init__(self, picture: Picture) -> None:
        self.fine = _blurred(picture)
        self.noise = pixel_noise(picture) * _BLURRED_NOISE * np.sqrt(2.0)
        steepest = cv2.dilate(np.hypot(*_slopes(self.fine)), np.ones((3, 3), np.uint8))
        self.shaken = _SHAKE_PX * steepest

    def changed(self, picture: Picture) -> NDArray[np.bool_]:
        """Which pixels differ by more than noise, a change of light, and a shake of the camera."""
        fine = _blurred(picture)
        difference = np.abs(fine - _lit(self.fine, fine))
        noise = min(max(1.4826 * float(np.median(difference)), 0.5 * self.noise), 2.0 * self.noise)
        found = difference > _OVER_NOISE * noise + self.shaken
        return cv2.morphologyEx(found.astype(np.uint8), cv2.MORPH_OPEN, np.ones((2, 2), np.uint8)).astype(bool)


def _blurred(picture: Picture) -> NDArray[np.float32]:
    return cv2.GaussianBlur(picture.astype(np.float32), (0, 0), _FINE_PX)  # type: ignore[return-value]


def _lit(before: NDArray[np.float32], now: NDArray[np.float32]) -> NDArray[np.float32]:
    """The first frame in the light of another one: times the gain that most pixels agree on."""
    f, g = before[::3, ::3].ravel(), now[::3, ::3].ravel()
    near = np.ones(len(f), bool)
    gain = 1.0
    for _ in range(4):
        gain = float(f[near] @ g[near]) / max(float(f[near] @ f[near]), 1e-9)
        off = np.abs(g - gain * f)
        near = off <= 3.0 * np.median(off) + 1e-3
    return np.float32(gain) * before


def _slopes(image: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    return tuple(cv2.Scharr(image, cv2.CV_32F, dx, 1 - dx, scale=1 / 32) for dx in (1, 0))  # type: ignore[return-value]


def places_that_move(motion: Motion, subset: int, most: int, fixed: bool) -> tuple[list[tuple[float, float]], int]:
    """Find places whose texture moves and can be tracked best.

    Parameters
    ----------
    motion : Motion
    subset : int
        Side of the subset, px.
    most : int
        Number of places at most.
    fixed : bool
        Whether the subset must have that side. Otherwise a smaller one is taken where the moving body is too small for it.

    Returns
    -------
    places : list of (x, y)
        px, best first; none where nothing moves.
    subset : int
        Side of the subset that serves them.
    """
    if not motion.anything:
        return [], subset
    weight = motion.share**2
    found, size = _best_places(motion, weight, subset, most), subset
    for smaller in () if fixed else _SMALLER:
        if smaller < size and sum(pure for *_, pure in found) < _ENOUGH:
            other = _best_places(motion, weight, smaller, most)
            if sum(pure for *_, pure in other) > sum(pure for *_, pure in found):
                found, size = other, smaller
    if any(pure for *_, pure in found):
        found = [place for place in found if place[2]]
    return [(x, y) for x, y, _ in found], size


def places_with_texture(picture: Picture, subset: int, most: int) -> list[tuple[float, float]]:
    """Find places whose texture can be tracked best, whether it moves or not; the arguments are those of `places_that_move`."""
    still = Motion(picture, np.ones(picture.shape, np.float32))
    return [(x, y) for x, y, _ in _best_places(still, still.share, subset, most)]


def _best_places(motion: Motion, weight: NDArray[np.float32], subset: int, most: int) -> list[tuple[float, float, bool]]:
    """Places where the weaker of the two directions still has strong slopes, best first, and whether all of that moves.

    The score is the smaller eigenvalue of the slopes' matrix summed over the subset (Shi and Tomasi, Good features to
    track, IEEE Conference on Computer Vision and Pattern Recognition, 1994, 593), each pixel weighted by how surely it
    moves, times the shares of the texture and of the area that move. Places are at least a subset apart, and none
    scores below a tenth of the best.
    """
    score, belongs = _score(motion, weight, subset)
    half = subset // 2 + 8
    inner = np.zeros_like(score)
    inner[half:-half, half:-half] = score[half:-half, half:-half]
    best = float(inner.max())
    found: list[tuple[float, float, bool]] = []
    while len(found) < most and inner.max() > 0.1 * best > 0:
        row, column = np.unravel_index(int(inner.argmax()), inner.shape)
        found.append((float(column), float(row), bool(belongs[row, column])))
        inner[max(row - subset, 0) : row + subset + 1, max(column - subset, 0) : column + subset + 1] = 0.0
    return found


def _score(motion: Motion, weight: NDArray[np.float32], subset: int) -> tuple[NDArray[np.floating], NDArray[np.bool_]]:
    """At every place, how well its moving texture can be tracked, and whether the subset belongs to what moves."""
    fine = cv2.GaussianBlur(motion.first.astype(np.float32), (0, 0), _FINE_PX)
    fx, fy = _slopes(fine)  # type: ignore[arg-type]

    def summed(image: NDArray[np.float32]) -> NDArray[np.float32]:
        return cv2.boxFilter(image, cv2.CV_32F, (subset, subset), normalize=False)  # type: ignore[return-value]

    xx, xy, yy = summed(weight * fx * fx), summed(weight * fx * fy), summed(weight * fy * fy)
    smaller = 0.5 * (xx + yy) - np.hypot(0.5 * (xx - yy), xy)
    slopes_of_noise = 2.0 * _BLURRED_SLOPE * pixel_noise(motion.first) ** 2
    texture = np.maximum(fx * fx + fy * fy - np.float32(2.0 * slopes_of_noise), 0.0)
    moving = summed(weight * texture) / np.maximum(summed(texture), 1e-6)
    covered = summed(weight) / np.float32(subset**2)
    return smaller * moving**2 * covered, (moving >= _PURE) & (covered >= _COVERED)
