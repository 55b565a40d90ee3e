"""A measurement in whatever form it comes: a trajectory, of this project or another program, or a loop as a laboratory wrote it."""

from __future__ import annotations

from pathlib import Path

from measure.readers.column_mapping import ColumnMapping
from measure.readers.loop_file import read_loop_file
from measure.readers.trajectories.foreign import read_foreign_trajectory
from measure.tables.loop import LOOP_COLUMNS, Loop
from measure.tables.loop_or_trajectory import read_table
from measure.tables.trajectory import CHANNELS, Trajectory
from measure.tables.units import quantity_of, split_unit

_FIRST_BYTES = 10_000


def read_measurement(path: Path, mapping: ColumnMapping | None = None) -> Loop | Trajectory:
    """Read a trajectory or a loop; the mapping concerns loops and trajectories of other programs, not those in the project's columns.

    Parameters
    ----------
    path : Path or str
        A table.
    mapping : ColumnMapping, optional
        Which columns are the quantities, and in which units, where names do not say it.

    Returns
    -------
    Loop or Trajectory
        In SI, as the columns tell.

    Raises
    ------
    InputError
        What `read_table` refuses of the project's own tables, `read_foreign_trajectory` of those of other programs, and
        `read_loop_file` of all others.
    """
    path, wanted = Path(path), mapping or ColumnMapping()
    foreign = read_foreign_trajectory(path, wanted)
    if foreign is not None:
        return foreign
    header = _first_cells(path)
    own_loop = wanted == ColumnMapping() and set(LOOP_COLUMNS) <= header
    if not path.is_file() or own_loop or _is_trajectory(header, wanted):
        return read_table(path)
    return read_loop_file(path, wanted)[0]


def _first_cells(path: Path) -> set[str]:
    """The cells of the first line as a CSV has them; of a file of another kind, something that means nothing."""
    if not path.is_file():
        return set()
    with open(path, "rb") as file:
        line = file.read(_FIRST_BYTES).split(b"\n")[0]
    return {cell.strip(' "\r') for cell in line.decode("utf-8-sig", errors="replace").split(",")}


def _is_trajectory(header: set[str], wanted: ColumnMapping) -> bool:
    """Whether a channel of a trajectory stands there; or at least a time, no force, and no mapping that speaks of one."""
    forces = [name for name in header if quantity_of(split_unit(name)[1]) == "force"]
    return bool(header & set(CHANNELS)) or ("time_s" in header and not forces and not wanted.columns)
