"""Tables as addresses that hold them: what a page offers for saving without a file beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

from measure.common.arrays import Array
from measure.tables.csv_cells import csv_text

_DIGITS = 7
_KEPT = ", ()/:^*"  # characters that stand for themselves in such an address


def csv_address(columns: Mapping[str, Sequence[Any] | Array]) -> str:
    """A table as the address `data:text/csv,...`, for a link that saves it.

    Parameters
    ----------
    columns : numbers, which keep seven digits, or texts; where a column has ended its cells are empty.
    """
    most = max(map(len, columns.values()), default=0)
    table = {name: [*map(_short, values), *[""] * (most - len(values))] for name, values in columns.items()}
    return "data:text/csv;charset=utf-8," + quote(csv_text(table), safe=_KEPT)


def _short(value: Any) -> Any:
    return value if isinstance(value, str | int) else float(f"{float(value):.{_DIGITS}g}")
