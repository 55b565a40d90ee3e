"""MATLAB files of version 7.3 and other HDF5 files as tables, read by h5py, which is an extra.

Only numbers that lie in the file itself are read: links to other files, storage in other files and virtual data sets, by which
a file could have any other file on the machine read, are passed over.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .dialect import TextTable
from .errors import InputError
from .extras import required
from .vectors import Vectors, numbers_of, require_size, require_unpacked, table_of


def read_hdf5(path: Path) -> TextTable:
    """The data sets of an HDF5 file that share the most common length; MATLAB's structures as dotted names.

    Raises
    ------
    InputError
        h5py is not installed, a damaged file, no two vectors of one length.
    """
    h5py = required("h5py", path, "a MATLAB 7.3 or HDF5 file", "hdf5", f'save it with save("{path.name}", "-v7")')
    require_size(path)
    try:
        with h5py.File(path, "r") as file:
            found = _vectors(path, file, h5py.Dataset)
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f'{path}: cannot be read as HDF5: {error}. Save it with save("{path.name}", "-v7"), or export text.') from error
    return table_of(path, "HDF5", found)


def _vectors(path: Path, file: Any, dataset: type) -> Vectors:
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
