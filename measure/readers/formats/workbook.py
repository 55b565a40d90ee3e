"""The table in a sheet of a workbook (.xlsx, .xls, .xlsb, .ods), read by python-calamine, which is an extra.

One library reads all of these, without formulas, links or macros being run; `measure.readers.formats.guarded` calls it in a process of
its own, because a packed sheet may unpack to more than the machine has.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, nearest
from measure.readers.formats.vectors import Vectors, require_unpacked
from measure.readers.table_head import head_of
from measure.readers.timestamps import is_stamp, seconds_of

_NUMBER = re.compile(r"[+-]?(\d++[.,]?+\d*+|[.,]\d++)([eE][+-]?\d{1,3})?")  # possessive: it ends on any cell
_LEAST_ROWS = 3
_LEAST_NUMBERS = 0.5  # of the filled cells of a row of samples


def vectors(path: Path, sheet: str = "") -> Vectors:
    """The columns of numbers of a sheet.

    Raises
    ------
    InputError
        No table in any sheet; a table in several and none named; more cells than a loop has.
    """
    from python_calamine import CalamineWorkbook

    book = CalamineWorkbook.from_path(str(path))
    names = [sheet] if sheet else list(book.sheet_names)
    if sheet and sheet not in book.sheet_names:
        raise InputError(f'{path}: no sheet "{sheet}"; {nearest(sheet, book.sheet_names)}')
    found = {name: made for name in names if (made := _columns(path, book.get_sheet_by_name(name))) is not None}
    if not found:
        raise InputError(f"{path}: no table of numbers in {_listed(names)}. Write the names in one row and the samples below them.")
    if len(found) > 1:
        raise InputError(f'{path}: holds tables in {_listed(list(found))}. Add --sheet "{next(iter(found))}", or the other one.')
    return next(iter(found.values()))


def _listed(names: Sequence[str]) -> str:
    return f"{len(names)} sheets ({', '.join(names[:8])})" if len(names) > 1 else f'sheet "{names[0]}"'


def _columns(path: Path, sheet: Any) -> Vectors | None:
    """The columns of a sheet; None where it holds no table."""
    require_unpacked(path, int(sheet.total_height) * int(sheet.total_width))
    rows = [row for row in sheet.to_python(skip_empty_area=True) if any(cell != "" for cell in row)]
    start = next((k for k, row in enumerate(rows) if _is_data(row)), len(rows))
    if len(rows) - start < _LEAST_ROWS:
        return None
    kept = [k for k in range(len(rows[start])) if any(row[k] != "" for row in rows[start:])]
    words = [[str(row[k]).strip() for k in kept] for row in rows[:start]]
    head = head_of(words, lambda row: sum(map(bool, row)) >= min(2, len(kept)), lambda cell: _NUMBER.fullmatch(cell) is not None)
    found = Vectors(notes=[" ".join(filter(None, row)) for row in words[: head.above]])
    for place, k in enumerate(kept):
        name = head.names[place] if head.names and head.names[place] else f"column {place + 1}"
        unit = head.units[place] if head.units else ""
        values, clock = _numbers([row[k] for row in rows[start:]], f"{path}, column {k + 1}")
        name = _other_name(name, found)
        found.values[name], found.units[name] = values, "s" if clock else unit
    return found


def _other_name(name: str, found: Vectors) -> str:
    """A name that no column has yet."""
    return name if name not in found.values else f"{name} ({sum(known.startswith(name) for known in found.values) + 1})"


def _is_data(row: Sequence[Any]) -> bool:
    filled = [cell for cell in row if cell != ""]
    numbers = sum(_is_number(cell) for cell in filled)
    return numbers >= 2 and numbers >= _LEAST_NUMBERS * len(filled) and _is_number(filled[0])


def _is_number(cell: Any) -> bool:
    if isinstance(cell, str):
        return _NUMBER.fullmatch(cell.strip()) is not None or is_stamp(cell.strip())
    return not isinstance(cell, bool)


def _numbers(cells: Sequence[Any], place: str) -> tuple[Array, bool]:
    """A column as numbers, NaN where none stands, and whether they are seconds since the first stamp in it."""
    first = next((cell for cell in cells if cell != ""), "")
    if isinstance(first, datetime.datetime | datetime.date | datetime.time | datetime.timedelta):
        return _seconds(cells, place), True
    if isinstance(first, str) and is_stamp(first.strip()):
        return seconds_of([str(cell).strip() for cell in cells], place), True
    return np.array([_number(cell) for cell in cells]), False


def _seconds(cells: Sequence[Any], place: str) -> Array:
    """Seconds since the first of cells that are dates or times for Excel."""
    if any(isinstance(cell, datetime.timedelta) for cell in cells):
        spans = np.array([cell.total_seconds() if isinstance(cell, datetime.timedelta) else np.nan for cell in cells])
        return spans - spans[np.isfinite(spans)][0]
    return seconds_of([cell.isoformat() if hasattr(cell, "isoformat") else str(cell) for cell in cells], place)


def _number(cell: Any) -> float:
    """The number in a cell; one that stands there as text may have a decimal comma, since a workbook writes no thousands into it."""
    if isinstance(cell, str):
        return float(cell.replace(",", ".")) if _NUMBER.fullmatch(cell.strip()) else np.nan
    return float(cell) if isinstance(cell, int | float) and not isinstance(cell, bool) else np.nan
