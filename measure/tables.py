"""The two tables everybody exchanges: a force-elongation loop and a platform trajectory.

CSV with a comma, a point, UTF-8 and one header row; every column carries its unit. Foreign loop files are brought
into this form by `measure.foreign`.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .errors import InputError, nearest
from .output import replacing

Array = NDArray[np.floating]

CHANNELS = ("x_m", "y_m", "z_m", "theta_x_rad", "theta_y_rad", "theta_z_rad")
LOOP_COLUMNS = ("time_s", "elongation_m", "force_N")
_SIGMA = {f"sigma_{channel}": channel for channel in CHANNELS}


@dataclass(frozen=True)
class Loop:
    """Force against elongation of one actuator on a shaker, sample by sample.

    time_s, elongation_m, force_N : equal lengths, time strictly increasing, all finite. The elongation is positive
    when strip uncoils, the force positive when the actuator pushes.
    other : further columns as they stood in the file, by name (temperature, pressure ...).
    """

    time_s: Array
    elongation_m: Array
    force_N: Array
    name: str = "loop"
    other: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for column in LOOP_COLUMNS:
            _store(self, column, getattr(self, column))
            _require_finite(getattr(self, column), column, self.name)
        _require_equal_lengths(self.name, {c: getattr(self, c) for c in LOOP_COLUMNS})
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
                if channel not in CHANNELS:
                    raise InputError(f'{self.name}: "{channel}" is not a channel of a trajectory; {nearest(channel, CHANNELS)}')
                _require_equal_lengths(self.name, {"time_s": self.time_s, channel: values})
                _require_no_infinity(values, channel, self.name)
        if len(self.status) not in (0, len(self.time_s)):
            raise InputError(f"{self.name}: status has {len(self.status)} rows and time_s {len(self.time_s)}; give one a row.")
        for channel, sigma in self.sigma.items():
            if np.any(sigma <= 0):
                row = int(np.argmax(sigma <= 0))
                raise InputError(
                    f"{self.name}, row {row + 2}: sigma_{channel} is {sigma[row]:g}; a standard deviation is above zero, or empty."
                )
        _require_increasing(self.time_s, self.name)


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
    """Read a loop in this project's own columns.

    Raises
    ------
    InputError
        A column is missing, a cell is not a number, a row has too few or too many cells, time does not increase.
    """
    header, rows = _read_cells(Path(path))
    missing = [column for column in LOOP_COLUMNS if column not in header]
    if missing:
        raise InputError(_no_column(Path(path), missing[0], header))
    columns = {name: _numbers(path, header, rows, name) for name in header if name in LOOP_COLUMNS}
    other = {name: values for name in header if name not in LOOP_COLUMNS and (values := _numbers_or_none(header, rows, name)) is not None}
    return Loop(**columns, name=str(path), other=other)


def read_trajectory(path: Path) -> Trajectory:
    """Read a trajectory; empty cells of a channel are what was not seen.

    Raises
    ------
    InputError
        No time_s, no channel at all, an unknown column, a cell that is not a number, time that does not increase.
    """
    path = Path(path)
    header, rows = _read_cells(path)
    if "time_s" not in header:
        raise InputError(_no_column(path, "time_s", header))
    known = ("time_s", *CHANNELS, *_SIGMA, "status")
    for name in header:
        if name not in known:
            raise InputError(f'{path}, line 1: unknown column "{name}"; {nearest(name, known)}')
    channels = {name: _numbers(path, header, rows, name, empty=True) for name in CHANNELS if name in header}
    if not channels:
        raise InputError(f"{path}, line 1: no channel beside time_s; give at least one of {', '.join(CHANNELS)}.")
    sigma = {channel: _numbers(path, header, rows, name, empty=True) for name, channel in _SIGMA.items() if name in header}
    status = [row[header.index("status")] for row in rows] if "status" in header else ()
    return Trajectory(_numbers(path, header, rows, "time_s"), channels, sigma, status, name=str(path))


def read_table(path: Path) -> Loop | Trajectory:
    """Read either table; which one it is shows in its columns."""
    header, _ = _read_cells(Path(path))
    if "force_N" in header or "elongation_m" in header:
        return read_loop(path)
    return read_trajectory(path)


def write_loop(loop: Loop, path: Path) -> None:
    """Write a loop, further columns behind the three."""
    _write(path, {**{c: getattr(loop, c) for c in LOOP_COLUMNS}, **loop.other})


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
    _write(path, columns)


def write_columns(columns: Mapping[str, Iterable], path: Path) -> None:
    """Write any table of numbers and words by the same rules: NaN as an empty cell, formulas in words disarmed."""
    _write(path, columns)


def _write(path: Path, columns: Mapping[str, Iterable]) -> None:
    with replacing(Path(path)) as temporary, open(temporary, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for row in zip(*columns.values(), strict=True):
            writer.writerow([_cell(value) for value in row])


def _cell(value: object) -> str:
    if isinstance(value, str):
        return "'" + value if value[:1] in ("=", "+", "-", "@") else value
    if isinstance(value, int | np.integer):
        return str(int(value))
    number = float(value)  # type: ignore[arg-type]
    return "" if np.isnan(number) else repr(number)


def _read_cells(path: Path) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a CSV, every row with as many cells as the header."""
    from .command import existing_file

    existing_file(path, what="a table (CSV)")
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            lines = list(csv.reader(file))
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: is not a CSV in UTF-8 ({error}). Export it again as comma-separated text.") from error
    if not lines or not any(lines[0]):
        raise InputError(f"{path}, line 1: no header row; the first line must name the columns, such as time_s.")
    header = [name.strip() for name in lines[0]]
    if len(set(header)) < len(header):
        double = next(name for name in header if header.count(name) > 1)
        raise InputError(f'{path}, line 1: two columns are named "{double}"; rename one.')
    rows = []
    for number, row in enumerate(lines[1:], start=2):
        if not row and number == len(lines):
            continue
        if len(row) != len(header):
            raise InputError(f"{path}, line {number}: {len(row)} cells and {len(header)} columns; the file is cut or a cell holds a comma.")
        rows.append(row)
    return header, rows


def _no_column(path: Path, missing: str, header: Sequence[str]) -> str:
    quantity = missing.rsplit("_", 1)[0]
    found = ", ".join(f'"{name}"' for name in header)
    return (
        f"{path}, line 1: no column for the {quantity}; found {found}.\n"
        f'Add --column {quantity}="..." (and --unit {quantity}=...), or rename it to {missing}.'
        if missing in LOOP_COLUMNS
        else f"{path}, line 1: no column {missing}; found {found}."
    )


def _numbers(path: Path, header: Sequence[str], rows: Sequence[Sequence[str]], name: str, *, empty: bool = False) -> Array:
    place = header.index(name)
    values = np.empty(len(rows))
    for i, row in enumerate(rows):
        cell = row[place].strip()
        try:
            values[i] = float(cell) if cell or not empty else np.nan
        except ValueError:
            raise InputError(f'{path}, line {i + 2}: {name} is "{cell}", which is not a number. Mend the cell or remove the row.') from None
        if empty and cell and np.isnan(values[i]):
            raise InputError(f'{path}, line {i + 2}: {name} is "{cell}". Leave the cell empty where nothing was seen.')
    return values


def _numbers_or_none(header: Sequence[str], rows: Sequence[Sequence[str]], name: str) -> Array | None:
    place = header.index(name)
    try:
        return np.array([float(row[place]) for row in rows])
    except ValueError:
        return None
