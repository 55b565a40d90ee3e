"""Tables in JSON: rows with or without names, records, columns by name, one record a line; they may stand inside of other things."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.common.inputs import existing_file
from measure.readers.formats.vectors import Vectors, require_unpacked, table_of
from measure.readers.text.encoding import decoded
from measure.readers.timestamps import is_stamp, seconds_of
from measure.tables.raw_table import RawTable

LARGEST_JSON = 200_000_000  # bytes; as objects it takes some ten times that
_DEEPEST = 6
_NAMES = ("columns", "names", "header", "channels", "fields", "labels")
_VALUES = ("data", "values", "samples", "rows")
_UNITS = ("unit", "units")


def looks_like_json(head: bytes) -> bool:
    """Whether the first bytes of a file may begin a JSON text that holds a table: a bracket, and no word without quotes behind it."""
    shown = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    return shown[:1] in (b"{", b"[") and shown[1:].lstrip()[:1] in (b'"', b"[", b"{", b"-", *(b"%d" % k for k in range(10)))


def read_json(path: Path, encoding: str | None = None) -> RawTable | None:
    """The table in a JSON file; None where the text is no JSON.

    Raises
    ------
    InputError
        Too large, nested too deeply, no vectors of one length.
    """
    existing_file(path, what="a table in JSON", most=LARGEST_JSON)
    text, _ = decoded(path, encoding)
    try:
        document = _parsed(text)
    except RecursionError:
        raise InputError(f"{path}: is nested too deeply for a table. Export the loop as text.") from None
    except ValueError as error:
        if path.suffix.lower() in (".json", ".jsonl", ".ndjson"):
            raise InputError(f"{path}: is not JSON: {str(error)[:200]}. Export the loop again, or as text.") from None
        return None
    found = Vectors()
    _collect(found, "", document, str(path), 0)
    require_unpacked(path, sum(len(values) for values in found.values.values()))
    return table_of(path, "JSON", found)


def _parsed(text: str) -> Any:
    """The document, or the records of which one stands in each line."""
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        if not error.msg.startswith("Extra data"):
            raise
        return [json.loads(line) for line in text.splitlines() if line.strip()]


def _collect(found: Vectors, name: str, value: Any, place: str, depth: int) -> None:
    """Put every vector of numbers into `found`, inner ones under dotted names."""
    if depth > _DEEPEST:
        return
    if isinstance(value, Mapping):
        _of_object(found, name, value, place, depth)
    elif isinstance(value, list) and value:
        _of_list(found, name, value, (), place, depth)
    elif isinstance(value, str | int | float) and name:
        found.notes.append(f"{name} = {value}")


def _of_object(found: Vectors, name: str, value: Mapping[str, Any], place: str, depth: int) -> None:
    names = next(([_name_of(n) for n in value[key]] for key in _NAMES if _is_list_of_names(value.get(key))), [])
    samples = next((value[key] for key in _VALUES if isinstance(value.get(key), list)), None)
    unit = next((value[key] for key in _UNITS if isinstance(value.get(key), str)), "")
    if names and samples is not None:
        _of_list(found, name, samples, names, place, depth)
    elif samples is not None and unit and name and not isinstance(samples[0], list | dict):
        _add(found, name, samples, unit, place)
    elif _are_alike(value):  # as pandas writes a frame: a table of cells by row for each column
        for key, cells in value.items():
            _add(found, _joined(name, key), list(cells.values()), "", place)
    else:
        for key, inner in value.items():
            bare = key in _VALUES and isinstance(inner, list)
            _collect(found, name if bare and name else _joined(name, str(key)), inner, place, depth + 1)


def _of_list(found: Vectors, name: str, value: list[Any], names: Sequence[str], place: str, depth: int) -> None:
    first = value[0] if value else None
    if isinstance(first, Mapping):
        _of_objects(found, name, [row for row in value if isinstance(row, Mapping)], place, depth)
    elif isinstance(first, list):
        _of_rows(found, name, value, names, place)
    elif name:
        _add(found, name, value, "", place)


def _of_objects(found: Vectors, name: str, rows: list[Mapping[str, Any]], place: str, depth: int) -> None:
    """Records of one sample each, or one object for each channel."""
    keys = [key for key, cell in rows[0].items() if not isinstance(cell, list | dict)]
    if len(keys) == len(rows[0]) > 1 and len(rows) > 1:
        for key in dict.fromkeys(key for row in rows for key in row):
            _add(found, _joined(name, key), [row.get(key) for row in rows], "", place)
        return
    for k, row in enumerate(rows):
        label = next((str(row[key]) for key in ("name", "label", "channel") if isinstance(row.get(key), str)), "")
        _collect(found, label or _joined(name, str(k + 1)), row, place, depth + 1)


def _of_rows(found: Vectors, name: str, value: list[Any], names: Sequence[str], place: str) -> None:
    """Rows of one length; or one list for each name."""
    width = max((len(row) for row in value if isinstance(row, list)), default=0)
    if any(not isinstance(row, list) or len(row) != width for row in value):
        return
    columns = value if names and len(names) == len(value) != width else list(map(list, zip(*value, strict=True)))
    for k, column in enumerate(columns):
        _add(found, names[k] if len(names) == len(columns) else f"{name or 'data'}[{k + 1}]", column, "", place)


def _add(found: Vectors, name: str, cells: Sequence[Any], unit: str, place: str) -> None:
    stamps = isinstance(cells[0], str) and is_stamp(cells[0].strip()) if cells else False
    if stamps:
        found.add(name, seconds_of([str(cell).strip() for cell in cells], f'{place}, "{name}"'), "s")
        return
    values = _numbers(cells)
    if values is not None and values.size > 1:
        found.add(name, values, unit)


def _numbers(cells: Sequence[Any]) -> Array | None:
    """Cells as numbers, NaN for null; None where they are words or lists."""
    if any(isinstance(cell, str | list | dict | bool) for cell in cells):
        return None
    try:
        return np.array([np.nan if cell is None else float(cell) for cell in cells])
    except OverflowError:
        return None


def _is_list_of_names(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(_name_of(one), str) for one in value)


def _name_of(one: Any) -> Any:
    """A name that stands alone, or with its unit in an object."""
    if not isinstance(one, Mapping):
        return one
    name, unit = one.get("name", one.get("label")), next((one[key] for key in _UNITS if one.get(key)), "")
    return f"{name} [{unit}]" if isinstance(name, str) and unit else name


def _are_alike(value: Mapping[str, Any]) -> bool:
    """Whether all members are objects of plain cells with the same keys."""
    members = list(value.values())
    alike = len(members) > 1 and all(isinstance(one, Mapping) and one.keys() == members[0].keys() for one in members)
    return alike and len(members[0]) > 1 and not any(isinstance(cell, list | dict | str) for one in members for cell in one.values())


def _joined(name: str, key: str) -> str:
    return f"{name}.{key}" if name else str(key)
