"""Marks through a film: predict, refine, and search where the prediction does not hold."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.curved_marks import responses
from measure.correlation.marks import (
    AMBIGUOUS,
    LOST,
    MISSING,
    OCCLUDED,
    OK,
    OUT,
    Marks,
    Sighting,
    gather,
    unseen,
)
from measure.correlation.reference_image import AFFINE, Reference, blurred, reference
from measure.correlation.refinement import ALIKE, MOST_HIDDEN, Match, Usual, recognise
from measure.correlation.rest_frames import still_frames
from measure.correlation.template_matching import Peak, is_unique, search
from measure.footage.footage import Footage, Picture

_SEARCH_PX = (8, 32, None)
"""Radii of the search around the predicted place, tried in turn; None is the whole picture."""

_LEAST_BLUR_PX = 0.75
"""Motion during the exposure that still looks like rest."""

_FAINT = 0.3
"""Correlation below which nothing of the mark is left at a place."""

_BLUR_STEP_PX = 0.25
_DISTINCT = 0.93
_OCCLUDED_FRAMES = 30
_COAST_FRAMES = 10
_WHOLE_PICTURE_EVERY = 5


@dataclass
class Follower:
    """One mark on its way through the film: what it looks like, where it was, how noisy its pictures are.

    open_share : exposure over the time from frame to frame.
    """

    mark: Reference
    patch: NDArray
    warp: NDArray[np.float64]
    unique: bool
    open_share: float = 0.0
    places: list[tuple[int, NDArray[np.float64]]] = field(default_factory=list)
    noise: float = 0.0
    unexplained: float = 0.0
    hidden: float = 0.0
    altered: bool = False
    missed: int = 0
    last: str = OK
    moving: tuple[NDArray, Reference] | None = None

    def predicted(self, frame: int) -> NDArray[np.float64]:
        """The last warp carried on: at constant acceleration, x = 3 x1 - 3 x2 + x3, or at constant speed while the mark is hidden."""
        guess = self.warp.copy()
        if len(self.places) < 2:
            return guess
        (f2, p2), (f1, p1) = self.places[-2:]
        ahead = (p1 - p2) / (f1 - f2) * min(frame - f1, _COAST_FRAMES)
        if len(self.places) == 3 and frame - self.places[0][0] == 3:
            ahead = 2 * p1 - 3 * p2 + self.places[0][1]
        guess[[2, 5]] += ahead
        return guess

    def look(self, picture: Picture, frame: int) -> Sighting:
        """Find the mark in a picture, or say what became of it."""
        guess = self.predicted(frame)
        match = self._fits(picture, guess) if self.missed < _COAST_FRAMES else None
        status = OCCLUDED if self.missed and self.last == OCCLUDED else LOST
        for radius in _SEARCH_PX if match is None else ():
            if radius is None and self.missed % _WHOLE_PICTURE_EVERY:
                break
            match, status = self._searched(picture, guess, radius, status)
            if match is not None:
                break
        if match is not None and match.hidden > MOST_HIDDEN:
            match, status = None, OCCLUDED
        if match is None:
            self.missed += 1
            self.last = OUT if self.last == OUT else self._left(picture, guess, status)
            return unseen(self.last)
        return self._accepted(picture, frame, match)

    def _searched(self, picture: Picture, guess: NDArray, radius: int | None, status: str) -> tuple[Match | None, str]:
        """Search around the guess and refine there; a place that does not stand out, or is too much covered, is no match."""
        peak = search(picture, self.patch, guess[2], guess[5], radius, self.mark.shape)
        if peak is None or peak.zncc < _FAINT:
            return None, status
        if peak.second > _DISTINCT * peak.zncc and (radius is None or self.missed):
            return None, AMBIGUOUS if status != OCCLUDED and peak.zncc > ALIKE else status
        start = self.warp.copy()
        start[[2, 5]] = self._from_peak(peak)
        match = self._fits(picture, start)
        if match is None and radius == _SEARCH_PX[0]:
            return None, OCCLUDED if self.missed < _OCCLUDED_FRAMES else LOST
        if match is not None and radius is None and not self.unique:
            return None, AMBIGUOUS
        return match, status

    def _from_peak(self, peak: Peak) -> NDArray[np.float64]:
        """The patch was cut around the whole pixel nearest to the subset's centre; put the centre back."""
        return np.array([peak.x, peak.y]) + self.warp[[2, 5]] - np.rint(self.warp[[2, 5]])

    def _fits(self, picture: Picture, guess: NDArray) -> Match | None:
        """The mark near a guess, blurred as its speed has it; once more where the place found means another speed."""
        usual = Usual(self.noise, self.unexplained, self.hidden, self.altered, self.missed > 0)
        mark = self._as_moving(guess)
        match = recognise(picture, mark, guess, usual)
        if match is None or self._as_moving(match.warp) is mark:
            return match
        closer = recognise(picture, self._as_moving(match.warp), match.warp, usual)
        return closer if closer is not None and closer.unexplained < match.unexplained else match

    def _speed(self, warp: NDArray) -> NDArray[np.float64]:
        """Motion per frame at the instant of the picture: that since the last frame, and half of its change."""
        if self.missed or len(self.places) < 2:
            return np.zeros(2)
        ahead, before = warp[[2, 5]] - self.places[-1][1], self.places[-1][1] - self.places[-2][1]
        return 1.5 * ahead - 0.5 * before

    def _as_moving(self, warp: NDArray) -> Reference:
        """The reference blurred by the motion to `warp` during the exposure, in small steps; kept while it serves."""
        if self.open_share == 0.0:
            return self.mark
        steps = np.rint(self._speed(warp) * self.open_share / _BLUR_STEP_PX)
        if np.hypot(*steps) * _BLUR_STEP_PX < _LEAST_BLUR_PX:
            return self.mark
        if self.moving is None or not np.array_equal(self.moving[0], steps):
            self.moving = (steps, blurred(self.mark, steps * _BLUR_STEP_PX))
        return self.moving[1]

    def _accepted(self, picture: Picture, frame: int, match: Match) -> Sighting:
        self.missed, self.last, self.hidden = 0, OK, match.hidden
        self.warp = match.warp
        point = self.mark.point(match.warp)
        self.places = [*self.places[-2:], (frame, match.warp[[2, 5]])]
        if match.hidden == 0.0 and frame > 0:
            self.altered |= match.altered
            share = 0.3 if self.noise == 0.0 else 0.1
            self.noise += share * (match.noise - self.noise)
            self.unexplained += share * (match.unexplained - self.unexplained)
        cut = _cut(picture, match.warp, self.mark.half)
        if cut is not None and match.hidden < 0.02:
            self.patch = cut
        return Sighting(float(point[0]), float(point[1]), match.covariance, match.zncc, match.noise, match.hidden, OK)

    def _left(self, picture: Picture, guess: NDArray, status: str) -> str:
        """Whether the prediction, carried on while the mark was not seen, has left the picture."""
        rows, columns = picture.shape
        half = self.mark.half
        inside = half - 1 <= guess[2] <= columns - half and half - 1 <= guess[5] <= rows - half
        return status if inside else OUT


def _cut(picture: Picture, warp: NDArray, half: int) -> NDArray | None:
    """The subset as it looks now, for the next search: its present turn and stretch included."""
    column, row = round(warp[2]), round(warp[5])
    patch = picture[max(row - half, 0) : row + half + 1, max(column - half, 0) : column + half + 1]
    return patch.copy() if patch.shape == (2 * half + 1, 2 * half + 1) else None


def follower(
    picture: Picture,
    x: float,
    y: float,
    subset: int,
    warp: int = AFFINE,
    open_share: float = 0.0,
    mean: NDArray | None = None,
    mask: NDArray[np.bool_] | None = None,
    alone: bool = False,
) -> Follower:
    """Prepare to follow the mark at (x, y) of the reference image: `picture`, or the mean of several like it.

    alone : nothing else looks like it, so that the whole picture need not be searched for its like.
    """
    mark = reference(picture if mean is None else mean, x, y, subset, warp, mask)
    patch = _cut(picture, mark.start, mark.half)
    assert patch is not None
    return Follower(mark, patch, mark.start, alone or is_unique(picture, patch, x, y, _DISTINCT, mark.shape), open_share)


def check_subset(subset: int) -> None:
    """Refuse a subset size that has no centre pixel or no room for texture."""
    if subset % 2 == 0 or not 9 <= subset <= 301:
        raise InputError(f"--subset {subset}: a subset has a centre pixel; give an odd number from 9 to 301.")


def follow(
    footage: Footage,
    places: Sequence[tuple[float, float]],
    fps: float,
    subset: int = 31,
    warp: int = AFFINE,
    exposure_s: float = 0.0,
    names: Sequence[str] = (),
    watch: Callable[[Iterator], Iterator] = iter,
    mask: NDArray[np.bool_] | None = None,
) -> Marks:
    """Follow marks through a film.

    places : reference points in the first frame, px. fps : capture rate. warp : the richest warp a mark may have.
    exposure_s : time over which a picture is collected; a fast mark is blurred by it. watch : wraps the stream of
    frames, for a progress bar. mask : (rows, columns), pixels of the first frame that belong to marks.
    Frames that the film lacks are rows with status `missing`.

    Raises
    ------
    InputError
        A mark without texture or too near the border, no frames.
    """
    check_subset(subset)
    frames = watch(footage.pictures())

    def prepare(picture: Picture, mean: NDArray | None = None, alone: bool = False) -> list[Follower]:
        return [follower(picture, x, y, subset, warp, exposure_s * fps, mean, mask, alone) for x, y in places]

    read, mean = still_frames(frames, lambda picture: prepare(picture, alone=True))
    followers = prepare(read[0][1], mean) if read else []
    rows: list[list[Sighting]] = []
    for frame, picture in chain(read, frames):
        while len(rows) < frame:
            rows.append([unseen(MISSING) for _ in followers])
        rows.append([mark.look(picture, frame) for mark in followers])
    if len(rows) < 2:
        raise InputError(f"{footage.name}: {len(rows)} frames could be read; a motion needs two at least. Copy the film again.")
    names = list(names) or [f"m{i + 1}" for i in range(len(places))]
    return gather(np.arange(len(rows)) / fps, names, responses([mark.mark for mark in followers]), rows)
