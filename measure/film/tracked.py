"""The result of tracking a film: trajectory, marks, fit, complete project and summary."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from measure.correlation.marks import Marks
from measure.geometry.film_project import Project
from measure.geometry.rigid_body import Fit
from measure.tables.trajectory import Trajectory

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, repr=False)
class Tracked:
    """What a film shows.

    Attributes
    ----------
    trajectory : Trajectory or None
        Motion of the platform; None without a scale.
    marks : Marks
        Every mark in every frame, px.
    fit : Fit or None
        The rigid body fitted to them; None without a scale.
    project : Project
        Complete: it repeats the run.
    summary : dict
        The numbers that `track-video --json` writes.
    """

    trajectory: Trajectory | None
    marks: Marks
    fit: Fit | None
    project: Project
    summary: dict[str, Any]

    def __repr__(self) -> str:
        frames, count = self.marks.x_px.shape
        channels = "no scale" if self.trajectory is None else ", ".join(self.trajectory.channels)
        return f"Tracked({self.summary['verdict']}: {count} marks in {frames} frames, {channels})"

    def to_frame(self) -> DataFrame:
        """The trajectory, or without a scale the marks, as a pandas frame; units in `frame.attrs["units"]`.

        Returns
        -------
        pandas.DataFrame
            A row for each frame of the film; of the marks, for each frame and mark.
        """
        return self.marks.to_frame() if self.trajectory is None else self.trajectory.to_frame()
