"""Tables of markers of OpenSim and of motion capture (.trc): text, tabs, five lines of head."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from measure.common.errors import InputError
from measure.readers.text.encoding import decoded
from measure.readers.trajectories.markers import Markers
from measure.readers.trajectories.rows import numbers_below, require_every_time
from measure.tables.csv_cells import MOST_COLUMNS
from measure.tables.number_columns import Dialect
from measure.tables.text_lines import TextLines

_HEAD = 5  # lines


def read_trc(path: Path, encoding: str | None = None) -> Markers:
    """Read a table of markers; empty cells, NaN and three exact zeros are what was not seen. It does not say which axis is up.

    Raises
    ------
    InputError
        The head or a row is not that of such a table, a cell is not a number.
    """
    lines = TextLines(decoded(path, encoding)[0])
    head = next(lines.blocks(), [])[:_HEAD]
    if len(lines) < _HEAD + 2 or not head[0].startswith("PathFileType"):
        raise InputError(f"{path}: is no table of markers: five lines of head and two of numbers are the least. Export it again as .trc.")
    stated = dict(zip(_cells(head[1]), _cells(head[2]), strict=False))
    names = tuple(name for name in _cells(head[3])[2:] if name)
    most = (MOST_COLUMNS - 2) // 3
    if not names or len(set(names)) < len(names) or len(names) > most:
        raise InputError(f"{path}, line 4: {len(names)} names of markers; 1 to {most} are needed, each once. Export it again as .trc.")
    columns = [f"{name} {axis}" for name in names for axis in "xyz"]
    table = numbers_below(path, lines, _HEAD, ["frame", "time", *columns], Dialect("\t"))
    require_every_time(path, table, 1)
    position = table.values[2:].T.reshape(-1, len(names), 3)
    unseen = (position == 0.0).all(axis=2, keepdims=True)
    return Markers(path, table.values[1], names, np.where(unseen, np.nan, position), stated.get("Units", ""))


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.split("\t")]
