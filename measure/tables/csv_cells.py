"""A table as rows of cells: read strictly, with the line number of every row, and written so that no cell runs as a formula."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from measure.common.command_line import existing_file
from measure.common.errors import InputError
from measure.common.output import replacing

# A spreadsheet takes a cell that begins so for a formula, which may call programs.
_FORMULA = ("=", "+", "-", "@")


@dataclass(frozen=True)
class Cells:
    """Header and rows of a CSV; every row has as many cells as the header. lines : where each row ends in the file."""

    path: Path
    header: list[str]
    rows: list[list[str]]
    lines: list[int]

    def words(self, name: str) -> list[str]:
        """A column as it stands."""
        place = self.header.index(name)
        return [row[place].strip() for row in self.rows]

    def numbers(self, name: str, *, empty: bool = False) -> NDArray[np.floating]:
        """A column of numbers; with `empty` an empty cell is NaN, and so nothing else may be.

        Raises
        ------
        InputError
            A cell is not a number; its line is named.
        """
        values = np.full(len(self.rows), np.nan)
        for i, cell in enumerate(self.words(name)):
            if cell or not empty:
                try:
                    values[i] = _number(cell)
                except ValueError:
                    advice = "Leave the cell empty where nothing was seen" if empty else "Mend the cell or remove the row"
                    place = f"{self.path}, line {self.lines[i]}"
                    raise InputError(f"{place}: {name} is {_quoted(cell)}, which is not a number. {advice}.") from None
        return values

    def numbers_if_they_are(self, name: str) -> NDArray[np.floating] | None:
        """A column of numbers, NaN where a cell is empty; nothing if any cell holds words."""
        try:
            return np.array([np.nan if cell.lower() in ("", "nan") else _number(cell) for cell in self.words(name)])
        except ValueError:
            return None


def _number(cell: str) -> float:
    """Python takes 1_000 for a thousand and NaN for a number; neither is one in a laboratory."""
    value = float(cell)
    if "_" in cell or np.isnan(value):
        raise ValueError(cell)
    return value


def _quoted(cell: str) -> str:
    return f'"{cell}"' if cell else "empty"


def read_cells(path: Path) -> Cells:
    """Read a CSV with a comma, UTF-8 and one header row.

    Raises
    ------
    InputError
        There is no such file, it is no text, it has no header, two columns share a name, or a row has too few or too many cells.
    """
    existing_file(path, what="a table (CSV)")
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            numbered = [(reader.line_num, row) for row in reader]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: is not a CSV in UTF-8 ({error}). Export it again as comma-separated text.") from error
    while numbered and not numbered[-1][1]:
        numbered.pop()
    if not numbered or not any(numbered[0][1]):
        raise InputError(f"{path}, line 1: no header row; the first line must name the columns, such as time_s.")
    header = [name.strip() for name in numbered[0][1]]
    _require_distinct(path, header)
    for line, row in numbered[1:]:
        if len(row) != len(header):
            raise InputError(f"{path}, line {line}: {len(row)} cells and {len(header)} columns; the file is cut or a cell holds a comma.")
    return Cells(path, header, [row for _, row in numbered[1:]], [line for line, _ in numbered[1:]])


def _require_distinct(path: Path, header: list[str]) -> None:
    double = [name for name in header if header.count(name) > 1]
    if double:
        raise InputError(f'{path}, line 1: two columns are named "{double[0]}"; rename one.')


def write_columns(columns: Mapping[str, Iterable], path: Path) -> None:
    """Write columns of equal lengths, whole or not at all; every float keeps its last digit, NaN is an empty cell."""
    with replacing(Path(path)) as temporary, open(temporary, "w", encoding="utf-8", newline="") as file:
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
