"""A table of numbers in a text file: lines above it, names, units, and rows of which every one must have the same number of cells."""

from __future__ import annotations

import csv
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from measure.common.errors import InputError
from measure.readers.text_dialect import MOST_SNIFFED, Reading, reading_of
from measure.readers.text_encoding import decoded
from measure.tables.csv_cells import MOST_COLUMNS, TOO_LONG
from measure.tables.number_columns import NumberColumns, RaggedRow
from measure.tables.raw_table import RawTable
from measure.tables.text_lines import TextLines


def read_text_table(
    path: Path, delimiter: str | None = None, decimal: str | None = None, encoding: str | None = None, header: bool | None = None
) -> RawTable:
    """Read a table of numbers from a text file.

    Parameters
    ----------
    delimiter, decimal : as the options have them; found from the file where not given.
    encoding : found from the file where not given: its byte order mark, else UTF-8, else Windows-1252.
    header : False takes every row for numbers.

    Raises
    ------
    InputError
        Not text, no table, two possible readings, a row with another number of cells.
    """
    text, used_encoding = decoded(path, encoding)
    lines = TextLines(text)
    del text  # the lines may hold a copy of it
    if not len(lines):
        raise InputError(f"{path}: is empty. Export the loop again.")
    body = lines.last(max(20, min(MOST_SNIFFED, len(lines) * 2 // 3)))
    try:
        reading = reading_of(path, body, delimiter, decimal)
        return _table(path, lines, reading, used_encoding, header)
    except csv.Error:
        raise InputError(f"{path}: {TOO_LONG}. Export it as comma-separated text.") from None


@dataclass(frozen=True)
class _Head:
    """What stands above the first row of numbers: its lines, their cells, how many of them stand above the names, names and units."""

    lines: list[str]
    cells: list[list[str]]
    above: int
    names: list[str]
    units: list[str]

    @property
    def start(self) -> int:
        return len(self.lines)


_NO_HEAD = _Head([], [], 0, [], [])


def _table(path: Path, lines: TextLines, reading: Reading, encoding: str, header: bool | None) -> RawTable:
    size = _usual_size(lines, reading)
    head = _head(lines, reading, size) if header is not False else _NO_HEAD
    if size > MOST_COLUMNS:
        raise InputError(f"{path}: has {size} columns; a table of a test has at most {MOST_COLUMNS}. Export those that are needed.")
    columns = _columns(path, lines, reading, size, head.start)
    if head.start and not head.names and any(head.cells[-1]):
        raise InputError(
            f"{path}, line {head.start}: {len(head.cells[-1])} names stand above {size} columns, so which is which is not sure. "
            "Mend the header, or remove it and give the columns by number."
        )
    keep = [k for k in range(size) if columns.filled[k]]
    first = reading.dialect.split(next(lines.blocks(head.start))[0])
    written = f"{encoding}, delimiter {reading.delimiter}, decimal {reading.decimal}"
    return RawTable(
        path,
        [columns.values[k] for k in keep],
        header=tuple(head.names[k] for k in keep) if head.names else (),
        units=tuple(head.units[k] for k in keep) if head.units else (),
        written=written,
        notes=tuple(head.lines[: head.above]),
        lines=range(head.start + 1, len(lines) + 1),
        header_line=head.above + 1 if head.names else 0,
        odd=[columns.odd[k] for k in keep],
        first_row=tuple(first[k] for k in keep),
    )


def _usual_size(lines: TextLines, reading: Reading) -> int:
    """The number of cells that most lines have."""
    sizes: Counter[int] = Counter()
    for block in lines.blocks():
        sizes.update(reading.dialect.sizes(block))
    return sizes.most_common(1)[0][0]


def _head(lines: TextLines, reading: Reading, size: int) -> _Head:
    """The lines above the first row of numbers; nothing where there is no such row."""
    above: list[str] = []
    cells: list[list[str]] = []
    for block in lines.blocks():
        for line in block:
            row = reading.dialect.split(line)
            if len(row) == size and reading.is_data(row):
                return _named(above, cells, size)
            above.append(line)
            cells.append(row)
    return _NO_HEAD


def _named(lines: list[str], cells: list[list[str]], size: int) -> _Head:
    """The names are the first row of the block of full rows that ends at the first number, the units the second."""
    first = len(cells)
    while first and len(cells[first - 1]) == size:
        first -= 1
    names, units = [*cells[first:], [], []][:2]
    return _Head(lines, cells, first, names, [cell.strip("[]() ") for cell in units])


def _columns(path: Path, lines: TextLines, reading: Reading, size: int, start: int) -> NumberColumns:
    columns = NumberColumns(size, len(lines) - start, reading.dialect)
    try:
        for block in lines.blocks(start):
            columns.add_lines(block)
    except RaggedRow as error:
        raise InputError(
            f"{path}, line {start + error.row + 1}: {error.found} cells where the other rows have {size}; the file is cut or a cell is "
            "missing. Remove the line or export the file again."
        ) from None
    return columns
