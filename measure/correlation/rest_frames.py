"""The reference image of a platform that is at rest at first: the mean of the frames before anything moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from measure.correlation.criteria import REST_SIGMAS
from measure.correlation.marks import OK, Observation
from measure.footage.footage import Picture

_MOST_FRAMES = 16
_MOST_BYTES = 2**27
"""The most frames that are averaged into the reference image, and the most memory that they may take."""


def read_rest(
    frames: Iterator[tuple[int, Picture]], at_rest: Callable[[int, Picture], bool]
) -> tuple[list[tuple[int, Picture]], NDArray[np.float32] | None]:
    """Read frames until something moves, and average those at rest: a reference image with less noise.

    The last frame at rest is left out of the mean where motion ended them, because motion may have begun there.

    Parameters
    ----------
    frames : iterator of (int, (height, width) array)
        Numbered pictures; as many as are needed are taken from it, 16 at most.
    at_rest : function of (int, picture)
        Whether nothing has moved in that frame since the first; it is called for each in turn, the first included.

    Returns
    -------
    read : list of (int, picture)
        The frames taken.
    mean : (height, width) array of float32 or None
        None where fewer than two frames are at rest.
    """
    read: list[tuple[int, Picture]] = []
    for frame, picture in frames:
        read.append((frame, picture))
        if not at_rest(frame, picture):
            return read, _mean([p for _, p in read[:-2]])
        if len(read) == min(_MOST_FRAMES, _MOST_BYTES // picture.nbytes + 1):
            break
    return read, _mean([p for _, p in read])


def _mean(pictures: list[Picture]) -> NDArray[np.float32] | None:
    if len(pictures) < 2:
        return None
    total = np.zeros(pictures[0].shape, np.float32)
    for picture in pictures:
        total += picture
    return total / np.float32(len(pictures))


def at_rest(reference_px: NDArray[np.float64], observed: Sequence[Observation]) -> bool:
    """Whether the marks, all together, have not left their reference points by twice their standard deviation.

    Parameters
    ----------
    reference_px : (marks, 2) array
        Reference points in the first frame, px.
    observed : sequence of Observation
        The same marks in another frame.

    Returns
    -------
    bool
        False too where one of them is not observed or covered in part.
    """
    if any(observation.status != OK or observation.hidden for observation in observed):
        return False
    moved = np.array([[observation.x_px, observation.y_px] for observation in observed]) - reference_px
    spread = np.array([np.diag(observation.covariance_px2) for observation in observed])
    together = (moved / spread).sum(axis=0) / np.sqrt((1.0 / spread).sum(axis=0))
    return bool(np.abs(together).max() < REST_SIGMAS and (moved**2 < (2.0 * REST_SIGMAS) ** 2 * spread).all())
