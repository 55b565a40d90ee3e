"""The reference image where the platform is at rest at first: the mean of what does not move."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from measure.correlation.marks import OK, Sighting
from measure.footage.footage import Picture

if TYPE_CHECKING:
    from measure.correlation.tracking import Follower

_STILL_FRAMES = 16
_STILL_BYTES = 2**27
"""The most frames that are averaged into the reference image, and the most memory that they may take."""


def still_frames(
    frames: Iterator[tuple[int, Picture]], prepare: Callable[[Picture], list[Follower]]
) -> tuple[list[tuple[int, Picture]], NDArray[np.float32] | None]:
    """The frames read until something moves, and the mean of those at rest: a reference image with less noise.

    At rest are frames whose marks, all together, have not left their places in the first frame by twice their sigma. The
    last of them is left out where motion ended them, because it may have begun there.
    """
    read: list[tuple[int, Picture]] = []
    marks: list[Follower] = []
    for frame, picture in frames:
        read.append((frame, picture))
        if len(read) == 1:
            marks = prepare(picture)
        elif not _at_rest(marks, [mark.look(picture, frame) for mark in marks]):
            return read, _mean([p for _, p in read[:-2]])
        if len(read) == min(_STILL_FRAMES, _STILL_BYTES // picture.nbytes + 1):
            break
    return read, _mean([p for _, p in read])


def _at_rest(marks: list[Follower], seen: list[Sighting]) -> bool:
    if any(sighting.status != OK or sighting.hidden for sighting in seen):
        return False
    moved = np.array([[s.x_px, s.y_px] - m.mark.point(m.mark.start) for m, s in zip(marks, seen, strict=True)])
    spread = np.array([np.diag(sighting.covariance) for sighting in seen])
    together = (moved / spread).sum(axis=0) / np.sqrt((1.0 / spread).sum(axis=0))
    return bool(np.abs(together).max() < 2.0 and (moved**2 < 16.0 * spread).all())


def _mean(pictures: list[Picture]) -> NDArray[np.float32] | None:
    """The mean of several pictures, None of one or none."""
    if len(pictures) < 2:
        return None
    total = np.zeros(pictures[0].shape, np.float32)
    for picture in pictures:
        total += picture
    return total / np.float32(len(pictures))
