"""The points of a C3D file, read by c3d, which is an extra; `measure.readers.formats.guarded` calls it in a process of its own."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np

from measure.common.errors import InputError
from measure.readers.formats.vectors import Vectors, require_unpacked

_VALUES = 5  # of a point: x, y, z, residual, cameras


def vectors(path: Path) -> Vectors:
    """Time from the first frame, and x, y, z of every point, NaN where the residual says that it was not seen.

    Returns
    -------
    Vectors
        "time", then "NAME[1]", "NAME[2]", "NAME[3]" of each point, all with the unit of POINT:UNITS; as notes the axis up the screen
        (POINT:Y_SCREEN) and across it (POINT:X_SCREEN), as "z" or "-x", empty where the file does not say.

    Raises
    ------
    InputError
        It promises more numbers than a recording has, it ends early, or it says no rate. Whatever else a damaged file leads c3d to is
        raised as it comes.
    """
    import c3d

    with open(path, "rb") as file, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        reader = c3d.Reader(file)
        frames, points, rate = int(reader.frame_count), int(reader.point_used), float(reader.point_rate)
        require_unpacked(path, frames * points * _VALUES)
        if not rate > 0.0:
            raise InputError(f"{path}: says no frame rate (POINT:RATE). Export it again.")
        read = np.array([shown[:, :4] for _, shown, _ in reader.read_frames()], dtype=float).reshape(-1, points, 4)
        names, unit, axes = [str(name).strip() for name in reader.point_labels], reader.get("POINT:UNITS"), reader.get_screen_axis()
    if len(read) < frames:
        raise InputError(f"{path}: ends in frame {len(read) + 1} of {frames}; it is cut. Copy it again.")
    return _found(np.where(read[..., 3:] < 0.0, np.nan, read[..., :3]), names, rate, _text(unit), axes)


def _found(position: np.ndarray, names: list[str], rate: float, unit: str, axes: tuple[str, str] | None) -> Vectors:
    found = Vectors()
    found.values["time"], found.units["time"] = np.arange(len(position)) / rate, "s"
    for k in range(position.shape[1]):
        name = names[k] if k < len(names) and names[k] else f"point {k + 1}"
        name = name if f"{name}[1]" not in found.values else f"{name} ({k + 1})"
        for axis in range(3):
            found.values[f"{name}[{axis + 1}]"], found.units[f"{name}[{axis + 1}]"] = position[:, k, axis], unit
    across, up = axes or ("", "")
    found.notes = [_axis(up), _axis(across)]
    return found


def _axis(text: str) -> str:
    found = re.fullmatch(r"([+-]?)([XYZxyz])", text.strip())
    return found[1].replace("+", "") + found[2].lower() if found else ""


def _text(parameter: object) -> str:
    return str(getattr(parameter, "string_value", "")).strip(" \0")
