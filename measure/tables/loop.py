"""A force-elongation loop and its CSV file: comma, point, UTF-8, one header row, the unit in every name.

Foreign loop files are brought into this form by `measure.readers.loop_file`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.notebook.shown import Shown
from measure.tables.checks import listed, no_time, require_equal_lengths, require_finite, require_increasing
from measure.tables.csv_cells import numbers, numbers_if_they_are, read_columns, write_columns
from measure.tables.frames import columns_of, frame_of
from measure.tables.raw_table import RawTable

if TYPE_CHECKING:
    from pandas import DataFrame

LOOP_COLUMNS = ("time_s", "elongation_m", "force_N")


@dataclass(frozen=True, repr=False)
class Loop(Shown, by="measure.notebook.table_plots.ShowingLoop"):
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
            object.__setattr__(self, column, np.asarray(getattr(self, column), dtype=float))
            require_finite(getattr(self, column), column, self.name)
        object.__setattr__(self, "other", {name: np.asarray(values, dtype=float) for name, values in self.other.items()})
        require_equal_lengths(self.name, {**{c: getattr(self, c) for c in LOOP_COLUMNS}, **self.other})
        require_increasing(self.time_s, self.name)

    def __repr__(self) -> str:
        return f"Loop({self.name}: {len(self.time_s)} rows, {', '.join([*LOOP_COLUMNS, *self.other])[:200]})"

    def to_frame(self) -> DataFrame:
        """The samples as a pandas frame, one row each; units in `frame.attrs["units"]`.

        Returns
        -------
        pandas.DataFrame
            Columns time_s, elongation_m, force_N and the further ones.
        """
        return frame_of(_columns(self), name=self.name)

    @classmethod
    def from_frame(cls, frame: DataFrame, name: str | None = None) -> Loop:
        """A loop from a pandas frame with the columns time_s, elongation_m, force_N; other columns of numbers come along.

        Raises
        ------
        InputError
            A column is missing, a cell is not finite, time does not increase.
        """
        called = name or str(frame.attrs.get("name", "frame"))
        columns = columns_of(frame, called)
        for column in LOOP_COLUMNS:
            if column not in columns:
                raise InputError(_no_column(called, list(columns), column))
        other = {key: values for key, values in columns.items() if key not in LOOP_COLUMNS and not isinstance(values, list)}
        return cls(*(np.asarray(columns[column]) for column in LOOP_COLUMNS), name=called, other=other)


def _columns(loop: Loop) -> dict[str, Array]:
    return {**{column: getattr(loop, column) for column in LOOP_COLUMNS}, **loop.other}


def read_loop(path: Path) -> Loop:
    """Read a loop in this project's own columns; further columns of numbers come along, those of words do not.

    Parameters
    ----------
    path : Path or str
        A CSV file with `time_s`, `elongation_m` and `force_N`.

    Returns
    -------
    Loop
        Each column of n rows as an array (n,), in SI.

    Raises
    ------
    InputError
        A column is missing, a cell is not a number, a row has too few or too many cells, time does not increase.
    """
    return loop_of(read_columns(Path(path)))


def loop_of(table: RawTable) -> Loop:
    """The loop that stands in the columns of a CSV file; see `read_loop`."""
    for column in LOOP_COLUMNS:
        if column not in table.header:
            raise InputError(_no_column(f"{table.path}, line 1", table.header, column))
    time, elongation, force = (numbers(table, name) for name in LOOP_COLUMNS)
    further = {name: numbers_if_they_are(table, name) for name in table.header if name not in LOOP_COLUMNS}
    other = {name: values for name, values in further.items() if values is not None}
    return Loop(time, elongation, force, name=str(table.path), other=other)


def _no_column(place: str, header: Sequence[str], missing: str) -> str:
    if missing == "time_s":
        return no_time(place, header)
    quantity = missing.rsplit("_", 1)[0]
    return (
        f"{place}: no column for the {quantity}; found {listed(header)}.\n"
        f'Add --column {quantity}="..." (and --unit {quantity}=...), or rename it to {missing}.'
    )


def write_loop(loop: Loop, path: Path) -> None:
    """Write a loop, further columns behind the three.

    Parameters
    ----------
    loop : Loop
        What is written.
    path : Path
        The CSV file; an older one is replaced as a whole.
    """
    write_columns(_columns(loop), path)
