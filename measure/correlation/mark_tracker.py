"""One mark through a film: predict its position, refine it, and search where the prediction does not hold."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from measure.correlation.criteria import DISTINCT, HARDLY_HIDDEN, LEAST_BLUR_PX, LEAST_ZNCC, MOST_HIDDEN, NOTHING_LEFT
from measure.correlation.marks import AMBIGUOUS, LOST, OCCLUDED, OK, OUT, Observation, not_observed
from measure.correlation.reference import Reference
from measure.correlation.reference_image import blurred
from measure.correlation.refinement import Expected, Match, recognise
from measure.correlation.template_matching import Peak, search, search_turned
from measure.footage.footage import Picture

_SEARCH_PX = (8, 32, None)
"""Radii of the search around the predicted position, tried in turn; None is the whole picture."""

_NARROWER, _CLEARER = 0.06, 0.8
"""Step by which a mark is made narrower, and what it must leave of the covered share."""

_BLUR_STEP_PX = 0.25
_OCCLUDED_FRAMES = 30
_COAST_FRAMES = 10
_WHOLE_PICTURE_AT_FIRST, _WHOLE_PICTURE_EVERY = 3, 5
"""Frames without a position in all of which the whole picture is searched, and then in one of how many."""


@dataclass
class MarkTracker:
    """One mark on its way through the film.

    Attributes
    ----------
    mark : Reference
        From the reference image.
    patch : (size, size) array
        The subset as it was last observed, for the search.
    warp : (6,) array
        The last warp found.
    unique : bool
        Whether nothing else in the picture looks like it.
    open_share : float
        Exposure time over the time from frame to frame.
    places : list of (int, (2,) array)
        The last three frames with a position, and the centre of the subset there, px.
    expected : Expected
        Noise, residual and light of the frames before.
    missed : int
        Frames since the mark was last observed.
    last : str
        Status in the last frame.
    moving : (steps, Reference) or None
        The reference blurred by the motion during the exposure, while it serves.
    """

    mark: Reference
    patch: NDArray
    warp: NDArray[np.float64]
    unique: bool
    open_share: float = 0.0
    places: list[tuple[int, NDArray[np.float64]]] = field(default_factory=list)
    expected: Expected = field(default_factory=Expected)
    missed: int = 0
    last: str = OK
    moving: tuple[NDArray, Reference] | None = None

    def predicted(self, frame: int) -> NDArray[np.float64]:
        """Extrapolate the last warp to a frame.

        At constant acceleration, x = 3 x1 - 3 x2 + x3, or at constant velocity while the mark is not observed.

        Parameters
        ----------
        frame : int

        Returns
        -------
        (6,) array
        """
        guess = self.warp.copy()
        if len(self.places) < 2:
            return guess
        (f2, p2), (f1, p1) = self.places[-2:]
        ahead = (p1 - p2) / (f1 - f2) * min(frame - f1, _COAST_FRAMES)
        if len(self.places) == 3 and frame - self.places[0][0] == 3:
            ahead = 2 * p1 - 3 * p2 + self.places[0][1]
        guess[[2, 5]] += ahead
        return guess

    def observe(self, picture: Picture, frame: int) -> Observation:
        """Find the mark in the next picture.

        Parameters
        ----------
        picture : (rows, columns) array
        frame : int
            Number of the frame; larger than that of the call before.

        Returns
        -------
        Observation
            With a position, or with the reason why there is none.
        """
        guess = self.predicted(frame)
        match = self._refined(picture, guess) if self.missed < _COAST_FRAMES else None
        status = OCCLUDED if self.missed and self.last == OCCLUDED else LOST
        for radius in _SEARCH_PX if match is None else ():
            if radius is None and self.missed >= _WHOLE_PICTURE_AT_FIRST and self.missed % _WHOLE_PICTURE_EVERY:
                break
            match, status = self._searched(picture, guess, radius, status)
            if match is not None:
                break
        if match is None and self.mark.turns and not (self.missed and self.missed % _WHOLE_PICTURE_EVERY):
            match = self._turned(picture, guess)
        match = self._compressed(picture, guess, match)
        if match is not None and match.hidden > MOST_HIDDEN:
            match, status = None, OCCLUDED
        if match is None:
            self.missed += 1
            self.last = OUT if self.last == OUT else self._left(picture, guess, status)
            return not_observed(self.last)
        return self._accepted(picture, frame, match)

    def missed_again(self) -> Observation:
        """One frame more without a position, for the reason of the last one."""
        self.missed += 1
        return not_observed(self.last)

    def _searched(self, picture: Picture, guess: NDArray, radius: int | None, status: str) -> tuple[Match | None, str]:
        """Search around the guess and refine there; a place that does not stand out, or is too much covered, is no match."""
        peak = search(picture, self.patch, guess[2], guess[5], radius, self.mark.shape)
        if peak is None or peak.zncc < NOTHING_LEFT:
            return None, status
        if peak.second > DISTINCT * peak.zncc and (radius is None or self.missed):
            return None, AMBIGUOUS if status != OCCLUDED and peak.zncc > LEAST_ZNCC else status
        start = self.warp.copy()
        start[[2, 5]] = self._from_peak(peak)
        match = self._refined(picture, start)
        if match is None and radius == _SEARCH_PX[0]:
            return None, OCCLUDED if self.missed < _OCCLUDED_FRAMES else LOST
        if match is not None and radius is None and not self.unique:
            return None, AMBIGUOUS
        return match, status

    def _compressed(self, picture: Picture, guess: NDArray, match: Match | None) -> Match | None:
        """The mark a little narrower along what its texture does not fix, where that explains the picture better.

        Quadrants on a drum that turns away get narrower, and what is beside them enters the subset; their edges do not
        say so.
        """
        if self.missed or (match is not None and match.hidden <= HARDLY_HIDDEN):
            return match
        start = guess if match is None else match.warp
        for direction in self.mark.loose:
            narrower = start.copy().reshape(2, 3)
            narrower[:, :2] = narrower[:, :2] @ (np.eye(2) - _NARROWER * direction)
            other = recognise(picture, self.mark, narrower.ravel(), self.expected)
            if other is not None and (match is None or other.hidden < _CLEARER * match.hidden):
                match = other
        return match

    def _turned(self, picture: Picture, guess: NDArray) -> Match | None:
        """Search for the mark as it looks when it has turned: around the guess, and where nothing else looks like it, everywhere."""
        for radius in (_SEARCH_PX[1], None) if self.unique else (_SEARCH_PX[0],):
            peak, angle = search_turned(picture, self.patch, guess[2], guess[5], radius, self.mark.shape)
            if peak is None or peak.zncc < NOTHING_LEFT or peak.second > DISTINCT * peak.zncc:
                continue
            c, s = np.cos(angle), np.sin(angle)
            matrix = np.array([[c, -s], [s, c]]) @ self.warp.reshape(2, 3)[:, :2]
            x, y = self._from_peak(peak)
            start = np.array([*matrix[0], x, *matrix[1], y])
            match = recognise(picture, self.mark, start, self.expected.after(True))
            if match is not None:
                return match
        return None

    def look_at(self, picture: Picture, frame: int, place: NDArray[np.float64]) -> Observation | None:
        """Look for a mark that is lost where the other marks say that it should be.

        Parameters
        ----------
        picture : (rows, columns) array
        frame : int
            The frame that `observe` has just found nothing in.
        place : (2,) array
            Where its reference point should be, px.

        Returns
        -------
        Observation or None
            None where it is not there.
        """
        guess = self.warp.copy()
        guess[[2, 5]] = place - guess.reshape(2, 3)[:, :2] @ self.mark.subset.offset
        for radius in _SEARCH_PX[:2]:
            peak = search(picture, self.patch, guess[2], guess[5], radius, self.mark.shape)
            if peak is None or peak.zncc < NOTHING_LEFT or peak.second > DISTINCT * peak.zncc:
                continue
            start = guess.copy()
            start[[2, 5]] = self._from_peak(peak)
            match = recognise(picture, self.mark, start, self.expected.after(True))
            if match is not None and match.hidden <= MOST_HIDDEN:
                return self._accepted(picture, frame, match)
        return None

    def _from_peak(self, peak: Peak) -> NDArray[np.float64]:
        """The patch was cut around the whole pixel nearest to the subset's centre; put the centre back."""
        return np.array([peak.x, peak.y]) + self.warp[[2, 5]] - np.rint(self.warp[[2, 5]])

    def _refined(self, picture: Picture, guess: NDArray) -> Match | None:
        """The mark near a guess, blurred as its velocity has it; once more where the position found means another velocity."""
        expected = self.expected.after(self.missed > 0)
        mark = self._as_moving(guess)
        match = recognise(picture, mark, guess, expected)
        if match is None or self._as_moving(match.warp) is mark:
            return match
        closer = recognise(picture, self._as_moving(match.warp), match.warp, expected)
        return closer if closer is not None and closer.unexplained < match.unexplained else match

    def _velocity(self, warp: NDArray) -> NDArray[np.float64]:
        """Motion per frame at the instant of the picture, px: that since the last frame, and half of its change."""
        if self.missed or len(self.places) < 2:
            return np.zeros(2)
        ahead, before = warp[[2, 5]] - self.places[-1][1], self.places[-1][1] - self.places[-2][1]
        return 1.5 * ahead - 0.5 * before

    def _as_moving(self, warp: NDArray) -> Reference:
        """The reference blurred by the motion to `warp` during the exposure, in small steps; kept while it serves."""
        if self.open_share == 0.0:
            return self.mark
        steps = np.rint(self._velocity(warp) * self.open_share / _BLUR_STEP_PX)
        if np.hypot(*steps) * _BLUR_STEP_PX < LEAST_BLUR_PX:
            return self.mark
        if self.moving is None or not np.array_equal(self.moving[0], steps):
            self.moving = (steps, blurred(self.mark, steps * _BLUR_STEP_PX))
        return self.moving[1]

    def _accepted(self, picture: Picture, frame: int, match: Match) -> Observation:
        self.missed, self.last = 0, OK
        self.expected = self.expected.updated(match, first=frame == 0)
        self.warp = match.warp
        point = self.mark.point(match.warp)
        self.places = [*self.places[-2:], (frame, match.warp[[2, 5]])]
        patch = cut(picture, match.warp, self.mark.half)
        if patch is not None and match.hidden < HARDLY_HIDDEN:
            self.patch = patch
        return Observation(float(point[0]), float(point[1]), match.covariance, match.zncc, match.noise, match.hidden, OK)

    def _left(self, picture: Picture, guess: NDArray, status: str) -> str:
        """Out of the frame where the extrapolated position has left the picture, else the status found."""
        rows, columns = picture.shape
        half = self.mark.half
        inside = half - 1 <= guess[2] <= columns - half and half - 1 <= guess[5] <= rows - half
        return status if inside else OUT


def cut(picture: Picture, warp: NDArray, half: int) -> NDArray | None:
    """The subset as it looks now, for the next search: its present rotation and stretch included; None over the border.

    Parameters
    ----------
    picture : (rows, columns) array
    warp : (6,) array
    half : int
        The subset is 2 half + 1 px wide.
    """
    column, row = round(warp[2]), round(warp[5])
    patch = picture[max(row - half, 0) : row + half + 1, max(column - half, 0) : column + half + 1]
    return patch.copy() if patch.shape == (2 * half + 1, 2 * half + 1) else None
