"""Tables and results as MATLAB files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from measure.common.output import replacing

if TYPE_CHECKING:
    from pandas import DataFrame

_HEAD, _HEAD_BYTES = b"MATLAB 5.0 MAT-file, written by unspool", 116  # without the time of its making: the same table gives the same bytes
_LONGEST_NAME = 63  # MATLAB's


class HasFrame(Protocol):
    """A table or a result that can be had as a pandas frame."""

    def to_frame(self) -> DataFrame:
        """The frame."""
        ...


def write_mat(result: HasFrame, path: Path, name: str = "") -> None:
    """Write a table or a result as a MATLAB file (version 5, for MATLAB, Octave and `scipy.io.loadmat`).

    Parameters
    ----------
    result : a loop, a trajectory, or what `fit_actuator`, `compare`, `explain`, `deploy` or `sweep` return.
    path : ends with .mat.
    name : of the struct in the file, by default `loop`, `trajectory` and so on. Its fields are the columns, (n, 1) each, words as a cell
        array; `units` is a struct with the unit of each. Names of rows, such as those of parameters, stand in `row`.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    from scipy.io import savemat

    frame = result.to_frame()
    columns: dict[str, Any] = {} if frame.index.dtype.kind in "iu" else {"row": _column(frame.index.to_numpy())}
    columns |= {_field(str(key)): _column(frame[key].to_numpy()) for key in frame.columns}
    units = {_field(str(key)): unit for key, unit in frame.attrs.get("units", {}).items()}
    table = {**columns, "units": units} if units else columns
    with replacing(Path(path)) as temporary:
        with open(temporary, "wb") as file:
            savemat(file, {_field(name or type(result).__name__.lower()): table}, long_field_names=True, oned_as="column")
        with open(temporary, "r+b") as file:
            file.write(_HEAD.ljust(_HEAD_BYTES))


def _column(values: np.ndarray) -> np.ndarray:
    return values.astype(float) if values.dtype.kind in "iufb" else np.array([str(value) for value in values], dtype=object)


def _field(name: str) -> str:
    """A name that MATLAB takes: letters, digits and underlines, a letter first."""
    plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")[:_LONGEST_NAME]
    return plain if plain[:1].isalpha() else f"x_{plain}"[:_LONGEST_NAME]
