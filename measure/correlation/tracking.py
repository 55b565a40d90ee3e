"""Marks through a film: the reference image from the frames at rest, then every mark in every frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from copy import copy
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.correlation.criteria import DISTINCT
from measure.correlation.mark_tracker import MarkTracker, cut
from measure.correlation.marks import MISSING, OK, Marks, Observation, gather, not_observed
from measure.correlation.reference import Reference
from measure.correlation.reference_image import reference
from measure.correlation.rest_frames import at_rest, read_rest
from measure.correlation.shape_function_bias import NODES, Response, node_weights
from measure.correlation.steepest_descent import AFFINE, TRANSLATION
from measure.correlation.template_matching import is_unique
from measure.footage.footage import Footage, Picture

_FEWEST_THAT_TELL = 2
"""Marks that say where the others should be."""


def check_subset(subset: int) -> None:
    """Refuse a subset size (px) that has no centre pixel or no room for texture.

    Raises
    ------
    InputError
        It is even, below 9 or above 301.
    """
    if subset % 2 == 0 or not 9 <= subset <= 301:
        raise InputError(f"--subset {subset}: a subset has a centre pixel; give an odd number from 9 to 301.")


def why_unusable(picture: Picture, place: tuple[float, float], subset: int, mask: NDArray[np.bool_] | None = None) -> str:
    """Why a place cannot be tracked: too near the border, or too little texture. Empty where it can.

    Parameters
    ----------
    picture : (rows, columns) array
        The first frame.
    place : (x, y)
        px.
    subset : int
        Side of the subset, odd, px.
    mask : (rows, columns) array of bool, optional
        Pixels that belong to marks.
    """
    try:
        reference(picture, *place, subset, TRANSLATION, mask)
    except InputError as error:
        return str(error)
    return ""


def track_marks(
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
    """Track marks through a film by digital image correlation.

    Parameters
    ----------
    footage : Footage
    places : sequence of (x, y)
        Reference points in the first frame, px; pixel centres at whole numbers, x to the right, y down.
    fps : float
        Capture rate, frames per second.
    subset : int
        Side of the subset, odd, px.
    warp : int
        The richest warp that a mark may have: 2 (shift), 3 (shift and rotation) or 6 (affine) parameters.
    exposure_s : float
        Exposure time, s; a fast mark is blurred by it.
    names : sequence of str, optional
        Of the marks; m1, m2 ... without it.
    watch : function, optional
        Wraps the stream of frames, for a progress bar.
    mask : (rows, columns) array of bool, optional
        Pixels of the first frame that belong to marks.

    Returns
    -------
    Marks
        Frames that the film lacks are rows with the status `missing`.

    Raises
    ------
    InputError
        A mark without texture or too near the border, fewer than two frames.
    """
    check_subset(subset)
    frames = watch(footage.pictures())

    def prepare(picture: Picture, mean: NDArray | None = None, alone: bool = False) -> list[MarkTracker]:
        return [mark_tracker(picture, x, y, subset, warp, exposure_s * fps, mean, mask, alone) for x, y in places]

    read, mean = read_rest(frames, _RestTest(prepare))
    trackers = prepare(read[0][1], mean) if read else []
    rows: list[list[Observation]] = []
    for frame, picture in chain(read, frames):
        while len(rows) < frame:
            rows.append([not_observed(MISSING) for _ in trackers])
        rows.append(_observed(trackers, picture, frame))
    if len(rows) < 2:
        raise InputError(f"{footage.name}: {len(rows)} frames could be read; a motion needs two at least. Copy the film again.")
    names = list(names) or [f"m{i + 1}" for i in range(len(places))]
    return gather(footage.times_s(len(rows), fps), names, responses([tracker.mark for tracker in trackers]), rows, footage.first)


def _observed(trackers: list[MarkTracker], picture: Picture, frame: int) -> list[Observation]:
    """All marks in one picture; those that are lost are looked for once more where the others say that they should be.

    Marks can look alike. So one that comes back must be nearer to where it should be than to where any other mark should be,
    as far as the marks that were never away move as one and say so of themselves.
    """
    before = [copy(tracker) for tracker in trackers]
    row = [tracker.observe(picture, frame) for tracker in trackers]
    seen = np.array([observation.status == OK for observation in row])
    stayed = seen & np.array([not tracker.missed for tracker in before])
    telling = stayed if stayed.sum() >= _FEWEST_THAT_TELL else seen
    if stayed.all() or telling.sum() < _FEWEST_THAT_TELL:
        return row
    start = np.array([tracker.mark.point_px for tracker in trackers])
    now = np.array([[observation.x_px, observation.y_px] for observation in row])
    expected = _moved(start[telling], now[telling], start)
    as_one = all(_nearest(expected, row[i]) == i for i in np.flatnonzero(telling))
    for i in map(int, np.flatnonzero(seen & ~telling)):
        if as_one and _nearest(expected, row[i]) != i:
            trackers[i], row[i], seen[i] = before[i], before[i].missed_again(), False
    for i in map(int, np.flatnonzero(~seen)):
        kept = copy(trackers[i])
        found = trackers[i].look_at(picture, frame, expected[i])
        if found is not None and (not as_one or _nearest(expected, found) == i):
            row[i] = found
        else:
            trackers[i] = kept
    return row


def _nearest(expected: NDArray, found: Observation) -> int:
    """The mark whose expected place, of (marks, 2), is nearest to where something was found."""
    return int(np.argmin(np.hypot(expected[:, 0] - found.x_px, expected[:, 1] - found.y_px)))


def _moved(start: NDArray, now: NDArray, points: NDArray) -> NDArray[np.float64]:
    """Where points go that move with some marks, by shift, rotation and scale: now = a start + b in complex numbers."""
    z, w = start @ [1.0, 1.0j], now @ [1.0, 1.0j]
    lever = z - z.mean()
    a = np.vdot(lever, w - w.mean()) / max(float(np.vdot(lever, lever).real), 1.0)
    gone = w.mean() + a * (points @ [1.0, 1.0j] - z.mean())
    return np.column_stack([gone.real, gone.imag])


def mark_tracker(
    picture: Picture,
    x: float,
    y: float,
    subset: int,
    warp: int = AFFINE,
    open_share: float = 0.0,
    mean: NDArray | None = None,
    mask: NDArray[np.bool_] | None = None,
    alone: bool = False,
) -> MarkTracker:
    """Prepare to track the mark at (x, y) of the reference image.

    Parameters
    ----------
    picture : (rows, columns) array
        The first frame.
    x, y : float
        Reference point, px.
    subset : int
        Side of the subset, odd, px.
    warp : int
        The richest warp allowed: 2, 3 or 6 parameters.
    open_share : float
        Exposure time over the time from frame to frame.
    mean : (rows, columns) array, optional
        Mean of several frames at rest, to be the reference image in place of `picture`.
    mask : (rows, columns) array of bool, optional
        Pixels that belong to marks.
    alone : bool
        Nothing else looks like the mark, so that the whole picture need not be searched for its like.

    Returns
    -------
    MarkTracker

    Raises
    ------
    InputError
        The subset reaches over the border, or has too little texture.
    """
    mark = reference(picture if mean is None else mean, x, y, subset, warp, mask)
    patch = cut(picture, mark.start, mark.half)
    assert patch is not None
    return MarkTracker(mark, patch, mark.start, alone or is_unique(picture, patch, DISTINCT, mark.shape), open_share)


class _RestTest:
    """Whether nothing has moved since the first frame, by trackers of its own."""

    def __init__(self, prepare: Callable[..., list[MarkTracker]]) -> None:
        self.prepare = prepare
        self.trackers: list[MarkTracker] | None = None

    def __call__(self, frame: int, picture: Picture) -> bool:
        if self.trackers is None:
            self.trackers = self.prepare(picture, alone=True)
            return True
        reference_px = np.array([tracker.mark.point_px for tracker in self.trackers])
        return at_rest(reference_px, [tracker.observe(picture, frame) for tracker in self.trackers])


def responses(marks: Sequence[Reference]) -> Response:
    """What a motion that the warp cannot follow makes of the positions of prepared marks, each by its own texture.

    Parameters
    ----------
    marks : sequence of Reference

    Returns
    -------
    Response
    """
    centres = np.array([[mark.subset.column, mark.subset.row] for mark in marks], float)
    halves = np.array([mark.half + 0.5 for mark in marks])
    nodes = centres[:, None] + halves[:, None, None] * NODES
    weights = np.array([node_weights(mark.half, mark.subset.kept, mark.descent, mark.answer) for mark in marks])
    followed = np.array([mark.followed for mark in marks])
    return Response(np.array([mark.point_px for mark in marks]), nodes, weights, np.array([mark.warp for mark in marks]), followed)
