"""The two tables everybody exchanges: a force-elongation loop and a platform trajectory.

CSV with a comma, a point, UTF-8 and one header row; every column carries its unit. Foreign loop files are brought
into this form by `measure.readers.loop_file`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, nearest
from measure.tables.csv_cells import Cells, read_cells, write_cells

CHANNELS = ("x_m", "y_m", "z_m", "theta_x_rad", "theta_y_rad", "theta_z_rad")
LOOP_COLUMNS = ("time_s", "elongation_m", "force_N")
_SIGMA = {f"sigma_{channel}": channel for channel in CHANNELS}


@dataclass(frozen=True)
class Loop:
    """Force against elongation of one actuator on a shaker, sample by sample.

    time_s, elongation_m, force_N : equal lengths, time strictly increasing, all finite. The elongation is positive
    when strip uncoils, the force positive when the actuator pushes.
    other : further columns of numbers by name (temperature, pressure ...), each of the same length, NaN where empty.
    remarks : what was done to the file's rows on reading, in sentences.
    """

    time_s: Array
    elongation_m: Array
    force_N: Array
    name: str = "loop"
    other: Mapping[str, Array] = field(default_factory=dict)
    remarks: Sequence[str] = ()

    def __post_init__(self) -> None:
        for column in LOOP_COLUMNS:
            _store(self, column, getattr(self, column))
            _require_finite(getattr(self, column), column, self.name)
        object.__setattr__(self, "other", {name: np.asarray(values, dtype=float) for name, values in self.other.items()})
        _require_equal_lengths(self.name, {**{c: getattr(self, c) for c in LOOP_COLUMNS}, **self.other})
        _require_increasing(self.time_s, self.name)


@dataclass(frozen=True)
class Trajectory:
    """Motion of the platform against time, as far as it was seen.

    time_s : (n,) strictly increasing. channels : any of `CHANNELS`, each (n,), NaN where nothing was seen.
    sigma : one standard deviation for any of these channels, (n,), NaN where there is none.
    status : (n,) words, or empty.
    """

    time_s: Array
    channels: Mapping[str, Array]
    sigma: Mapping[str, Array] = field(default_factory=dict)
    status: Sequence[str] = ()
    name: str = "trajectory"

    def __post_init__(self) -> None:
        _store(self, "time_s", self.time_s)
        _require_finite(self.time_s, "time_s", self.name)
        for mapping in ("channels", "sigma"):
            made = {k: np.asarray(v, dtype=float) for k, v in getattr(self, mapping).items()}
            object.__setattr__(self, mapping, made)
            for channel, values in made.items():
                self._check(channel, values)
        if len(self.status) not in (0, len(self.time_s)):
            raise InputError(f"{self.name}: status has {len(self.status)} rows and time_s {len(self.time_s)}; give one a row.")
        for channel, sigma in self.sigma.items():
            self._check_sigma(channel, sigma)
        _require_increasing(self.time_s, self.name)

    def _check(self, channel: str, values: Array) -> None:
        if channel not in CHANNELS:
            raise InputError(f'{self.name}: "{channel}" is not a channel of a trajectory; {nearest(channel, CHANNELS)}')
        _require_equal_lengths(self.name, {"time_s": self.time_s, channel: values})
        _require_no_infinity(values, channel, self.name)

    def _check_sigma(self, channel: str, sigma: Array) -> None:
        if channel not in self.channels:
            raise InputError(f"{self.name}: sigma_{channel} stands without {channel}; give the channel too, or leave its sigma away.")
        if np.any(sigma <= 0):
            row = int(np.argmax(sigma <= 0))
            raise InputError(
                f"{self.name}, line {row + 2}: sigma_{channel} is {sigma[row]:g}; a standard deviation is above zero, or empty."
            )


def _store(table: Loop | Trajectory, column: str, values: object) -> None:
    object.__setattr__(table, column, np.asarray(values, dtype=float))


def _require_finite(values: Array, column: str, name: str) -> None:
    bad = ~np.isfinite(values)
    if np.any(bad):
        row = int(np.argmax(bad))
        raise InputError(
            f"{name}, line {row + 2}: {column} is {'empty or not a number' if np.isnan(values[row]) else values[row]} "
            f"({int(bad.sum())} of {len(values)} rows). Every row needs a finite {column}; remove these rows or mend them."
        )


def _require_no_infinity(values: Array, column: str, name: str) -> None:
    if np.any(np.isinf(values)):
        row = int(np.argmax(np.isinf(values)))
        raise InputError(f"{name}, line {row + 2}: {column} is infinite. Leave the cell empty where nothing was seen.")


def _require_equal_lengths(name: str, columns: Mapping[str, Array]) -> None:
    lengths = {column: values.shape for column, values in columns.items()}
    if len(set(lengths.values())) > 1 or any(len(shape) != 1 for shape in lengths.values()):
        raise InputError(f"{name}: columns differ in length: " + ", ".join(f"{c} {s}" for c, s in lengths.items()) + ".")


def _require_increasing(time_s: Array, name: str) -> None:
    if len(time_s) < 2:
        raise InputError(f"{name}: {len(time_s)} rows of data; at least two are needed.")
    step = np.diff(time_s)
    if np.any(step <= 0):
        row = int(np.argmax(step <= 0)) + 1
        raise InputError(
            f"{name}, line {row + 2}: time_s goes from {time_s[row - 1]:g} to {time_s[row]:g}; it must increase from row to row. "
            "Sort the rows and remove doubled ones."
        )


def read_loop(path: Path) -> Loop:
    """Read a loop in this project's own columns; further columns of numbers come along, those of words do not.

    Raises
    ------
    InputError
        A column is missing, a cell is not a number, a row has too few or too many cells, time does not increase.
    """
    return _loop_of(read_cells(Path(path)))


def _loop_of(cells: Cells) -> Loop:
    for column in LOOP_COLUMNS:
        if column not in cells.header:
            raise InputError(_no_column(cells, column))
    time, elongation, force = (cells.numbers(name) for name in LOOP_COLUMNS)
    further = {name: cells.numbers_if_they_are(name) for name in cells.header if name not in LOOP_COLUMNS}
    return Loop(
        time, elongation, force, name=str(cells.path), other={name: values for name, values in further.items() if values is not None}
    )


def read_trajectory(path: Path) -> Trajectory:
    """Read a trajectory; empty cells of a channel are what was not seen.

    Raises
    ------
    InputError
        No time_s, no channel at all, an unknown column, a cell that is not a number, time that does not increase.
    """
    return _trajectory_of(read_cells(Path(path)))


def _trajectory_of(cells: Cells) -> Trajectory:
    if "time_s" not in cells.header:
        raise InputError(_no_column(cells, "time_s"))
    known = ("time_s", *CHANNELS, *_SIGMA, "status")
    for name in cells.header:
        if name not in known:
            raise InputError(f'{cells.path}, line 1: unknown column "{name}"; {nearest(name, known)}')
    channels = {name: cells.numbers(name, empty=True) for name in CHANNELS if name in cells.header}
    if not channels:
        raise InputError(f"{cells.path}, line 1: no channel beside time_s; give at least one of {', '.join(CHANNELS)}.")
    sigma = {channel: cells.numbers(name, empty=True) for name, channel in _SIGMA.items() if name in cells.header}
    status = cells.words("status") if "status" in cells.header else ()
    return Trajectory(cells.numbers("time_s"), channels, sigma, status, name=str(cells.path))


def read_table(path: Path) -> Loop | Trajectory:
    """Read either table; which one it is shows in its columns."""
    cells = read_cells(Path(path))
    return _loop_of(cells) if {"force_N", "elongation_m"} & set(cells.header) else _trajectory_of(cells)


def _no_column(cells: Cells, missing: str) -> str:
    place = f"{cells.path}, line 1"
    found = ", ".join(f'"{name}"' for name in cells.header)
    if missing not in LOOP_COLUMNS[1:]:
        return f"{place}: no column {missing}; found {found}. Rename the column of the time, in seconds, to {missing}."
    quantity = missing.rsplit("_", 1)[0]
    return (
        f"{place}: no column for the {quantity}; found {found}.\n"
        f'Add --column {quantity}="..." (and --unit {quantity}=...), or rename it to {missing}.'
    )


def write_loop(loop: Loop, path: Path) -> None:
    """Write a loop, further columns behind the three."""
    write_cells({**{c: getattr(loop, c) for c in LOOP_COLUMNS}, **loop.other}, path)


def write_trajectory(trajectory: Trajectory, path: Path) -> None:
    """Write a trajectory, each channel followed by its sigma; what was not seen stays empty."""
    columns: dict[str, Iterable] = {"time_s": trajectory.time_s}
    for channel in CHANNELS:
        if channel in trajectory.channels:
            columns[channel] = trajectory.channels[channel]
        if channel in trajectory.sigma:
            columns[f"sigma_{channel}"] = trajectory.sigma[channel]
    if len(trajectory.status):
        columns["status"] = trajectory.status
    write_cells(columns, path)


def write_columns(columns: Mapping[str, Iterable], path: Path) -> None:
    """Write any table of numbers and words by the same rules: NaN as an empty cell, formulas in words disarmed."""
    write_cells(columns, path)
