"""A table of this project whose kind shows in its columns."""

from __future__ import annotations

from pathlib import Path

from measure.tables.csv_cells import read_cells
from measure.tables.loop import Loop, loop_of
from measure.tables.trajectory import Trajectory, trajectory_of


def read_table(path: Path) -> Loop | Trajectory:
    """Read either table; which one it is shows in its columns."""
    cells = read_cells(Path(path))
    return loop_of(cells) if {"force_N", "elongation_m"} & set(cells.header) else trajectory_of(cells)
