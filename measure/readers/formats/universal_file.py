"""The functions of a universal file (UFF, data sets 58 and 58b), read by pyuff, which is an extra."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from measure.readers.formats.vectors import Vectors, require_unpacked

_FUNCTION, _TIME = 58, 17
_KINDS = {8: "displacement", 9: "force", 11: "velocity", 12: "acceleration", 13: "force", 15: "pressure", 17: "time"}


def vectors(path: Path) -> Vectors:
    """Every real function by its label or its kind, and the abscissa of the first one, which must be a time to count as one.

    Raises
    ------
    InputError
        More numbers than a loop has. Whatever else a damaged file leads pyuff to is raised as it comes.
    """
    import pyuff

    file = pyuff.UFF(str(path))
    places = [k for k, kind in enumerate(file.get_set_types()) if int(kind) == _FUNCTION]
    sets: list[Any] = [file.read_sets(k) for k in places]
    found = Vectors()
    require_unpacked(path, sum(len(one["data"]) for one in sets))
    for one in sets:
        _add(found, one)
    return found


def _add(found: Vectors, one: dict[str, Any]) -> None:
    values = np.asarray(one["data"])
    if np.iscomplexobj(values):
        return
    if not found.values:
        kind = int(one.get("abscissa_spec_data_type", 0))
        name = _KINDS.get(kind, "") or _label(one, "abscissa") or "abscissa"
        found.add(name, np.asarray(one["x"], dtype=float), _unit(one, "abscissa", "s" if kind == _TIME else ""))
    name = _label(one, "ordinate") or _KINDS.get(int(one.get("ordinate_spec_data_type", 0)), "") or str(one.get("id1", "")).strip()
    name = name if name not in found.values else f"{name} ({len(found.values)})"
    found.add(name or f"function {len(found.values)}", values.astype(float), _unit(one, "ordinate", ""))


def _label(one: dict[str, Any], axis: str) -> str:
    text = str(one.get(f"{axis}_axis_lab", "")).strip()
    return "" if text.upper() in ("NONE", "USER") else text


def _unit(one: dict[str, Any], axis: str, usual: str) -> str:
    text = str(one.get(f"{axis}_axis_units_lab", "")).strip()
    return usual if text.upper() in ("NONE", "") else text
