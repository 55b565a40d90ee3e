"""The table that Tracker (Open Source Physics) exports: the name of a track, the names t, x, y, and numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, OptionsMissing
from measure.readers.column_mapping import ColumnMapping
from measure.readers.column_names import name_fits
from measure.readers.text.encoding import decoded
from measure.readers.trajectories.rows import numbers_below, require_every_time
from measure.tables.number_columns import Dialect
from measure.tables.text_lines import TextLines
from measure.tables.trajectory import Trajectory
from measure.tables.units import quantity_of, split_unit, unit_of

_QUANTITIES = {"t": "time", "x": "position", "y": "position", "theta": "angle"}
_NAME = re.compile(r"(?P<name>[^\[(]*+)(?:[\[(](?P<unit>[^\])]*+)[\])])?")
_MOST_ABOVE = 3  # lines above that of the names


@dataclass(frozen=True)
class TrackerHead:
    """Where the names stand: the line counted from zero, the sign between two cells, all cells, and those that are read.

    found : name, column and unit of each of t, x, y, theta, in the order of the columns.
    """

    line: int
    separator: str
    cells: Sequence[str]
    found: Sequence[tuple[str, int, str]]


def tracker_head(text: str) -> TrackerHead | None:
    """The head of such a table, or None where the first lines hold no t, x and y, or a force beside them: that is a loop."""
    for line, shown in enumerate(text.split("\n", _MOST_ABOVE + 1)[: _MOST_ABOVE + 1]):
        for separator in "\t;,":
            cells = [cell.strip(' "\r') for cell in shown.split(separator)]
            named = [(k, _NAME.fullmatch(cell.replace("θ", "theta"))) for k, cell in enumerate(cells)]
            found = [(m["name"].rstrip(), k, (m["unit"] or "").strip()) for k, m in named if m and m["name"].rstrip() in _QUANTITIES]
            if {"t", "x", "y"} <= {name for name, _, _ in found} and not any(map(_is_force, cells)):
                return TrackerHead(line, separator, cells, found)
    return None


def _is_force(cell: str) -> bool:
    name, unit = split_unit(cell)
    return quantity_of(unit) == "force" or name_fits(name, "force") > 1


def read_tracker_table(path: Path, wanted: ColumnMapping) -> Trajectory:
    """Read x and y as x_m and z_m, theta as the rotation theta_y about the view, each against its first row.

    Tracker counts angles anticlockwise as the camera sees them, a trajectory about the axis that points away from it: theta_y = -theta.

    Raises
    ------
    InputError
        Several tracks, a unit that neither the file nor an option names, a cell that is not a number, no row.
    """
    lines = TextLines(decoded(path, wanted.encoding)[0])
    head = tracker_head(lines.text)
    if head is None:
        raise InputError(f"{path}: no line with the names t, x and y. Export the track again, with its names.")
    places = {name: column for name, column, _ in head.found}
    if len(places) < len(head.found):
        raise InputError(f"{path}, line {head.line + 1}: holds several tracks. Export the one on the platform by itself.")
    factors = _factors(path, head, wanted)
    below = lines.text.split("\n", head.line + 1)[-1]
    comma = wanted.decimal in ("comma", ",") if wanted.decimal else head.separator != "," and "," in below
    table = numbers_below(path, lines, head.line + 1, list(head.cells), Dialect(head.separator, comma))
    require_every_time(path, table, places["t"])
    return _trajectory(path, {name: table.values[column] * factors[name] for name, column in places.items()})


def _factors(path: Path, head: TrackerHead, wanted: ColumnMapping) -> dict[str, float]:
    """What makes SI of each column. Seconds are Tracker's own; of lengths and angles somebody must say."""
    units = {name: str(wanted.units.get(_QUANTITIES[name], "")) or unit or ("s" if name == "t" else "") for name, _, unit in head.found}
    missing = list(dict.fromkeys(_QUANTITIES[name] for name, unit in units.items() if not unit))
    if missing:
        options = " ".join(f"--unit {quantity}=UNIT" for quantity in missing)
        raise OptionsMissing(
            f"{path}: does not say in what unit {' and '.join(missing)} are. Add {options}, such as position=m, angle=deg.", options
        )
    try:
        return {name: unit_of(_QUANTITIES[name], unit).factor for name, unit in units.items()}
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _trajectory(path: Path, found: Mapping[str, Array]) -> Trajectory:
    seen = np.isfinite(found["x"]) & np.isfinite(found["y"])
    if not seen.any():
        raise InputError(f"{path}: the track is seen in no row. Export it again.")
    rows = slice(int(np.argmax(seen)), None)
    channels = {"x_m": found["x"], "z_m": found["y"], **({"theta_y_rad": -found["theta"]} if "theta" in found else {})}
    moved = {name: column[rows] - column[rows][np.isfinite(column[rows])][:1] for name, column in channels.items()}
    return Trajectory(found["t"][rows], moved, name=str(path))
