"""Vectors of numbers out of a binary file as a table: those of one length are columns, single numbers notes; nothing goes through text."""

from __future__ import annotations

import json
import zipfile
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.readers.text.encoding import LARGEST_FILE
from measure.tables.raw_table import RawTable, odd_numbers

LARGEST_UNPACKED = 50_000_000  # numbers
_MOST_COLUMNS = 50


@dataclass
class Vectors:
    """What a file holds: vectors by name, the unit that stands with some of them, and single numbers as notes."""

    values: dict[str, Array] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def add(self, name: str, array: Array, unit: str = "") -> None:
        """Take in an array: a single number as a note, a vector as it is, a matrix by its columns."""
        if array.size == 1:
            self.notes.append(f"{name} = {array.ravel()[0]:g}")
        elif array.ndim == 1 or (array.ndim == 2 and 1 in array.shape):
            self.values[name], self.units[name] = array.ravel(), unit
        elif array.ndim == 2:
            for k in range(min(array.shape[1], _MOST_COLUMNS)):
                self.values[f"{name}[{k + 1}]"], self.units[f"{name}[{k + 1}]"] = array[:, k], unit

    def save(self, path: Path) -> None:
        """Write them as one .npz archive, `about` being names, units and notes as JSON."""
        about = json.dumps({"names": list(self.values), "units": self.units, "notes": self.notes})
        arrays: dict[str, Any] = {"about": np.array(about), **{f"v{k}": v for k, v in enumerate(self.values.values())}}
        np.savez(path, **arrays)

    @classmethod
    def load(cls, path: Path) -> Vectors:
        """Read what `save` wrote."""
        with np.load(path, allow_pickle=False) as archive:
            about = json.loads(str(archive["about"]))
            return cls({name: archive[f"v{k}"] for k, name in enumerate(about["names"])}, about["units"], about["notes"])


def table_of(path: Path, kind: str, found: Vectors) -> RawTable:
    """The vectors that share the most common length, as a table with their names.

    Raises
    ------
    InputError
        No two vectors of one length.
    """
    if not found.values:
        raise InputError(f"{path}: holds no vector of numbers. Save force and elongation as vectors.")
    length, _ = Counter(len(values) for values in found.values.values()).most_common(1)[0]
    columns = {name: values for name, values in found.values.items() if len(values) == length}
    if len(columns) < 2 or length < 2:
        raise InputError(
            f"{path}: no two vectors of one length; found {_listed(found.values)}. Save force and elongation sample by sample."
        )
    units = tuple(found.units.get(name, "") for name in columns)
    return RawTable(
        path,
        tuple(columns.values()),
        header=tuple(columns),
        units=units if any(units) else (),
        written=kind,
        notes=tuple(found.notes),
        odd=[odd_numbers(column) for column in columns.values()],
    )


def _listed(values: Mapping[str, Array]) -> str:
    return ", ".join(f"{name} ({len(v)})" for name, v in values.items())


def require_size(path: Path) -> None:
    """Refuse a file that is too large to be a table of a loop.

    Raises
    ------
    InputError
    """
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(f"{path}: is larger than {LARGEST_FILE // 1_000_000} MB. Cut it to the test.")


def require_unpacked(path: Path, numbers: int) -> None:
    """Refuse a file that promises more numbers than a loop has, before any of them is read.

    Raises
    ------
    InputError
    """
    if numbers > LARGEST_UNPACKED:
        raise InputError(f"{path}: holds {numbers} numbers, and {LARGEST_UNPACKED} are the most for a loop. Cut it to the test.")


def require_unpacked_zip(path: Path) -> None:
    """Refuse a packed workbook that would unpack to more than a table may have, before any of it is unpacked.

    Raises
    ------
    InputError
    """
    require_size(path)
    if not zipfile.is_zipfile(path):
        return
    with zipfile.ZipFile(path) as packed:
        unpacked = sum(entry.file_size for entry in packed.infolist())
    if unpacked > LARGEST_FILE:
        raise InputError(f"{path}: unpacks to {unpacked / 1e6:.0f} MB, and {LARGEST_FILE / 1e6:g} MB are the most. Cut it to the test.")


def numbers_of(array: object) -> Array | None:
    """An array as numbers, instants as seconds since the first; None for words and whatever else is no number."""
    given = np.asarray(array)
    if given.dtype.kind == "M":
        return (given - given.ravel()[0]).astype("timedelta64[ns]").astype(float) * 1e-9 if given.size else None
    return given.astype(float) if given.dtype.kind in "iufb" else None
