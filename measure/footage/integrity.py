"""What can be wrong with frames although every one of them can be decoded: repeated, dark, and interlaced ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from measure.footage.footage import Picture

_EVERY = 8
_DARK_SHARE = 0.25

_FINER = 4
"""Every so many rows and columns are compared for a picture that was repeated before compression."""

_MOST_CHANGED = 0.02
"""Share of the pixels, those that change most, by whose mean a change from picture to picture is measured."""

_REPEATS = 0.2
"""Change of a picture, over those before and after it, below which it repeats the one before. A motion that turns around between
two frames changes the picture as little, but leads back where it came from."""

_MOVES = 0.1
"""Change over the range of grey values from which it is of motion, and not of compression alone."""

_LONGEST = 3
"""Pictures in a row that are repeated; where more stay the same, nothing moves."""

_LEADS_BACK = 0.75
"""Change across a motion that turned around, over the change of a frame beside it; one that goes on changes as much or more."""

_MOVED_TIMES = 4.0
"""Times the noise of a difference by which a pixel changes that moves."""

_FEWEST_MOVED = 100
"""Pixels that move, from which the two fields of a frame can be told apart in time."""

_NEARER = 0.25
"""Share by which two fields of different frames are more alike than the other two of the same frames, where they were taken at different
instants. At constant speed it is 1 - (1/3)^2 of a small motion and falls as the motion grows beyond the grain of the texture."""

_ENOUGH = 100
"""Frames that move, from which the answer does not change any more."""

_ONE_WAY, _OTHER_WAY = 0.7, 0.1
"""Shares of the frames that move that must be combed one way, and may be the other way."""


@dataclass
class IntegrityCheck:
    """Frames that are wrong.

    Attributes
    ----------
    repeated : list of int
        Frames that repeat the one before to the last grey level.
    dark : list of int
        Frames whose mean is below a quarter of the first one's.
    combing : Combing
        Whether the frames consist of two fields.
    first : int
        Number in the film of the frame that is counted as 0, for the remarks.
    """

    repeated: list[int] = field(default_factory=list)
    dark: list[int] = field(default_factory=list)
    combing: Combing = field(default_factory=lambda: Combing())
    first: int = 0
    _changes: _Changes = field(default_factory=lambda: _Changes())

    def watch(self, frames: Iterator[tuple[int, Picture]]) -> Iterator[tuple[int, Picture]]:
        """Hand the frames on and record what is wrong with them.

        Parameters
        ----------
        frames : iterator of (int, (height, width) array)

        Returns
        -------
        The same.
        """
        before, brightness = None, None
        for number, picture in frames:
            sample = picture[::_EVERY, ::_EVERY]
            mean = float(sample.mean())
            brightness = mean if brightness is None else brightness
            if mean < _DARK_SHARE * brightness:
                self.dark.append(number)
            if before is not None and np.array_equal(sample, before[::_EVERY, ::_EVERY]) and np.array_equal(picture, before):
                self.repeated.append(number)
            self._changes.watch(number, picture)
            self.combing.watch(picture)
            before = picture
            yield number, picture

    @property
    def copies(self) -> list[int]:
        """Frames that show again what the one before showed while the film moves, also after compression: they are no observation."""
        return self._changes.copies()

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences for the summary."""
        repeated = sorted({*self.repeated, *self.copies})
        found = (("repeat the one before", repeated), ("are dark", self.dark))
        listed = tuple(f"frames {what} ({len(frames)}): {self._listed(frames)}" for what, frames in found if frames)
        return listed + ((self.combing.remark,) if self.combing.interlaced else ())

    def _listed(self, frames: list[int]) -> str:
        return ", ".join(str(self.first + frame) for frame in frames[:8]) + (", ..." if len(frames) > 8 else "")


class _Changes:
    """How much the pictures change, one after the other, and across three steps."""

    def __init__(self) -> None:
        self.last: list[NDArray[np.float32]] = []
        self.numbers: list[int] = []
        self.one: list[float] = []
        self.three: list[float] = []
        self.range = 0.0

    def watch(self, number: int, picture: Picture) -> None:
        """Take in the next picture."""
        sample = picture[::_FINER, ::_FINER].astype(np.float32)
        if not self.last:
            low, high = np.percentile(sample, (0.5, 99.5))
            self.range = max(float(high - low), 1.0)
        self.numbers.append(number)
        self.one.append(_change(sample, self.last[-1]) if self.last else np.inf)
        self.three.append(_change(sample, self.last[-3]) if len(self.last) > 2 else np.inf)
        self.last = [*self.last[-2:], sample]

    def copies(self) -> list[int]:
        """Numbers of the pictures that hardly change between two that do."""
        found: list[int] = []
        n = 2  # what changed before the first picture is not known
        while n < len(self.one) - 1:
            end = n
            while end < min(n + _LONGEST, len(self.one) - 1) and self.one[end] < _REPEATS * self.one[n - 1]:
                end += 1
            if end > n and self._held(n, end):
                found += self.numbers[n:end]
            n = max(end, n + 1)
        return found

    def _held(self, n: int, end: int) -> bool:
        """Whether the pictures from `n` to before `end` repeat the one before: all moves until then, and afterwards goes on."""
        before, after, most = self.one[n - 1], self.one[end], max(self.one[n:end])
        if not np.isfinite(before) or min(before, after) <= _MOVES * self.range or most >= _REPEATS * after:
            return False
        return end > n + 1 or not (self.three[end] < _LEADS_BACK * min(before, after) or most >= _REPEATS * self._foreseen(n))

    def _foreseen(self, n: int) -> float:
        """The change at `n` by those on either side, linearly continued; the smaller of the two."""
        beside = [(k, m) for k, m in ((n - 1, n - 2), (n + 1, n + 2)) if 0 < m < len(self.one)]
        return min((2.0 * self.one[k] - self.one[m] for k, m in beside), default=np.inf)


def _change(picture: NDArray[np.float32], before: NDArray[np.float32]) -> float:
    """Mean change of the pixels that change most, grey levels."""
    change = np.abs(picture - before).ravel()
    most = max(1, int(_MOST_CHANGED * change.size))
    return float(np.partition(change, change.size - most)[-most:].mean())


@dataclass
class Combing:
    """Whether the even and the odd rows of a film's frames were taken at different instants, as an interlaced camera does.

    Of two frames n and n + 1 with the top rows taken first, the bottom rows of n and the top rows of n + 1 are half a step
    apart, the top rows of n and the bottom rows of n + 1 one step and a half. In a progressive film both are one step apart.

    Attributes
    ----------
    moving : int
        Frames that move enough to tell.
    top, bottom : int
        How many of them speak for the top rows, or the bottom rows, being first.
    """

    moving: int = 0
    top: int = 0
    bottom: int = 0
    _before: NDArray[np.float32] | None = None

    @property
    def combed(self) -> int:
        """Frames whose rows differ as those of two instants, one way."""
        return max(self.top, self.bottom)

    @property
    def top_first(self) -> bool:
        """Whether rows 0, 2, 4 ... were taken first."""
        return self.top >= self.bottom

    @property
    def interlaced(self) -> bool:
        """Whether most frames that move are combed, and one way."""
        return self.moving > 0 and self.combed >= _ONE_WAY * self.moving and min(self.top, self.bottom) <= _OTHER_WAY * self.moving

    @property
    def remark(self) -> str:
        """The finding as a sentence."""
        return (
            f"the film is interlaced, {'top' if self.top_first else 'bottom'} field first: {self.combed} of {self.moving} frames that move "
            "show two instants; give --fields to take each field as a picture"
        )

    def watch(self, picture: Picture) -> None:
        """Take in the next picture."""
        rows = len(picture) - len(picture) % 2
        now, before = picture[:rows, ::_EVERY].astype(np.float32), self._before
        self._before = now
        if before is None or self.moving >= _ENOUGH:
            return
        change = np.abs(now - before)
        moved = change > _MOVED_TIMES * min(float(np.median(change)) / 0.6745, _noise_of_difference(picture)) + 1.0
        inner = moved[2:-2:2] | moved[3:-1:2]
        if inner.sum() < _FEWEST_MOVED:
            return
        self.moving += 1
        near = _apart(now[0::2], before[1::2], inner)
        far = _apart(before[0::2], now[1::2], inner)
        self.top += near < (1.0 - _NEARER) * far
        self.bottom += far < (1.0 - _NEARER) * near


def _noise_of_difference(picture: Picture) -> float:
    """Noise of the difference of two pictures, from second differences along the rows, which the fields do not touch."""
    return float(np.median(np.abs(np.diff(picture[::_EVERY].astype(np.float32), 2, axis=1)))) / (0.6745 * np.sqrt(3.0))


def _apart(top: NDArray[np.float32], bottom: NDArray[np.float32], where: NDArray[np.bool_]) -> float:
    """Mean square difference of two fields where something moves; both are brought to the height between their rows."""
    at_bottom = (9.0 * (top[1:-1] + top[2:]) - top[:-2] - np.pad(top[3:], ((0, 1), (0, 0)), "edge")) / 16.0
    return float(np.mean((at_bottom - bottom[1:-1])[where] ** 2))
