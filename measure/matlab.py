"""MATLAB files up to version 7 as tables: vectors of one length are columns, single numbers are notes."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from .dialect import LARGEST_FILE, TextTable
from .errors import InputError
from .mat5 import Mat5Error, read_mat5
from .tables import Array

_MOST_COLUMNS = 50


def is_matlab(path: Path) -> bool:
    """Whether a file begins like a MATLAB file, whatever its name."""
    with open(path, "rb") as file:
        return file.read(19) == b"MATLAB 5.0 MAT-file" or path.suffix.lower() == ".mat"


def read_matlab(path: Path) -> TextTable:
    """The vectors of a MATLAB file that share the most common length, as a table with their names.

    Raises
    ------
    InputError
        Version 7.3, not a MATLAB file, no two vectors of one length.
    """
    vectors, notes = _contents(path)
    if not vectors:
        raise InputError(f"{path}: holds no vector of numbers. Save force and elongation as vectors.")
    length, _ = Counter(len(values) for values in vectors.values()).most_common(1)[0]
    columns = {name: values for name, values in vectors.items() if len(values) == length}
    if len(columns) < 2 or length < 2:
        raise InputError(f"{path}: no two vectors of one length; found {', '.join(vectors)}. Save force and elongation sample by sample.")
    rows = [[repr(float(value)) for value in row] for row in zip(*columns.values(), strict=True)]
    return TextTable("MATLAB", "none", "point", tuple(notes), tuple(columns), (), rows, 1)


def _contents(path: Path) -> tuple[dict[str, Array], list[str]]:
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(f"{path}: is larger than {LARGEST_FILE // 1_000_000} MB. Cut it to the test.")
    try:
        found = read_mat5(path.read_bytes())
    except Mat5Error as error:
        raise InputError(
            f'{path}: cannot be read as a MATLAB file: {error}. Save it with save("{path.name}", "-v7"), or export text.'
        ) from error
    vectors: dict[str, Array] = {}
    notes: list[str] = []
    for name, array in found.items():
        if array.size == 1:
            notes.append(f"{name} = {array.ravel()[0]:g}")
        elif array.ndim == 2 and 1 in array.shape:
            vectors[name] = array.ravel()
        elif array.ndim == 2:
            vectors |= {f"{name}[{k + 1}]": array[:, k] for k in range(min(array.shape[1], _MOST_COLUMNS))}
    return vectors, notes
