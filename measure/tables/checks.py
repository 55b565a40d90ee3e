"""What every table must fulfil, each with the sentence that names the row where it does not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, clipped

_LISTED = 20
_MOST = {"_s": 1e12, "_m": 1e4, "_N": 1e9, "_rad": 1e6}  # by ending of the column's name


def require_finite(values: Array, column: str, name: str) -> None:
    """Refuse a column with an empty or infinite cell."""
    bad = ~np.isfinite(values)
    if np.any(bad):
        row = int(np.argmax(bad))
        raise InputError(
            f"{name}, line {row + 2}: {column} is {'empty or not a number' if np.isnan(values[row]) else values[row]} "
            f"({int(bad.sum())} of {len(values)} rows). Every row needs a finite {column}; remove these rows or mend them."
        )


def require_physical(values: Array, column: str, name: str) -> None:
    """Refuse a column with a number that its quantity never has: a time of a million years, a kilometre of elongation and the like."""
    most = next(limit for ending, limit in _MOST.items() if column.endswith(ending))
    if np.any(np.abs(values) > most):
        row = int(np.argmax(np.abs(values) > most))
        raise InputError(f"{name}, line {row + 2}: {column} is {values[row]:g}; it is never beyond {most:g}. Check its unit and the cell.")


def require_no_infinity(values: Array, column: str, name: str) -> None:
    """Refuse a column with an infinite cell; NaN is what was not seen."""
    if np.any(np.isinf(values)):
        row = int(np.argmax(np.isinf(values)))
        raise InputError(f"{name}, line {row + 2}: {column} is infinite. Leave the cell empty where nothing was seen.")


def require_equal_lengths(name: str, columns: Mapping[str, Array]) -> None:
    """Refuse columns that are not vectors of one length."""
    lengths = {column: values.shape for column, values in columns.items()}
    if len(set(lengths.values())) > 1 or any(len(shape) != 1 for shape in lengths.values()):
        raise InputError(f"{name}: columns differ in length: " + ", ".join(f"{c} {s}" for c, s in lengths.items()) + ".")


def require_increasing(time_s: Array, name: str) -> None:
    """Refuse fewer than two rows, and a time that does not increase from row to row."""
    if len(time_s) < 2:
        raise InputError(f"{name}: {len(time_s)} rows of data; at least two are needed.")
    step = np.diff(time_s)
    if np.any(step <= 0):
        row = int(np.argmax(step <= 0)) + 1
        raise InputError(
            f"{name}, line {row + 2}: time_s goes from {time_s[row - 1]:g} to {time_s[row]:g}; it must increase from row to row. "
            "Sort the rows and remove doubled ones."
        )


def listed(names: Sequence[str]) -> str:
    """Names of columns for a sentence; of a file that is no table they may be anything, so that little of them is shown."""
    shown = ", ".join(f'"{clipped(name, 40)}"' for name in names[:_LISTED])
    return shown if len(names) <= _LISTED else f"{shown} and {len(names) - _LISTED} more"


def no_time(place: str, header: Sequence[str]) -> str:
    """The sentence for a table without the column of the time."""
    found = listed(header)
    return f"{place}: no column time_s; found {found}. Rename the column of the time, in seconds, to time_s."
