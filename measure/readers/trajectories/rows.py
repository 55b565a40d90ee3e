"""The rows of numbers of a text table whose columns are known: gaps are allowed, words are not."""

from __future__ import annotations

from pathlib import Path

from measure.common.errors import InputError, clipped
from measure.tables.number_columns import Dialect, NumberColumns, OddCell, RaggedRow
from measure.tables.text_lines import TextLines


def numbers_below(path: Path, lines: TextLines, head: int, names: list[str], dialect: Dialect) -> NumberColumns:
    """The columns below the head of a table; empty cells and NaN are NaN, empty lines are passed over.

    Parameters
    ----------
    head : lines above the numbers. names : of all columns, for sentences.

    Raises
    ------
    InputError
        A row with more cells, a word or an infinite number.
    """
    table, count = NumberColumns(len(names), max(len(lines) - head, 0), dialect), 0
    try:
        for block in lines.blocks(skipped=head):
            rows = [_as_long(row, len(names)) for row in dialect.rows(block) if any(cell.strip() for cell in row)]
            table.add_rows(rows)
            count += len(rows)
    except RaggedRow as error:
        where = f"{path}, row {error.row + 1} of the numbers"
        raise InputError(f"{where}: {error.found} cells, and the head has {len(names)}. Export the table again.") from None
    table.values = table.values[:, :count]
    for name, odd in zip(names, table.odd, strict=True):
        wrong = [odd[kind] for kind in ("infinite", "word") if kind in odd]
        if wrong:
            raise InputError(_no_number(path, name, min(wrong)))
    return table


def require_every_time(path: Path, table: NumberColumns, column: int) -> None:
    """Refuse a row without a time.

    Raises
    ------
    InputError
    """
    wrong = [table.odd[column][kind] for kind in ("empty", "nan") if kind in table.odd[column]]
    if wrong:
        raise InputError(_no_number(path, "time", min(wrong)))


def _no_number(path: Path, name: str, cell: OddCell) -> str:
    found = f'"{clipped(cell.text)}"' if cell.text else "empty"
    return f"{path}, row {cell.row + 1} of the numbers: {clipped(name, 40)} is {found}, no number. Mend the cell or remove the row."


def _as_long(row: list[str], size: int) -> list[str]:
    """The row with empty cells for those left away at its end, and without empty ones beyond it."""
    return [*row[:size], *[""] * (size - len(row))] if not any(cell.strip() for cell in row[size:]) else row
