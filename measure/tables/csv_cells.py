"""This project's own CSV: comma, point, UTF-8, one header row; read strictly, and written so that no cell runs as a formula."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, clipped
from measure.common.inputs import LARGEST_TABLE, existing_file, require_text
from measure.common.output import replacing
from measure.tables.number_columns import NumberColumns, RaggedRow
from measure.tables.raw_table import RawTable
from measure.tables.text_lines import TextLines

# A spreadsheet takes a cell that begins so for a formula, which may call programs.
_FORMULA = ("=", "+", "-", "@")
_ROWS_AT_ONCE = 10_000
MOST_COLUMNS = 2000
TOO_LONG = f"a cell has more than {csv.field_size_limit()} characters, and no number has"


def read_columns(path: Path, words: Collection[str] = ()) -> RawTable:
    """Read a CSV with a comma, UTF-8 and one header row.

    Parameters
    ----------
    words : names of the columns that are kept as text.

    Raises
    ------
    InputError
        There is no such file, it is no text, it has no header, two columns share a name, or a row has too few or too many cells.
    """
    require_text(existing_file(path, what="a table (CSV)", most=LARGEST_TABLE), "a CSV")
    try:
        lines = TextLines(path.read_bytes().decode("utf-8-sig"))
        return _quoted_table(path, lines, words) if '"' in lines.text else _plain_table(path, lines, words)
    except csv.Error:
        raise InputError(f"{path}: {TOO_LONG}. Export it again as comma-separated text.") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not a CSV in UTF-8 ({error}). Export it again as comma-separated text.") from error


def _plain_table(path: Path, lines: TextLines, words: Collection[str]) -> RawTable:
    """Without a quote every line is a row."""
    header = _header(path, lines.first().split(","))
    columns = _columns_for(header, len(lines) - 1, words)
    try:
        for block in lines.blocks(skipped=1):
            columns.add_lines(block)
    except RaggedRow as error:
        raise _ragged(path, error.row + 2, error.found, header) from None
    return _table(path, header, columns, range(2, len(lines) + 1))


def _quoted_table(path: Path, lines: TextLines, words: Collection[str]) -> RawTable:
    """A quoted cell may hold a comma, or run over several lines."""
    reader = csv.reader(f"{line}\n" for block in lines.blocks() for line in block)
    header = _header(path, next(reader, []))
    ends: list[int] = []
    columns = _columns_for(header, len(lines) - 1, words)
    try:
        while rows := list(islice(_noted(reader, ends), _ROWS_AT_ONCE)):
            columns.add_rows(rows)
    except RaggedRow as error:
        raise _ragged(path, ends[error.row], error.found, header) from None
    return _table(path, header, columns, ends)


def _noted(reader: Iterator[list[str]], ends: list[int]) -> Iterator[list[str]]:
    """The rows, and in `ends` the line at which each ends."""
    for row in reader:
        ends.append(reader.line_num)  # type: ignore[attr-defined]
        yield row


def _columns_for(header: tuple[str, ...], rows: int, words: Collection[str]) -> NumberColumns:
    return NumberColumns(len(header), rows, words={k: [] for k, name in enumerate(header) if name in words})


def _header(path: Path, cells: list[str]) -> tuple[str, ...]:
    header = tuple(name.strip() for name in cells)
    if not any(cells):
        raise InputError(f"{path}, line 1: no header row; the first line must name the columns, such as time_s.")
    if len(header) > MOST_COLUMNS:
        raise InputError(f"{path}, line 1: {len(header)} columns; a table has at most {MOST_COLUMNS}. Export those that are needed.")
    double = [name for name, often in Counter(header).items() if often > 1]
    if double:
        raise InputError(f'{path}, line 1: two columns are named "{clipped(double[0])}"; rename one.')
    return header


def _ragged(path: Path, line: int, found: int, header: tuple[str, ...]) -> InputError:
    return InputError(f"{path}, line {line}: {found} cells and {len(header)} columns; the file is cut or a cell holds a comma.")


def _table(path: Path, header: tuple[str, ...], columns: NumberColumns, lines: range | list[int]) -> RawTable:
    values = [column[: len(lines)] for column in columns.values]
    words = {header[k]: cells for k, cells in columns.words.items()}
    return RawTable(path, values, header, lines=lines, header_line=1, odd=columns.odd, words=words)


def numbers(table: RawTable, name: str, *, empty: bool = False) -> Array:
    """A column of numbers, (n,); with `empty` an empty cell is NaN, and so nothing else may be.

    Raises
    ------
    InputError
        A cell is not a number; its line is named.
    """
    place = table.header.index(name)
    odd = table.first_odd(place, ("nan", "word") if empty else ("empty", "nan", "word"))
    if odd:
        advice = "Leave the cell empty where nothing was seen" if empty else "Mend the cell or remove the row"
        found = f'"{clipped(odd.text)}"' if odd.text else "empty"
        raise InputError(f"{table.where(odd.row)}: {name} is {found}, which is not a number. {advice}.")
    return table.columns[place]


def numbers_if_they_are(table: RawTable, name: str) -> Array | None:
    """A column of numbers, NaN where a cell is empty; None if any cell holds words."""
    if name in table.words:
        column = NumberColumns(1, len(table))
        column.add_rows([[cell] for cell in table.words[name]])
        return None if "word" in column.odd[0] else column.values[0]
    place = table.header.index(name)
    return None if table.first_odd(place, ("word",)) else table.columns[place]


def write_columns(columns: Mapping[str, Iterable], path: Path) -> None:
    """Write columns of equal lengths, whole or not at all; every float keeps its last digit, NaN is an empty cell."""
    with replacing(Path(path)) as temporary, open(temporary, "w", encoding="utf-8", newline="") as file:
        _write_rows(columns, file)


def csv_text(columns: Mapping[str, Iterable]) -> str:
    """Columns of equal lengths as the text of a CSV, as `write_columns` writes it."""
    file = io.StringIO()
    _write_rows(columns, file)
    return file.getvalue()


def _write_rows(columns: Mapping[str, Iterable], file: TextIO) -> None:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow([_disarmed(name) for name in columns])
    for row in zip(*columns.values(), strict=True):
        writer.writerow([_cell(value) for value in row])


def _disarmed(words: str) -> str:
    shown = words.replace("\r", " ")  # a lone carriage return would end the row for some readers
    return "'" + shown if shown.lstrip().startswith(_FORMULA) else shown


def _cell(value: object) -> str:
    if isinstance(value, str):
        return _disarmed(value)
    if isinstance(value, int | np.integer):
        return str(int(value))
    number = float(value)  # type: ignore[arg-type]
    return "" if np.isnan(number) else repr(number)
