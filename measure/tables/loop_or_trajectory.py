"""A table of this project whose kind shows in its columns."""

from __future__ import annotations

from pathlib import Path

from measure.tables.csv_cells import read_columns
from measure.tables.loop import Loop, loop_of
from measure.tables.trajectory import WORDS, Trajectory, trajectory_of


def read_table(path: Path) -> Loop | Trajectory:
    """Read either table; which one it is shows in its columns.

    Parameters
    ----------
    path : Path or str
        A CSV file in this project's own columns.

    Returns
    -------
    Loop or Trajectory
        A loop where the table has a force or an elongation, in SI.

    Raises
    ------
    InputError
        A column is missing or unknown, a cell is not a number, time does not increase.
    """
    table = read_columns(Path(path), WORDS)
    return loop_of(table) if {"force_N", "elongation_m"} & set(table.header) else trajectory_of(table)
