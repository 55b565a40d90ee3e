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
from measure.common.errors import InputError, clipped, nearest
from measure.common.inputs import LARGEST_TABLE, existing_file
from measure.readers.column_mapping import QUANTITIES, ColumnMapping
from measure.readers.guarded import read_hdf5, read_matlab
from measure.readers.labview import read_lvm, read_tdms
from measure.readers.stated_conditions import Claim, claims, conditions
from measure.readers.text_table import read_text_table
from measure.readers.time_axis import in_order, remarks
from measure.tables.checks import listed
from measure.tables.loop import Loop
from measure.tables.raw_table import RawTable
from measure.tables.units import (
    FACTORS,
    SI,
    Unit,
    quantity_of,
    split_unit,
    unit_of,
)

_HDF5 = b"\x89HDF\r\n\x1a\n"


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
    """Read a loop from a laboratory's text file; also this project's own columns.

    Raises
    ------
    InputError
        Not text, more than one possible reading, no column or no unit for a quantity, a cell that is no number.
    """
    path, wanted = Path(path), mapping or ColumnMapping()
    existing_file(path, what="a table of force and elongation", most=LARGEST_TABLE)
    table = _table(path, wanted)
    columns = {q: place for q in QUANTITIES if (place := _place(path, table, wanted, q)) is not None}
    units = {q: _unit(path, table, place, wanted, q) for q, place in columns.items()}
    values = {q: _numbers(table, place, q) * units[q].factor for q, place in columns.items()}
    if "time" not in values:
        values["time"] = np.arange(len(table)) * float(wanted.sample_period_s or 0.0)
    further = _other(table, set(columns.values()))
    ordered, said = in_order({**values, **{f"other {name}": v for name, v in further.items()}}, table.where)
    other = {name: ordered[f"other {name}"] for name in further}
    claimed = claims(path, table.notes, other)
    known = conditions(path, table.notes, wanted.name_pattern)
    other = {**{name: np.full(len(ordered["time"]), value) for name, value in known.items()}, **other}
    said += remarks(ordered["time"]) + _other_clock(other, columns, wanted.sample_period_s)
    loop = Loop(ordered["time"], ordered["elongation"], ordered["force"], name=str(path), other=other, remarks=said)
    return loop, Understood(str(path), table, columns, units, wanted.sample_period_s, claimed)


def _table(path: Path, wanted: ColumnMapping) -> RawTable:
    """The file as a table; what kind it is shows in its first bytes, its name only where they leave it open."""
    with open(path, "rb") as file:
        head = file.read(520)
    if head.startswith(b"MATLAB 7.3") or _HDF5 in (head[:8], head[512:]):
        return read_hdf5(path)
    if head.startswith(b"MATLAB 5.0 MAT-file") or path.suffix.lower() == ".mat":
        return read_matlab(path)
    if head.startswith(b"TDSm"):
        return read_tdms(path)
    if head.removeprefix(b"\xef\xbb\xbf").startswith(b"LabVIEW Measurement"):
        return read_lvm(path, wanted.encoding)
    return read_text_table(path, wanted.delimiter, wanted.decimal, wanted.encoding, wanted.header)


def _place(path: Path, table: RawTable, wanted: ColumnMapping, quantity: str) -> int | None:
    """Index of the column of a quantity; None for a time that is given by the sample period."""
    if quantity in wanted.columns:
        return _named(path, table, str(wanted.columns[quantity]), quantity)
    if quantity == "time" and wanted.sample_period_s is not None:
        return None
    names = [split_unit(name)[0].strip().lower() for name in table.header]
    found = [place for place, name in enumerate(names) if name == quantity]
    if len(found) == 1:
        return found[0]
    raise InputError(_missing(path, table, quantity, len(found)))


def _named(path: Path, table: RawTable, name: str, quantity: str) -> int:
    found = [place for place, header in enumerate(table.header) if header == name]
    size = len(table.columns)
    if len(found) == 1:
        return found[0]
    if not found and name.isdecimal() and 1 <= int(name) <= size:
        return int(name) - 1
    if len(found) > 1:
        raise InputError(f'{path}: {len(found)} columns are named "{name}"; give --column {quantity}=NUMBER, counted from 1.')
    hint = nearest(name, table.header) if table.header else f"the file has no header; give a number from 1 to {size}."
    raise InputError(f'{path}: no column "{name}" for the {quantity}; {hint}')


def _missing(path: Path, table: RawTable, quantity: str, found: int) -> str:
    own = f"{quantity}_{SI[quantity]}"
    period = " or --sample-period SECONDS" if quantity == "time" else ""
    if not table.header:
        first = ", ".join(clipped(cell, 40) for cell in table.first_row[:20])
        return (
            f"{path}: no header, so no column for the {quantity}; its first row reads {first}.\n"
            f"Add --column {quantity}=NUMBER (counted from 1) --unit {quantity}=UNIT{period}."
        )
    what = f"no column for the {quantity}" if not found else f"{found} columns for the {quantity}"
    likely = [name for place, name in enumerate(table.header) if quantity_of(_written_unit(table, place)) == quantity]
    name, unit = (likely[0], _written_unit(table, table.header.index(likely[0]))) if likely else ("NAME", "UNIT")
    advice = f'Add --column {quantity}="{name}" --unit {quantity}={unit}{period}, or rename it to {own}.'
    place = f", line {table.header_line}" if table.lines else ""
    notes = f"\nIt also holds {', '.join(clipped(note, 80) for note in table.notes[:12])}." if place == "" and table.notes else ""
    return f"{path}{place}: {what}; found {listed(table.header)}.\n{advice}{notes}"


def _written_unit(table: RawTable, place: int) -> str:
    return (table.units[place] if table.units else "") or (split_unit(table.header[place])[1] if table.header else "")


def _unit(path: Path, table: RawTable, place: int, wanted: ColumnMapping, quantity: str) -> Unit:
    """The unit that was given, or else the one that stands in the file."""
    if quantity in wanted.units:
        return unit_of(quantity, str(wanted.units[quantity]))
    written = _written_unit(table, place)
    if written in FACTORS[quantity]:
        return unit_of(quantity, written)
    found = f'"{written}" is none known here' if written else "none stands there"
    raise InputError(
        f"{path}: which unit is the {quantity} in, column {place + 1} {_quoted(table, place)}? {found[0].upper()}{found[1:]}. "
        f"Add --unit {quantity}=UNIT, one of {', '.join(FACTORS[quantity])}, or V*FACTOR."
    )


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
