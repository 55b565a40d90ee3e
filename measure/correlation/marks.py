"""The table of marks: where every mark was in every frame, how accurately, and what became of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from measure.correlation.shape_function_bias import Response
from measure.tables.frames import frame_of

if TYPE_CHECKING:
    from pandas import DataFrame

OK, OCCLUDED, LOST, AMBIGUOUS, OUT, MISSING = "ok", "occluded", "lost", "ambiguous", "out-of-frame", "missing"
_ARRAYS = ("x_px", "y_px", "covariance_px2", "zncc", "hidden", "status")


@dataclass(frozen=True)
class Observation:
    """One mark in one frame. Where the status is not ok the position is NaN; an old position is never repeated.

    Attributes
    ----------
    x_px, y_px : float
        Reference point in the current image, px; pixel centres at whole numbers, x to the right, y down.
    covariance_px2 : (2, 2) array
        Of the position, px^2.
    zncc : float
        Zero-mean normalised cross-correlation with the reference image.
    noise : float
        Residual between the two images, grey levels.
    hidden : float
        Share of the subset that something else covers.
    status : str
        ok, occluded, lost, ambiguous, out-of-frame or missing.
    """

    x_px: float
    y_px: float
    covariance_px2: NDArray[np.float64]
    zncc: float
    noise: float
    hidden: float
    status: str


def not_observed(status: str, zncc: float = np.nan) -> Observation:
    """A mark without a position, and why: `status` is any but ok."""
    return Observation(np.nan, np.nan, np.full((2, 2), np.nan), zncc, np.nan, np.nan, status)


@dataclass(frozen=True, repr=False)
class Marks:
    """All marks in all frames.

    Attributes
    ----------
    time_s : (frames,) array
        Zero at the first frame of the film.
    names : sequence of str
        One for each mark.
    response : Response
        What a motion that the warp cannot follow makes of their positions.
    x_px, y_px : (frames, marks) arrays
        Reference points, px, NaN where the status is not ok.
    covariance_px2 : (frames, marks, 2, 2) array
    zncc : (frames, marks) array
        Zero-mean normalised cross-correlation with the reference image.
    hidden : (frames, marks) array
        Share of the subset that something else covers.
    status : (frames, marks) array of str
    first : int
        Number in the film of the first of these frames.
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
    first: int = 0

    def __repr__(self) -> str:
        frames, count = self.x_px.shape
        return f"Marks({count} marks in {frames} frames, {100 * self.observed.mean():.1f} % ok, median sigma {self.median_sigma_px:.2g} px)"

    @property
    def reference_px(self) -> NDArray[np.float64]:
        """(marks, 2): reference points in the reference image, px."""
        return self.response.reference_px

    @property
    def observed(self) -> NDArray[np.bool_]:
        """(frames, marks): whether there is a position."""
        return self.status == OK

    @property
    def sigma_px(self) -> NDArray[np.float64]:
        """(frames, marks): standard deviation of a coordinate, root mean square of the two, px."""
        return np.sqrt(0.5 * np.trace(self.covariance_px2, axis1=2, axis2=3))

    @property
    def median_sigma_px(self) -> float:
        """Median standard deviation of a coordinate over all observations, px; NaN without any."""
        return float(np.nanmedian(self.sigma_px)) if self.observed.any() else np.nan

    def widened(self, factor: float | NDArray[np.float64]) -> Marks:
        """The same with standard deviations that are `factor` times as large; one number or one for each frame."""
        return replace(self, covariance_px2=self.covariance_px2 * np.reshape(factor, (-1, 1, 1, 1)) ** 2)

    def only(self, kept: NDArray[np.bool_]) -> Marks:
        """The same for some of the marks; kept : (marks,) array of bool."""
        names = [name for name, keep in zip(self.names, kept, strict=True) if keep]
        arrays = {field: getattr(self, field)[:, kept] for field in _ARRAYS}
        return replace(self, names=names, response=self.response.only(kept), **arrays)

    def without(self, which: NDArray[np.bool_], status: str) -> Marks:
        """The same without some of the sightings; which : (frames, marks) array of bool, status : why, any but ok."""
        gone = not_observed(status)
        changed = {field: getattr(self, field).copy() for field in _ARRAYS if field != "status"}
        for field, values in changed.items():
            values[which] = getattr(gone, field)
        return replace(self, status=np.where(which, status, self.status), **changed)

    def columns(self) -> dict[str, Any]:
        """The table, one row for each frame and mark: `frame, time_s, mark, x_px, y_px, zncc, status`, then the sigmas.

        Returns
        -------
        dict of str to sequences of length frames * marks
        """
        frames, count = self.x_px.shape
        sigma = np.sqrt(np.diagonal(self.covariance_px2, axis1=2, axis2=3))
        return {
            "frame": np.repeat(np.arange(self.first, self.first + frames), count),
            "time_s": np.repeat(self.time_s, count),
            "mark": list(self.names) * frames,
            "x_px": self.x_px.ravel(),
            "y_px": self.y_px.ravel(),
            "zncc": self.zncc.ravel(),
            "status": [str(word) for word in self.status.ravel()],
            "sigma_x_px": sigma[..., 0].ravel(),
            "sigma_y_px": sigma[..., 1].ravel(),
        }

    def to_frame(self) -> DataFrame:
        """The table as a pandas frame, one row for each frame and mark; units in `frame.attrs["units"]`.

        Returns
        -------
        pandas.DataFrame
            frame, time_s, mark, x_px, y_px, zncc, status, sigma_x_px, sigma_y_px.
        """
        return frame_of(self.columns(), name="marks")


def gather(
    time_s: NDArray[np.float64], names: Sequence[str], response: Response, rows: Sequence[Sequence[Observation]], first: int = 0
) -> Marks:
    """Put the observations of every frame into arrays.

    Parameters
    ----------
    time_s : (frames,) array
    names : sequence of str
    response : Response
    rows : sequence of (marks,) sequences
        Observations, a row for each frame.
    first : int
        Number in the film of the first of these frames.

    Returns
    -------
    Marks
    """
    arrays = [np.array([[getattr(observation, field) for observation in row] for row in rows]) for field in _ARRAYS]
    return Marks(time_s, names, response, **dict(zip(_ARRAYS, arrays, strict=True)), first=first)
