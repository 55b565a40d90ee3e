"""Which column of a file is time, elongation and force, and in which unit; all that is not sure is said at once, with what settles it."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from measure.common.errors import InputError, OptionsMissing, clipped, nearest
from measure.readers.column_mapping import QUANTITIES, ColumnMapping
from measure.readers.column_names import proposed, taken_for, written_unit
from measure.tables.checks import listed
from measure.tables.raw_table import RawTable
from measure.tables.units import FACTORS, SI, Unit, known_unit, quantity_of, split_unit, unit_of

_USUAL = {"time": "s", "elongation": "mm", "force": "N"}
_PERIOD = "--sample-period SECONDS"
_NUMBERED = re.compile(r"(?:.*\[\d+\]|column \d+|\d*)")
_LONGEST_TYPED = 60
_PLAIN = re.compile(r"[\w./()\[\] %-]+")


@dataclass(frozen=True)
class Chosen:
    """Place and unit of each quantity, and the sentence on columns that were taken by a usual name, or nothing."""

    columns: Mapping[str, int]
    units: Mapping[str, Unit]
    said: Sequence[str] = ()


def chosen_columns(table: RawTable, wanted: ColumnMapping) -> Chosen:
    """The columns of a loop.

    A column is taken if an option names it, if it is called `time`, `elongation` or `force`, or, where all the others are found as well,
    if it is the only one in a unit of the quantity and called by a word that test machines use for it.

    Raises
    ------
    OptionsMissing
        All quantities without a column or a unit, and the options that give them one.
    InputError
        No such column as was named; an unknown unit.
    """
    sure = {q: place for q in QUANTITIES if (place := _sure(table, wanted, q)) is not None}
    open_ = [q for q in QUANTITIES if q not in sure and not (q == "time" and wanted.sample_period_s is not None)]
    likely = {q: place for q in open_ if _often(table, q) == 0 and (place := taken_for(table, q)) is not None}
    missing = [] if len(likely) == len(open_) else open_
    places = {q: {**sure, **likely}[q] for q in QUANTITIES if q in sure or (q in likely and not missing)}
    units = {q: _unit(table, place, wanted, q) for q, place in places.items()}
    unknown = [q for q, unit in units.items() if unit is None]
    if missing or unknown:
        _refuse(table, wanted, places, missing, unknown)
    taken = " and ".join(f'column "{table.header[place]}" for the {q}' for q, place in likely.items())
    said = [f"taken by the usual names: {taken}; --column says otherwise"] if likely else []
    return Chosen(places, {q: unit for q, unit in units.items() if unit}, said)


def _sure(table: RawTable, wanted: ColumnMapping, quantity: str) -> int | None:
    """Place of a column that an option names, or that has the quantity's own name."""
    if quantity in wanted.columns:
        return _named(table, str(wanted.columns[quantity]), quantity)
    if quantity == "time" and wanted.sample_period_s is not None:
        return None
    return _own_names(table).index(quantity) if _often(table, quantity) == 1 else None


def _own_names(table: RawTable) -> list[str]:
    return [split_unit(name)[0].strip().lower() for name in table.header]


def _often(table: RawTable, quantity: str) -> int:
    return _own_names(table).count(quantity)


def _named(table: RawTable, name: str, quantity: str) -> int:
    found = [place for place, header in enumerate(table.header) if header == name]
    size = len(table.columns)
    if len(found) == 1:
        return found[0]
    if not found and name.isdecimal() and 1 <= int(name) <= size:
        return int(name) - 1
    if len(found) > 1:
        raise InputError(f'{table.path}: {len(found)} columns are named "{name}"; give --column {quantity}=NUMBER, counted from 1.')
    hint = nearest(name, table.header) if table.header else f"the file has no header; give a number from 1 to {size}."
    raise InputError(f'{table.path}: no column "{name}" for the {quantity}; {hint}')


def _unit(table: RawTable, place: int, wanted: ColumnMapping, quantity: str) -> Unit | None:
    """The unit that was given, or else the one that stands in the file; None where none does that is known."""
    if quantity in wanted.units:
        return unit_of(quantity, str(wanted.units[quantity]))
    written = written_unit(table, place)
    return unit_of(quantity, written) if known_unit(quantity, written) else None


def _refuse(table: RawTable, wanted: ColumnMapping, places: Mapping[str, int], missing: Sequence[str], unknown: Sequence[str]) -> None:
    """Say all that is not sure, and the options that settle it."""
    likely = _likely(table, missing if table.header else [q for q in QUANTITIES if q not in wanted.columns], list(places.values()))
    options = [option for q in missing for option in _options(table, wanted, q, likely.get(q))]
    options += [f"--unit {q}={_guess(table, places[q], q)}" for q in unknown]
    lines = [_no_columns(table, missing)] if missing else []
    lines += [_no_unit(table, places[q], q, alone=not lines) for q in unknown]
    unsure = ["the order of the columns"] if missing and not _says_something(table) else []
    open_units = [q for q in likely if q not in wanted.units and not known_unit(q, written_unit(table, likely[q]))]
    unsure += ["the units"] if open_units or unknown else []
    raise OptionsMissing("\n".join([*lines, _advice(table, missing, options, unsure)]), " ".join(options))


def _likely(table: RawTable, quantities: Sequence[str], taken: list[int]) -> dict[str, int]:
    """The likeliest column of each quantity by name; where there are no names, the columns in their order."""
    found: dict[str, int] = {}
    for quantity in quantities:
        place = proposed(table, quantity, [*taken, *found.values()])
        if place is not None:
            found[quantity] = place
    return found or ({} if taken or _says_something(table) else _in_order(table, quantities))


def _in_order(table: RawTable, quantities: Sequence[str]) -> dict[str, int]:
    """The first column that only grows as the time, and the others in their order."""
    grows = next((place for place, values in enumerate(table.columns) if np.all(np.diff(values) > 0.0)), -1)
    others = iter(place for place in range(len(table.columns)) if place != grows)
    places = {q: grows if q == "time" else next(others, -1) for q in quantities}
    return {q: place for q, place in places.items() if place >= 0}


def _says_something(table: RawTable) -> bool:
    """Whether there are names that are more than numbers of columns."""
    return any(not _NUMBERED.fullmatch(name) for name in table.header)


def _options(table: RawTable, wanted: ColumnMapping, quantity: str, place: int | None) -> list[str]:
    if place is None:
        return [_PERIOD] if quantity == "time" else [f"--column {quantity}=NAME", f"--unit {quantity}=UNIT"]
    unit = [] if quantity in wanted.units else [f"--unit {quantity}={_guess(table, place, quantity)}"]
    return [f"--column {quantity}={_shown(table, place)}", *unit]


def _guess(table: RawTable, place: int, quantity: str) -> str:
    """The unit in the file if it is one of the quantity, else the usual one."""
    written = written_unit(table, place)
    if known_unit(quantity, written):
        return written if _PLAIN.fullmatch(written) and written.isascii() else known_unit(quantity, written)
    return "UNIT" if written else _USUAL[quantity]


def _shown(table: RawTable, place: int) -> str:
    """A column as one types it: by its name, or by its number where the name is none, doubled or hard to type."""
    name = table.header[place] if table.header else ""
    if table.header.count(name) != 1 or not _PLAIN.fullmatch(name) or name.isdecimal() or len(name) > _LONGEST_TYPED:
        return str(place + 1)
    return name if shlex.quote(name) == name else f'"{name}"'


def _no_columns(table: RawTable, missing: Sequence[str]) -> str:
    if not table.header:
        first = ", ".join(clipped(cell, 40) for cell in table.first_row[:20])
        return f"{table.path}: no header, so {_none_for(table, missing)}; its first row reads {first}."
    place = f", line {table.header_line}" if table.lines else ""
    notes = f"\nIt also holds {', '.join(clipped(note, 80) for note in table.notes[:12])}." if place == "" and table.notes else ""
    return f"{table.path}{place}: {_none_for(table, missing)}; found {listed(table.header)}.{notes}"


def _none_for(table: RawTable, missing: Sequence[str]) -> str:
    """ "no column for the elongation and none for the force", "2 columns for the time"."""
    said: list[str] = []
    for quantity in missing:
        often = _often(table, quantity)
        none = "none" if any(text.startswith("no") for text in said) else "no column"
        said.append(f"{often} columns for the {quantity}" if often > 1 else f"{none} for the {quantity}")
    return " and ".join([", ".join(said[:-1]), said[-1]] if len(said) > 1 else said)


def _no_unit(table: RawTable, place: int, quantity: str, *, alone: bool) -> str:
    written = written_unit(table, place)
    name = f'"{table.header[place]}"' if table.header else "(no name)"
    file = f"{table.path}: " if alone else ""
    other = quantity_of(written)
    if other:
        return f"{file}the {quantity} is column {place + 1} {name}, and {written} is a unit of {other}: are two channels swapped?"
    found = f'"{written}" is none known here' if written else "None stands there"
    known = ", ".join(FACTORS[quantity])
    return f"{file}which unit is the {quantity} in, column {place + 1} {name}? {found}; known: {known}, or V*FACTOR."


def _advice(table: RawTable, missing: Sequence[str], options: Sequence[str], unsure: Sequence[str]) -> str:
    names = [f"{q}_{SI[q]}" for q in missing]
    rename = f", or rename {'it' if len(names) == 1 else 'them'} to {', '.join(names)}" if names and table.header else ""
    period = f" or {_PERIOD}" if "time" in missing and _PERIOD not in options else ""
    check = f" Not all of this stands in the file: check {' and '.join(unsure)}." if unsure else ""
    return f"Add {' '.join(options)}{period}{rename}.{check}"
