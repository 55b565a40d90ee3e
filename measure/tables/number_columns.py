"""Cells of text to columns of numbers, block by block: by NumPy where every cell is a plain number, cell by cell elsewhere.

Both ways give the same bits. The second one also says which cell is none and what stands there.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import repeat
from typing import Literal, NamedTuple

import numpy as np

from measure.common.arrays import Array

Kind = Literal["empty", "nan", "infinite", "word"]


class OddCell(NamedTuple):
    """A cell that holds no finite number: its row, counted from zero, and what stands there."""

    row: int
    text: str


class RaggedRow(ValueError):
    """A row has another number of cells than the table has columns. row : counted from zero."""

    def __init__(self, row: int, found: int) -> None:
        super().__init__(f"row {row} has {found} cells")
        self.row, self.found = row, found


@dataclass(frozen=True)
class Dialect:
    """How numbers stand in a line.

    separator : between two cells, None for any number of blanks. comma : whether the decimals follow one.
    """

    separator: str | None = ","
    comma: bool = False

    def split(self, line: str) -> list[str]:
        """The cells of one line, without the blanks around them; a quoted cell may hold the separator."""
        if self.separator is None:
            return line.split()
        return [cell.strip() for cell in next(csv.reader([line], delimiter=self.separator), [])]

    def rows(self, lines: Sequence[str]) -> list[list[str]]:
        """The cells of many lines; a quote that is never closed ends with its line."""
        if self.separator is None:
            return [line.split() for line in lines]
        rows = list(csv.reader(lines, delimiter=self.separator))
        return rows if len(rows) == len(lines) else [self.split(line) for line in lines]

    def sizes(self, lines: Sequence[str]) -> Counter[int]:
        """How many lines have how many cells; empty lines have none and are left out."""
        if self.separator is None or any('"' in line for line in lines):
            return Counter(len(row) for row in self.rows(lines) if row)
        separators = Counter(map(str.count, lines, repeat(self.separator)))
        separators[0] -= lines.count("")
        return Counter({often + 1: lines for often, lines in separators.items() if lines})


@dataclass
class NumberColumns:
    """Columns of numbers that are filled block by block.

    size, rows : of the table. words : the columns that are kept as text. values : (size, rows), NaN where no number stands.
    odd : by column and kind, the first cell that holds no finite number. filled : whether any cell of a column holds something.
    """

    size: int
    rows: int
    dialect: Dialect = field(default_factory=Dialect)
    words: dict[int, list[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.values: Array = np.full((self.size, self.rows), np.nan)
        self.odd: list[dict[Kind, OddCell]] = [{} for _ in range(self.size)]
        self.filled = [False] * self.size
        self._done = 0

    def add_lines(self, lines: Sequence[str]) -> None:
        """Take in the next lines of the file.

        Raises
        ------
        RaggedRow
            A line has another number of cells than the table has columns.
        """
        block = None if self.words else _plain_block(lines, self.size, self.dialect)
        if block is None:
            self.add_rows(self.dialect.rows(lines))
            return
        self.values[:, self._done : self._done + len(lines)] = block.T
        self.filled = [True] * self.size
        self._done += len(lines)

    def add_rows(self, rows: Sequence[Sequence[str]]) -> None:
        """Take in the next rows, already cut into cells; see `add_lines`."""
        if set(map(len, rows)) - {self.size}:
            row = next(i for i, row in enumerate(rows) if len(row) != self.size)
            raise RaggedRow(self._done + row, len(rows[row]))
        for k, cells in enumerate(zip(*rows, strict=True)):
            if k in self.words:
                self.words[k] += [cell.strip() for cell in cells]
            else:
                self._take(k, [cell.strip() for cell in cells])
        self._done += len(rows)

    def _take(self, k: int, cells: list[str]) -> None:
        values = _plain_column(cells, self.dialect)
        self.filled[k] |= values is not None or any(cells)
        if values is None:
            values = np.array([_number(cell, self.dialect) for cell in cells])
        self.values[k, self._done : self._done + len(cells)] = values
        for i in np.flatnonzero(~np.isfinite(values)):
            self.odd[k].setdefault(_kind(cells[i], self.dialect), OddCell(self._done + int(i), cells[i]))


def _plain_block(lines: Sequence[str], size: int, dialect: Dialect) -> Array | None:
    """The numbers of lines in which every cell is a finite number, (lines, size); None where one is not, or a line has other cells."""
    if dialect.separator is not None and set(map(str.count, lines, repeat(dialect.separator))) != {size - 1}:
        return None
    shown = lines
    if dialect.comma:
        text = "\n".join(lines)
        if "." in text or dialect.separator == ",":
            return None
        shown = text.replace(",", ".").split("\n")
    try:
        block = np.loadtxt(shown, delimiter=dialect.separator, comments=None, ndmin=2)
    except ValueError:
        return None
    return block if block.shape == (len(lines), size) and np.isfinite(block).all() else None


def _plain_column(cells: Sequence[str], dialect: Dialect) -> Array | None:
    """The numbers of a column in which every cell is one, not necessarily finite; None elsewhere."""
    text = "\n".join(cells)
    if not text.isascii() or "_" in text or (dialect.comma and "." in text):
        return None
    try:
        return np.array(list(map(float, text.replace(",", ".").split("\n") if dialect.comma else cells)))
    except ValueError:
        return None


def _number(cell: str, dialect: Dialect) -> float:
    """The number in a cell, NaN where none stands there; 1_000 and digits of other scripts, which Python reads, are none."""
    if not cell.isascii() or "_" in cell or (dialect.comma and "." in cell):
        return np.nan
    try:
        return float(cell.replace(",", ".") if dialect.comma else cell)
    except ValueError:
        return np.nan


def _kind(cell: str, dialect: Dialect) -> Kind:
    if not cell:
        return "empty"
    if np.isinf(_number(cell, dialect)):
        return "infinite"
    return "nan" if cell.lstrip("+-").lower() == "nan" else "word"
