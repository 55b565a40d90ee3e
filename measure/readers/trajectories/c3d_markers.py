"""Files of motion capture in the C3D format, as markers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from measure.common.errors import InputError
from measure.common.inputs import LARGEST_TABLE, existing_file
from measure.readers.formats.guarded import c3d_vectors
from measure.readers.trajectories.markers import Markers

_AXES = 3


def read_c3d(path: Path) -> Markers:
    """Read the points of a C3D file; its time counts from its first frame.

    Raises
    ------
    InputError
        c3d is not installed, a damaged file, no points.
    """
    existing_file(path, what="a file of markers (C3D)", most=LARGEST_TABLE)
    found = c3d_vectors(path)
    columns = list(found.values.values())
    if len(columns) < 1 + _AXES:
        raise InputError(f"{path}: holds no points. Export the markers with it, or as .trc.")
    names = tuple(name.removesuffix("[1]") for name in found.values if name.endswith("[1]"))
    position = np.stack(columns[1:], axis=1).reshape(len(columns[0]), -1, _AXES)
    up, across = (note or None for note in found.notes)
    return Markers(path, columns[0], names, position, next(reversed(found.units.values())), up, across)
