"""A table of numbers in a text file: lines above it, names, units, and rows of which every one must have the same number of cells."""

from __future__ import annotations

import csv
from collections import Counter
from pathlib import Path

from measure.common.errors import InputError
from measure.readers.table_head import NO_HEAD, Head, head_of
from measure.readers.text.blocks import rows_only
from measure.readers.text.body import read_body
from measure.readers.text.dialect import MOST_SNIFFED, Reading, reading_of
from measure.readers.text.encoding import decoded
from measure.tables.csv_cells import MOST_COLUMNS, TOO_LONG
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
    body = rows_only(lines.last(max(20, min(MOST_SNIFFED, len(lines) * 2 // 3))))
    try:
        reading = reading_of(path, body, delimiter, decimal)
        return _table(path, lines, reading, used_encoding, header)
    except csv.Error:
        raise InputError(f"{path}: {TOO_LONG}. Export it as comma-separated text.") from None


def _table(path: Path, lines: TextLines, reading: Reading, encoding: str, header: bool | None) -> RawTable:
    size = _usual_size(lines, reading)
    head, above = _head(lines, reading, size) if header is not False else (NO_HEAD, [])
    if size > MOST_COLUMNS:
        raise InputError(f"{path}: has {size} columns; a table of a test has at most {MOST_COLUMNS}. Export those that are needed.")
    if head.rows and not head.names and any(reading.dialect.split(above[-1])):
        raise InputError(
            f"{path}, line {head.rows}: {len(reading.dialect.split(above[-1]))} names stand above {size} columns, so which is which is not "
            "sure. Mend the header, or remove it and give the columns by number."
        )
    first = reading.dialect.split(next(lines.blocks(head.rows))[0])
    body = read_body(path, lines, reading, head, first if len(first) == size else [""] * size)
    keep = [k for k in range(size) if body.filled[k]]
    units = [body.units.get(k, head.units[k] if head.units else "") for k in range(size)]
    return RawTable(
        path,
        [body.values[k] for k in keep],
        header=tuple(head.names[k] for k in keep) if head.names else (),
        units=tuple(units[k] for k in keep) if any(units) else (),
        written=f"{encoding}, delimiter {reading.delimiter}, decimal {reading.decimal}{body.said}",
        notes=(*above[: head.above], *body.notes),
        lines=body.lines,
        header_line=head.above + 1 if head.names else 0,
        odd=[body.odd[k] for k in keep],
        first_row=tuple(first[k] for k in keep) if len(first) == size else (),
    )


def _usual_size(lines: TextLines, reading: Reading) -> int:
    """The number of cells that most lines have."""
    sizes: Counter[int] = Counter()
    for block in lines.blocks():
        sizes.update(reading.dialect.sizes(block))
    return sizes.most_common(1)[0][0]


def _head(lines: TextLines, reading: Reading, size: int) -> tuple[Head, list[str]]:
    """What the lines above the first row of numbers say, and these lines; nothing where there is no such row."""
    above: list[str] = []
    cells: list[list[str]] = []
    for block in lines.blocks():
        for line in block:
            row = reading.dialect.split(line)
            if len(row) == size and reading.is_data(row):
                return head_of(cells, lambda row: len(row) == size, reading.is_number), above
            above.append(line)
            cells.append(row)
    return NO_HEAD, []
