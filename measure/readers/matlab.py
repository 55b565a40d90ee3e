"""MATLAB files up to version 7 as tables, by the names of their variables."""

from __future__ import annotations

from pathlib import Path

from measure.common.errors import InputError
from measure.readers.binary_vectors import Vectors, require_size, table_of
from measure.readers.mat5 import Mat5Error, read_mat5
from measure.readers.text_dialect import TextTable


def read_matlab(path: Path) -> TextTable:
    """The vectors of a MATLAB file that share the most common length, as a table with their names.

    Raises
    ------
    InputError
        Version 7.3, not a MATLAB file, no two vectors of one length.
    """
    require_size(path)
    try:
        found = read_mat5(path.read_bytes())
    except Mat5Error as error:
        raise InputError(
            f'{path}: cannot be read as a MATLAB file: {error}. Save it with save("{path.name}", "-v7"), or export text.'
        ) from error
    vectors = Vectors()
    for name, array in found.items():
        vectors.add(name, array)
    return table_of(path, "MATLAB", vectors)
