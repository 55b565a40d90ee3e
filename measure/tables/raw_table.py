"""A file's columns of numbers under the names that they have there, before any of them is taken for time, elongation or force."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.tables.number_columns import Kind, OddCell


@dataclass(frozen=True)
class RawTable:
    """Named columns of numbers, their units as they stand in the file, and where each row stands there.

    columns : (n,) each, NaN where no number stands. header, units : what stands above each, or empty.
    written : how the file is written, for people. notes : what it says besides the samples.
    lines : the line of each row in a text file, counted from one; empty for a binary file. header_line : of the names, or 0.
    odd : by place of the column and kind, the first cell that holds no finite number.
    words : columns kept as text, by name. first_row : as it stands in the file, of a file without names.
    """

    path: Path
    columns: Sequence[Array]
    header: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    written: str = ""
    notes: tuple[str, ...] = ()
    lines: Sequence[int] = ()
    header_line: int = 0
    odd: Sequence[Mapping[Kind, OddCell]] = ()
    words: Mapping[str, Sequence[str]] = field(default_factory=dict)
    first_row: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.columns[0]) if self.columns else 0

    def where(self, row: int) -> str:
        """File and place of a row, for people: a line of a text file, a sample of a binary one."""
        return f"{self.path}, line {self.lines[row]}" if self.lines else f"{self.path}, sample {row + 1}"

    def first_odd(self, place: int, kinds: Sequence[Kind] = ("empty", "nan", "infinite", "word")) -> OddCell | None:
        """The first cell of a column that is of one of these kinds, or None."""
        found = [cell for kind, cell in self.odd[place].items() if kind in kinds]
        return min(found) if found else None


def odd_numbers(column: Array) -> dict[Kind, OddCell]:
    """The first NaN and the first infinite number of a column out of a binary file."""
    checks: tuple[tuple[Kind, Array], ...] = (("nan", np.isnan(column)), ("infinite", np.isinf(column)))
    rows: dict[Kind, int] = {kind: int(np.argmax(bad)) for kind, bad in checks if bad.any()}
    return {kind: OddCell(row, f"{column[row]:g}") for kind, row in rows.items()}
