"""The vectors of an HDF5 file, read by h5py, which is an extra; `measure.readers.formats.guarded` calls it in a process of its own.

Only numbers that lie in the file itself are read: links to other files, storage in other files and virtual data sets, by which
a file could have any other file on the machine read, are passed over.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from measure.readers.formats.vectors import Vectors, numbers_of, require_unpacked


def vectors(path: Path) -> Vectors:
    """Every data set of numbers of one or two dimensions, by its path with dots.

    Raises
    ------
    InputError
        It promises more numbers than a loop has. Whatever else a damaged file leads h5py to is raised as it comes.
    """
    import h5py

    with h5py.File(path, "r") as file:
        return _found(path, file, h5py.Dataset)


def _found(path: Path, file: Any, dataset: type) -> Vectors:
    sets: list[tuple[str, Any]] = []
    file.visititems(lambda name, item: sets.append((name, item)) if isinstance(item, dataset) and _is_here(name, item) else None)
    require_unpacked(path, sum(int(item.size) for _, item in sets))
    found = Vectors()
    for name, item in sets:
        values = numbers_of(item[()])
        if values is not None and values.size:
            # MATLAB writes the columns of a matrix as rows
            shown = values.T if "MATLAB_class" in item.attrs else values
            found.add(name.replace("/", "."), shown, _unit(item.attrs))
    return found


def _is_here(name: str, item: Any) -> bool:
    """Whether a data set is an array of numbers in this very file; what MATLAB keeps for itself is not."""
    plain = item.dtype.kind in "iufb" and item.shape is not None and len(item.shape) <= 2
    empty = bool(item.attrs.get("MATLAB_empty", 0))
    is_text = item.attrs.get("MATLAB_class", b"") in (b"char", "char")
    return plain and not item.external and not item.is_virtual and not empty and not is_text and not name.startswith("#")


def _unit(attributes: Any) -> str:
    value = attributes.get("units", attributes.get("unit", ""))
    value = value.item() if isinstance(value, np.ndarray) and value.size == 1 else value
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
    return text.strip() if isinstance(text, str) else ""
