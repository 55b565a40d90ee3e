"""Tables as pandas frames, with the unit of every column in `frame.attrs["units"]`; pandas is loaded when a frame is asked for."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame

_SYMBOL = "(?:s|ms|m|mm|um|px|rad|deg|N|kN|kg|Hz|V|J|bar|degC|percent)\\d?"
_IN_NAME = re.compile(rf"(?:^|_)(?P<above>{_SYMBOL}(?:_{_SYMBOL}){{0,9}})?(?:_?per_(?P<below>{_SYMBOL}(?:_{_SYMBOL}){{0,9}}))?$")


def frame_of(columns: Mapping[str, Iterable], units: Mapping[str, str] | None = None, *, name: str = "") -> DataFrame:
    """A pandas frame of columns of equal lengths, with their units.

    Parameters
    ----------
    columns : numbers or words by the name of the column.
    units : by column; of those that are not named here, what the name of the column says (`force_N` is in N).
    name : kept in `frame.attrs["name"]`.

    Returns
    -------
    pandas.DataFrame
        `attrs["units"]` holds the unit of every column, "" where it has none.
    """
    from pandas import DataFrame

    frame = DataFrame({key: values if isinstance(values, np.ndarray) else list(values) for key, values in columns.items()})
    frame.attrs["units"] = {key: (units or {}).get(key, unit_in_name(key)) for key in columns}
    if name:
        frame.attrs["name"] = name
    return frame


def unit_in_name(name: str) -> str:
    """The unit that the name of a column carries: `speed_m_per_s` is in m/s, `beta_per_m` in 1/m; "" where it carries none."""
    found = _IN_NAME.search(name)
    if not found:
        return ""
    above, below = ((found[side] or "").replace("_", " ") for side in ("above", "below"))
    return f"{above or '1'}/{below}" if below else above


def columns_of(frame: DataFrame, name: str) -> dict[str, Array | list[str]]:
    """The columns of a frame by name: numbers as an array, words as a list.

    Parameters
    ----------
    name : what the frame is called in a sentence.

    Raises
    ------
    InputError
        Two columns share a name.
    """
    names = [str(column) for column in frame.columns]
    double = sorted({column for column in names if names.count(column) > 1})
    if double:
        raise InputError(f'{name}: two columns are named "{double[0]}"; rename one.')
    return {column: _column(frame[given].to_numpy()) for column, given in zip(names, frame.columns, strict=True)}


def _column(values: np.ndarray) -> Array | list[str]:
    if values.dtype.kind in "iufb":
        return values.astype(float)
    return ["" if value is None or value != value else str(value) for value in values]  # a missing word differs from itself
