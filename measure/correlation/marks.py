"""The table of marks: where every mark was in every frame, how surely, and what became of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from measure.correlation.curved_marks import Response
from measure.tables.csv_cells import write_columns

OK, OCCLUDED, LOST, AMBIGUOUS, OUT, MISSING = "ok", "occluded", "lost", "ambiguous", "out-of-frame", "missing"
_ARRAYS = ("x_px", "y_px", "covariance_px2", "zncc", "hidden", "status")


@dataclass(frozen=True)
class Sighting:
    """One mark in one frame. Where the status is not ok the position is NaN: an old one is never repeated.

    x_px, y_px : the reference point, pixel centres at whole numbers, x to the right, y down. covariance : (2, 2) px^2.
    zncc : correlation with the reference image. noise : what is left between the two images, grey levels.
    hidden : share of the subset that something else covers.
    """

    x_px: float
    y_px: float
    covariance: NDArray[np.float64]
    zncc: float
    noise: float
    hidden: float
    status: str


def unseen(status: str, zncc: float = np.nan) -> Sighting:
    """A mark without a position."""
    return Sighting(np.nan, np.nan, np.full((2, 2), np.nan), zncc, np.nan, np.nan, status)


@dataclass(frozen=True)
class Marks:
    """All sightings: arrays (frames, marks), positions NaN where the status is not ok.

    time_s : (frames,), zero at the first frame. names : of the marks. response : what bent motion makes of their places.
    covariance_px2 : (frames, marks, 2, 2).
    """

    time_s: NDArray[np.float64]
    names: Sequence[str]
    response: Response
    x_px: NDArray[np.float64]
    y_px: NDArray[np.float64]
    covariance_px2: NDArray[np.float64]
    zncc: NDArray[np.float64]
    hidden: NDArray[np.float64]
    status: NDArray[np.str_]

    @property
    def reference_px(self) -> NDArray[np.float64]:
        """(marks, 2): where they were in the reference image."""
        return self.response.reference_px

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(frames, marks): whether there is a position."""
        return self.status == OK

    @property
    def sigma_px(self) -> NDArray[np.float64]:
        """(frames, marks): standard deviation of a coordinate, root mean square of the two."""
        return np.sqrt(0.5 * np.trace(self.covariance_px2, axis1=2, axis2=3))

    def only(self, kept: NDArray[np.bool_]) -> Marks:
        """The same without some of the marks; kept : (marks,)."""
        names = [name for name, keep in zip(self.names, kept, strict=True) if keep]
        arrays = {field: getattr(self, field)[:, kept] for field in _ARRAYS}
        return Marks(self.time_s, names, self.response.only(kept), **arrays)


def gather(time_s: NDArray[np.float64], names: Sequence[str], response: Response, rows: Sequence[Sequence[Sighting]]) -> Marks:
    """Put the sightings of every frame (rows) into arrays."""
    columns = (*_ARRAYS[:2], "covariance", *_ARRAYS[3:])
    arrays = [np.array([[getattr(sighting, column) for sighting in row] for row in rows]) for column in columns]
    return Marks(time_s, names, response, **dict(zip(_ARRAYS, arrays, strict=True)))


def write_marks(marks: Marks, path: Path) -> None:
    """Write the table `frame, time_s, mark, x_px, y_px, zncc, status`, one row per frame and mark, sigmas behind."""
    frames, count = marks.x_px.shape
    sigma = np.sqrt(np.diagonal(marks.covariance_px2, axis1=2, axis2=3))
    columns = {
        "frame": np.repeat(np.arange(frames), count),
        "time_s": np.repeat(marks.time_s, count),
        "mark": list(marks.names) * frames,
        "x_px": marks.x_px.ravel(),
        "y_px": marks.y_px.ravel(),
        "zncc": marks.zncc.ravel(),
        "status": [str(word) for word in marks.status.ravel()],
        "sigma_x_px": sigma[..., 0].ravel(),
        "sigma_y_px": sigma[..., 1].ravel(),
    }
    write_columns(columns, path)
