"""Loop files as laboratories write them, brought into the columns of `measure.tables.loop.Loop`.

Nothing is guessed twice: what cannot be read in one way only stops with the option that settles it, and what was
understood can be shown and saved, one mapping file per rig.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, clipped
from measure.common.inputs import LARGEST_TABLE, existing_file
from measure.readers.chosen_columns import chosen_columns
from measure.readers.column_mapping import ColumnMapping
from measure.readers.raw_file import read_raw_table
from measure.readers.stated_conditions import Claim, claims, conditions
from measure.readers.time_axis import in_order, remarks
from measure.tables.loop import Loop
from measure.tables.raw_table import RawTable
from measure.tables.units import FACTORS, SI, Unit, split_unit


@dataclass(frozen=True)
class Understood:
    """What was understood of a file: how it is written, and which column and unit was taken for what."""

    file: str
    table: RawTable
    columns: Mapping[str, int]
    units: Mapping[str, Unit]
    sample_period_s: float | None
    claims: Sequence[Claim] = ()

    def sentences(self) -> list[str]:
        """For people: the dialect, the columns, and the first rows as numbers in SI."""
        table = self.table
        header = "" if not table.lines else f", header in line {table.header_line}" if table.header else ", no header"
        lines = [f"{self.file}: {table.written}{header}, {len(table)} rows"]
        for quantity, place in self.columns.items():
            unit = self.units[quantity]
            lines.append(f"  {quantity:<10} column {place + 1} {_quoted(table, place)}, unit {unit.text} = {unit.factor:g} {SI[quantity]}")
        if self.sample_period_s is not None:
            lines.append(f"  time       {self.sample_period_s:g} s from sample to sample, as given")
        for row in range(min(5, len(table))):
            shown = (f"{table.columns[place][row] * self.units[q].factor:.6g} {SI[q]}" for q, place in self.columns.items())
            lines.append("    " + "  ".join(shown))
        return lines


def _quoted(table: RawTable, place: int) -> str:
    return f'"{table.header[place]}"' if table.header else "(no name)"


def read_loop_file(path: Path, mapping: ColumnMapping | None = None) -> tuple[Loop, Understood]:
    """Read a loop from a laboratory's file; also this project's own columns.

    Parameters
    ----------
    path : Path or str
        Text, a workbook, MATLAB, HDF5, LabVIEW or a universal file.
    mapping : ColumnMapping, optional
        Which columns are the quantities, and in which units, where names do not say it.

    Returns
    -------
    Loop
        Each column of n rows as an array (n,), in SI; conditions that the file states as further columns.
    Understood
        How the file was read.

    Raises
    ------
    InputError
        Not text, more than one possible reading, no column or no unit for a quantity, a cell that is no number.
    """
    path, wanted = Path(path), mapping or ColumnMapping()
    existing_file(path, what="a table of force and elongation", most=LARGEST_TABLE)
    table = read_raw_table(path, wanted)
    chosen = chosen_columns(table, wanted)
    columns, units = chosen.columns, chosen.units
    values = {q: _numbers(table, place, q) * units[q].factor for q, place in columns.items()}
    if "time" not in values:
        values["time"] = np.arange(len(table)) * float(wanted.sample_period_s or 0.0)
    further = _other(table, set(columns.values()))
    ordered, said = in_order({**values, **{f"other {name}": v for name, v in further.items()}}, table.where)
    other = {name: ordered[f"other {name}"] for name in further}
    claimed = claims(path, table.notes, other)
    known = conditions(path, table.notes, wanted.name_pattern)
    other = {**{name: np.full(len(ordered["time"]), value) for name, value in known.items()}, **other}
    said += chosen.said
    said += remarks(ordered["time"]) + _other_clock(other, columns, wanted.sample_period_s)
    loop = Loop(ordered["time"], ordered["elongation"], ordered["force"], name=str(path), other=other, remarks=said)
    return loop, Understood(str(path), table, columns, units, wanted.sample_period_s, claimed)


def _numbers(table: RawTable, place: int, quantity: str) -> Array:
    odd = table.first_odd(place)
    if odd:
        found = f'"{clipped(odd.text)}"' if odd.text else "empty"
        raise InputError(f"{table.where(odd.row)}: the {quantity} is {found}, no number. Mend the cell or remove the row.")
    return table.columns[place]


def _other_clock(other: Mapping[str, Array], columns: Mapping[str, int], period_s: float | None) -> list[str]:
    """The sentence on a time that stands in the file and is not used because a sample period was given."""
    times = {name: v for name, v in other.items() if split_unit(name)[0].strip().lower() == "time"}
    if period_s is None or "time" in columns or not times:
        return []
    name, values = next(iter(times.items()))
    step = float(np.median(np.diff(values))) * FACTORS["time"].get(split_unit(name)[1], 1.0)
    differs = abs(step - period_s) > 0.02 * period_s
    return (
        [f'column "{name}" says {step:.4g} s from sample to sample, and {period_s:.4g} s were given; the given ones count']
        if differs
        else []
    )


def _other(table: RawTable, taken: set[int]) -> dict[str, Array]:
    """Further columns of numbers, by name or by number; of two with one name the first."""
    made: dict[str, Array] = {}
    for place, column in enumerate(table.columns):
        name = table.header[place] if table.header else f"column {place + 1}"
        if place not in taken and not table.first_odd(place, ("empty", "word")):
            made.setdefault(name, column)
    return made
