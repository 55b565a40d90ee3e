"""Which of the marks that were found move as one body, and why the others are left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from measure.correlation.marks import Marks

Array = NDArray[np.float64]

_STILL_SHARE = 0.3
"""A mark that moves less than this share of the largest motion stands still, or moves with something else."""

_STILL_SIGMAS, _STILL_PX = 8.0, 0.1
"""Motion that is not told from noise and interpolation: in standard deviations of the mark, and in px."""

_UNCERTAIN = 4.0
"""Times the median standard deviation of all marks from which a mark that was found is left out."""

_SEEN_SHARE = 0.5
"""Share of the frames in which a mark must be observed."""

_ALIKE = 0.3
"""Difference of two marks' motions, over the larger one, up to which they may belong to one body."""

_KEPT_DISTANCE = 0.02
"""Change of the distance between two marks, over that distance, up to which they turn about each other as one body."""

_FIT_MOST = 0.5
"""Share of a group's marks that a mark must fit to belong to it: a single pair can keep its distance at random."""

_ASTRAY, _ASTRAY_PX = 5.0, 0.3
"""Residual of a mark to the motion of the body, over the median of the marks and in px, from which it does not move with it."""

_RIVAL = 0.5
"""Share of the body's marks from which another moving body could as well be the platform."""


@dataclass(frozen=True)
class LeftOut:
    """A mark that is not used: where it is in the first frame, px, and the reason, in words."""

    x_px: float
    y_px: float
    reason: str


@dataclass(frozen=True)
class Body:
    """The marks of one body.

    Attributes
    ----------
    marks : Marks
        Those that move as one.
    left_out : tuple of LeftOut
        The others, with the reason.
    rivals : int
        Marks of another moving body that has nearly as many; zero where the choice is clear.
    lost : int
        Marks that were left out because they were lost.
    """

    marks: Marks
    left_out: tuple[LeftOut, ...] = ()
    rivals: int = 0
    lost: int = 0

    def without(self, which: NDArray[np.bool_], reason: str) -> Body:
        """The same without some of the marks; which : (marks,) array of bool."""
        places = self.marks.reference_px[which]
        left = tuple(LeftOut(float(x), float(y), reason) for x, y in places)
        return replace(self, marks=self.marks.only(~which), left_out=self.left_out + left)


def moves(marks: Marks) -> NDArray[np.bool_]:
    """Which marks move by more than noise and interpolation can make.

    Parameters
    ----------
    marks : Marks

    Returns
    -------
    (marks,) array of bool
    """
    sigma = np.array([np.median(marks.sigma_px[at, i]) if at.any() else 0.0 for i, at in enumerate(marks.observed.T)])
    return _extents(marks) > np.maximum(_STILL_SIGMAS * sigma, _STILL_PX)


def one_body(marks: Marks) -> Body:
    """Keep the marks that move as one body: the largest group of those that move.

    Two marks can belong to one body where their motions are alike, or where they keep their distance while they turn.

    Parameters
    ----------
    marks : Marks

    Returns
    -------
    Body
        Its marks are named anew, m1, m2 ... Where nothing moves all of them are kept.
    """
    reasons: list[str] = [""] * len(marks.names)
    _leave(reasons, ~_often(marks), "lost in most frames")
    kept = _none(reasons)
    _leave(reasons, kept & ~_certain(marks, kept), "its place is far less certain than that of the others")
    extents, kept, moving = _extents(marks), _none(reasons), moves(marks)
    if not kept.any() or not (moving & kept).any():
        return Body(marks)
    still = kept & ~(moving & (extents >= _STILL_SHARE * extents[kept].max()))
    _leave(reasons, still, "stands still, or hardly moves: background")
    groups = sorted(_groups(marks, _none(reasons)), key=lambda group: (len(group), extents[group].max()), reverse=True)
    others = np.isin(np.arange(len(reasons)), [i for group in groups[1:] for i in group])
    _leave(reasons, others, "does not move as one body with the rest")
    _leave(reasons, _astray(marks, _none(reasons)), "does not move as one body with the rest")
    second = len(groups[1]) if len(groups) > 1 else 0
    rivals = second if second >= 2 and second >= _RIVAL * len(groups[0]) else 0
    return _body(marks, reasons, rivals)


def _body(marks: Marks, reasons: list[str], rivals: int) -> Body:
    kept = _none(reasons)
    named = replace(marks.only(kept), names=[f"m{i + 1}" for i in range(int(kept.sum()))])
    places = zip(marks.reference_px, reasons, strict=True)
    left = tuple(LeftOut(float(x), float(y), reason) for (x, y), reason in places if reason)
    return Body(named, left, rivals, sum(reason.startswith("lost") for reason in reasons))


def _leave(reasons: list[str], which: NDArray[np.bool_], why: str) -> None:
    for i in np.flatnonzero(which):
        reasons[i] = reasons[i] or why


def _none(reasons: list[str]) -> NDArray[np.bool_]:
    return np.array([not reason for reason in reasons])


def _often(marks: Marks) -> NDArray[np.bool_]:
    seen = marks.observed.mean(axis=0)
    return seen >= min(_SEEN_SHARE, float(seen.max()))


def _certain(marks: Marks, kept: NDArray[np.bool_]) -> NDArray[np.bool_]:
    sigma = np.array([np.median(marks.sigma_px[at, i]) if at.any() else np.inf for i, at in enumerate(marks.observed.T)])
    return sigma <= _UNCERTAIN * np.median(sigma[kept]) if kept.any() else kept


def _extents(marks: Marks) -> Array:
    """How far each mark moves, px: the diagonal of the box around its path, without the outermost fiftieth of its places."""
    extents = np.zeros(len(marks.names))
    for i, at in enumerate(marks.observed.T):
        if at.any():
            low, high = np.quantile(np.stack([marks.x_px[at, i], marks.y_px[at, i]]), [0.02, 0.98], axis=1)
            extents[i] = np.hypot(*(high - low))
    return extents


def _groups(marks: Marks, kept: NDArray[np.bool_]) -> list[list[int]]:
    """Marks that move as one: around the one that has most in common with the others, those that fit most of that group."""
    path, count = np.stack([marks.x_px, marks.y_px], axis=-1), len(marks.names)
    fits = np.eye(count, dtype=bool)
    for i, j in combinations(np.flatnonzero(kept), 2):
        fits[i, j] = fits[j, i] = _as_one(path[:, i], path[:, j], marks.reference_px[[i, j]])
    left, groups = kept.copy(), []
    while left.any():
        among = fits & left & left[:, None]
        middle = int(np.argmax(among.sum(axis=1)))
        group = [int(i) for i in np.flatnonzero(among[middle])]
        group = [i for i in group if i == middle or among[i, group].mean() > _FIT_MOST]
        groups.append(group)
        left[group] = False
    return groups


def _as_one(a: Array, b: Array, start: Array) -> bool:
    """Whether two marks, (frames, 2) each, can belong to one body."""
    both = np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1)
    if both.sum() < 2:
        return False
    moved = np.stack([a[both] - start[0], b[both] - start[1]])
    size = np.sqrt((moved**2).sum(axis=2).mean(axis=1))
    apart = np.sqrt(((moved[0] - moved[1]) ** 2).sum(axis=1).mean())
    distance = float(np.hypot(*(start[1] - start[0])))
    stretched = np.sqrt(np.mean((np.hypot(*(a[both] - b[both]).T) - distance) ** 2))
    return bool(apart < _ALIKE * size.max() or stretched < _KEPT_DISTANCE * distance)


def _astray(marks: Marks, kept: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Marks that leave the plane motion of the others (shift, rotation, stretch), the worst first."""
    astray = np.zeros(len(kept), bool)
    while (kept & ~astray).sum() >= 5:
        at = np.flatnonzero(kept & ~astray)
        residual = _residuals(marks, at)
        worst = int(np.argmax(residual))
        if not residual[worst] > max(_ASTRAY * np.median(residual), _ASTRAY_PX):
            break
        astray[at[worst]] = True
    return astray


def _residuals(marks: Marks, at: NDArray[np.int64]) -> Array:
    """Root mean square distance of each mark from an affine motion that at least four marks of a frame agree on, px."""
    squares = np.full((len(marks.time_s), len(at)), np.nan)
    for t, seen in enumerate(marks.observed[:, at]):
        if seen.sum() < 4:
            continue
        start = np.column_stack([marks.reference_px[at[seen]], np.ones(int(seen.sum()))])
        now = np.column_stack([marks.x_px[t, at[seen]], marks.y_px[t, at[seen]]])
        fitted = start @ np.linalg.lstsq(start, now, rcond=None)[0]
        squares[t, seen] = ((now - fitted) ** 2).sum(axis=1)
    counted = np.isfinite(squares).any(axis=0)
    return np.sqrt(np.where(counted, np.nanmean(np.where(counted, squares, 0.0), axis=0), 0.0))
