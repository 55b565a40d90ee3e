"""The motion of the platform and its CSV file: comma, point, UTF-8, one header row, the unit in every name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, clipped, nearest
from measure.notebook.shown import Shown
from measure.tables.checks import no_time, require_equal_lengths, require_finite, require_increasing, require_no_infinity
from measure.tables.csv_cells import numbers, read_columns, write_columns
from measure.tables.frames import columns_of, frame_of
from measure.tables.raw_table import RawTable

if TYPE_CHECKING:
    from pandas import DataFrame

CHANNELS = ("x_m", "y_m", "z_m", "theta_x_rad", "theta_y_rad", "theta_z_rad")
WORDS = ("status",)
_SIGMA = {f"sigma_{channel}": channel for channel in CHANNELS}


@dataclass(frozen=True, repr=False)
class Trajectory(Shown, by="measure.notebook.table_plots.ShowingTrajectory"):
    """Motion of the platform against time, as far as it was observed.

    time_s : (n,) strictly increasing. channels : any of `CHANNELS`, each (n,), NaN where nothing was observed.
    sigma : one standard deviation for any of these channels, (n,), NaN where there is none.
    status : (n,) text, or empty.
    """

    time_s: Array
    channels: Mapping[str, Array]
    sigma: Mapping[str, Array] = field(default_factory=dict)
    status: Sequence[str] = ()
    name: str = "trajectory"

    def __post_init__(self) -> None:
        object.__setattr__(self, "time_s", np.asarray(self.time_s, dtype=float))
        require_finite(self.time_s, "time_s", self.name)
        for mapping in ("channels", "sigma"):
            made = {k: np.asarray(v, dtype=float) for k, v in getattr(self, mapping).items()}
            object.__setattr__(self, mapping, made)
            for channel, values in made.items():
                self._check(channel, values)
        if len(self.status) not in (0, len(self.time_s)):
            raise InputError(f"{self.name}: status has {len(self.status)} rows and time_s {len(self.time_s)}; give one a row.")
        for channel, sigma in self.sigma.items():
            self._check_sigma(channel, sigma)
        require_increasing(self.time_s, self.name)

    def __repr__(self) -> str:
        return f"Trajectory({self.name}: {len(self.time_s)} rows to {self.time_s[-1]:g} s, {', '.join(self.channels)})"

    def to_frame(self) -> DataFrame:
        """The motion as a pandas frame, one row a picture; units in `frame.attrs["units"]`.

        Returns
        -------
        pandas.DataFrame
            time_s, each channel followed by its sigma_..., and status where there is one; NaN where nothing was seen.
        """
        return frame_of(_columns(self), name=self.name)

    @classmethod
    def from_frame(cls, frame: DataFrame, name: str | None = None) -> Trajectory:
        """A trajectory from a pandas frame with the columns of the CSV file.

        Raises
        ------
        InputError
            No time_s, no channel at all, an unknown column, time that does not increase.
        """
        called = name or str(frame.attrs.get("name", "frame"))
        columns = columns_of(frame, called)
        _require_known(called, list(columns))
        seen = {key: np.asarray(values, dtype=float) for key, values in columns.items() if key != "status"}
        channels = {key: seen[key] for key in CHANNELS if key in seen}
        sigma = {channel: seen[key] for key, channel in _SIGMA.items() if key in seen}
        return cls(seen["time_s"], channels, sigma, [str(word) for word in columns.get("status", ())], name=called)

    def _check(self, channel: str, values: Array) -> None:
        if channel not in CHANNELS:
            raise InputError(f'{self.name}: "{channel}" is not a channel of a trajectory; {nearest(channel, CHANNELS)}')
        require_equal_lengths(self.name, {"time_s": self.time_s, channel: values})
        require_no_infinity(values, channel, self.name)

    def _check_sigma(self, channel: str, sigma: Array) -> None:
        if channel not in self.channels:
            raise InputError(f"{self.name}: sigma_{channel} stands without {channel}; give the channel too, or leave its sigma away.")
        if np.any(sigma <= 0):
            row = int(np.argmax(sigma <= 0))
            raise InputError(
                f"{self.name}, line {row + 2}: sigma_{channel} is {sigma[row]:g}; a standard deviation is above zero, or empty."
            )


def read_trajectory(path: Path) -> Trajectory:
    """Read a trajectory; empty cells of a channel are what was not seen.

    Parameters
    ----------
    path : Path or str
        A CSV file with `time_s` and any of the six channels, each with its `sigma_` where it is known.

    Returns
    -------
    Trajectory
        Channels of n rows as arrays (n,), in SI; not a number where nothing was seen.

    Raises
    ------
    InputError
        No time_s, no channel at all, an unknown column, a cell that is not a number, time that does not increase.
    """
    return trajectory_of(read_columns(Path(path), WORDS))


def trajectory_of(table: RawTable) -> Trajectory:
    """The trajectory that stands in the columns of a CSV file; see `read_trajectory`."""
    _require_known(f"{table.path}, line 1", table.header)
    channels = {name: numbers(table, name, empty=True) for name in CHANNELS if name in table.header}
    sigma = {channel: numbers(table, name, empty=True) for name, channel in _SIGMA.items() if name in table.header}
    return Trajectory(numbers(table, "time_s"), channels, sigma, table.words.get("status", ()), name=str(table.path))


def _require_known(place: str, header: Sequence[str]) -> None:
    if "time_s" not in header:
        raise InputError(no_time(place, header))
    known = ("time_s", *CHANNELS, *_SIGMA, "status")
    for name in header:
        if name not in known:
            raise InputError(f'{place}: unknown column "{clipped(name)}"; {nearest(name, known)}')
    if not any(name in CHANNELS for name in header):
        raise InputError(f"{place}: no channel beside time_s; give at least one of {', '.join(CHANNELS)}.")


def write_trajectory(trajectory: Trajectory, path: Path) -> None:
    """Write a trajectory, each channel followed by its sigma; what was not seen stays empty.

    Parameters
    ----------
    trajectory : Trajectory
        What is written.
    path : Path
        The CSV file; an older one is replaced as a whole.
    """
    write_columns(_columns(trajectory), path)


def _columns(trajectory: Trajectory) -> dict[str, Array | Sequence[str]]:
    columns: dict[str, Array | Sequence[str]] = {"time_s": trajectory.time_s}
    for channel in CHANNELS:
        if channel in trajectory.channels:
            columns[channel] = trajectory.channels[channel]
        if channel in trajectory.sigma:
            columns[f"sigma_{channel}"] = trajectory.sigma[channel]
    if len(trajectory.status):
        columns["status"] = trajectory.status
    return columns
