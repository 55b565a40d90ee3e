"""The vectors of a MATLAB file up to version 7, read by SciPy; `measure.readers.formats.guarded` calls it in a process of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from measure.common.arrays import Array
from measure.readers.formats.vectors import Vectors, numbers_of, require_unpacked

_DEEPEST = 5  # structures within structures


def vectors(path: Path) -> Vectors:
    """Every real array of numbers by name, structures as dotted names; cells, objects, texts and sparse matrices are passed over.

    Raises
    ------
    InputError
        It promises more numbers than a loop has. Whatever else a damaged file leads SciPy to is raised as it comes.
    """
    from scipy.io import loadmat, whosmat

    require_unpacked(path, sum(int(np.prod(shape, dtype=float)) for _, shape, _ in whosmat(str(path), appendmat=False)))
    read = loadmat(str(path), appendmat=False)
    arrays = [found for name, value in read.items() if not name.startswith("__") for found in _arrays(name, value, 0)]
    require_unpacked(path, sum(array.size for _, array in arrays))
    found = Vectors()
    for name, array in arrays:
        found.add(name, array)
    return found


def _arrays(name: str, value: Any, depth: int) -> Iterator[tuple[str, Array]]:
    """The arrays of numbers in a variable; of structures only those of one element are followed."""
    if not isinstance(value, np.ndarray):
        return
    fields = value.dtype.names
    if fields and value.size == 1 and depth < _DEEPEST:
        for field in fields:
            yield from _arrays(f"{name}.{field}", value.ravel()[0][field], depth + 1)
        return
    numbers = None if fields else numbers_of(value)
    if numbers is not None and numbers.size:
        yield name, numbers
