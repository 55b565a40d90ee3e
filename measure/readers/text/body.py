"""The rows of a text table as columns of numbers, date-time stamps as seconds, whether they stand in one piece or in blocks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.readers.table_head import Head
from measure.readers.text.blocks import Blocks, is_text
from measure.readers.text.dialect import Reading
from measure.readers.timestamps import is_date, is_stamp, seconds_of
from measure.tables.number_columns import Kind, NumberColumns, OddCell, RaggedRow
from measure.tables.text_lines import TextLines


@dataclass
class Body:
    """The columns of a table, all of them: values (size, rows), what is odd in them, whether any cell holds something, and units found.

    lines : the line of each row. notes, said : text between the rows, and what is to be said of it.
    """

    values: Array
    odd: list[dict[Kind, OddCell]]
    filled: list[bool]
    lines: Sequence[int]
    notes: Sequence[str] = ()
    said: str = ""
    units: Mapping[int, str] = field(default_factory=dict)


def read_body(path: Path, lines: TextLines, reading: Reading, head: Head, first: Sequence[str]) -> Body:
    """The rows below the head.

    Parameters
    ----------
    first : cells of the first row, by which columns of stamps are known.

    Raises
    ------
    InputError
        A row with another number of cells; a block whose columns are named otherwise.
    """
    size, rows = len(first), len(lines) - head.rows
    words = [k for k, cell in enumerate(first) if is_stamp(cell) or is_date(cell)]
    whole = range(head.rows + 1, len(lines) + 1)
    try:
        columns = _filled(NumberColumns(size, rows, reading.dialect, {k: [] for k in words}), lines.blocks(head.rows))
    except RaggedRow as error:
        if is_text(_line(lines, head.rows)) or not is_text(_line(lines, head.rows + error.row)):
            raise _ragged(path, head.rows + error.row + 1, error.found, size) from None
    else:
        if not _has_text(lines, columns, head.rows):
            return _stamped(Body(columns.values, columns.odd, columns.filled, whole), columns, path)
    blocks = Blocks(lines, head.rows, head.names, reading.dialect.split)
    columns = NumberColumns(size, rows, reading.dialect, {k: [] for k in words})
    try:
        _filled(columns, blocks.rows(str(path)))
    except RaggedRow as error:
        raise _ragged(path, blocks.numbers[error.row], error.found, size) from None
    values = columns.values[:, : len(blocks.numbers)]
    said = f", {whole.stop - whole.start - len(blocks.numbers)} lines of text between the rows left out"
    return _stamped(Body(values, columns.odd, columns.filled, blocks.numbers, blocks.notes, said), columns, path)


def _filled(columns: NumberColumns, blocks: Iterable[list[str]]) -> NumberColumns:
    for block in blocks:
        columns.add_lines(block)
    return columns


def _line(lines: TextLines, row: int) -> str:
    return next(lines.blocks(row), [""])[0]


def _has_text(lines: TextLines, columns: NumberColumns, start: int) -> bool:
    """Whether a line of words with as many cells as the table has columns stands among the rows."""
    rows = {found["word"].row for found in columns.odd if "word" in found}
    return any(is_text(_line(lines, start + row)) for row in rows if row)


def _ragged(path: Path, line: int, found: int, size: int) -> InputError:
    return InputError(
        f"{path}, line {line}: {found} cells where the other rows have {size}; the file is cut or a cell is "
        "missing. Remove the line or export the file again."
    )


def _stamped(body: Body, columns: NumberColumns, path: Path) -> Body:
    """The same with stamps as seconds since the first; a date in one column and the time of day in the next are one stamp."""
    units = dict(body.units)
    for k, cells in columns.words.items():
        dates = columns.words.get(k - 1, [""])
        if is_date(cells[0]):
            body.filled[k] = k + 1 not in columns.words
            continue
        whole = [f"{date} {cell}" for date, cell in zip(dates, cells, strict=True)] if is_date(dates[0]) else cells
        body.values[k], units[k], body.filled[k] = seconds_of(whole, f"{path}, column {k + 1}"), "s", True
        for row in np.flatnonzero(np.isnan(body.values[k]))[:1]:
            body.odd[k]["word" if cells[row] else "empty"] = OddCell(int(row), cells[row])
    body.units = units
    return body
