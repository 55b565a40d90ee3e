"""LabVIEW's measurement files, .lvm (text) and .tdms (binary), as tables; their readers lvm_read and npTDMS are an extra.

Of lvm_read only the parser of text is used: its reader of files loads a pickle that lies beside the file, which may run
anything, and writes one.
"""

from __future__ import annotations

import logging
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, clipped
from measure.common.optional_packages import required
from measure.readers.formats.vectors import Vectors, numbers_of, require_size, require_unpacked, table_of
from measure.readers.text.encoding import decoded
from measure.tables.raw_table import RawTable

_X = "X_Value"
_EXPORT = "export it as text without headers"
_SHOWN = 120  # characters of what a package says; it may quote the file


def read_lvm(path: Path, encoding: str | None = None) -> RawTable:
    """The segments of a LabVIEW measurement file, one behind the other; a time that is only implied is written out.

    Raises
    ------
    InputError
        lvm_read is not installed, a damaged file, segments that do not follow each other.
    """
    lvm_read = required("lvm_read", path, "a LabVIEW measurement file", "labview", _EXPORT)
    text, _ = decoded(path, encoding)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SyntaxWarning)  # of numbers in the head that are none; the error behind it says so
            read = lvm_read.read_str(text)
        segments = [read[k] for k in range(read["Segments"])]
        parts = [_lvm_columns(read, segment) for segment in segments]
    except (ValueError, KeyError, IndexError, TypeError, SyntaxError, RecursionError, MemoryError, AttributeError) as error:
        raise InputError(f"{path}: cannot be read as a LabVIEW measurement file: {clipped(repr(error), _SHOWN)}. Or {_EXPORT}.") from error
    if not parts or any(list(part) != list(parts[0]) for part in parts):
        raise InputError(f"{path}: holds {len(parts)} segments of different channels. Save one test in one file.")
    _require_one_clock(path, parts)
    units = _lvm_units(segments[0], list(parts[0]))
    notes = [f"{key} = {value}" for key, value in read.items() if isinstance(key, str) and isinstance(value, str) and key]
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return table_of(path, "LabVIEW text", Vectors(joined, units, notes))


def _lvm_columns(read: Mapping[str, Any], segment: Mapping[str, Any]) -> dict[str, Array]:
    """Columns of a segment by name: the time first, then the channels; columns without a number are left out."""
    names, data = segment["Channel names"], np.atleast_2d(segment["data"])
    made: dict[str, Array] = {}
    for name, column in zip(names, data.T, strict=False):
        known = made.get(name)
        if np.all(np.isnan(column)) or (known is not None and np.array_equal(known, column, equal_nan=True)):
            continue
        made[name if known is None else f"{name} ({sum(key.startswith(name) for key in made) + 1})"] = column
    if read.get("X_Columns") == "No":
        made = {_X: float(segment["X0"][0]) + float(segment["Delta_X"][0]) * np.arange(len(data)), **made}
    is_time = _first(segment.get("X_Dimension")) in ("", "Time") and "time" not in made
    return {"time" if name == _X and is_time else name: column for name, column in made.items()}


def _lvm_units(segment: Mapping[str, Any], names: Sequence[str]) -> dict[str, str]:
    labels = dict(zip([n for n in segment["Channel names"] if n not in (_X, "Comment")], segment.get("Y_Unit_Label", []), strict=False))
    seconds = _first(segment.get("X_Unit_Label")) or "s"
    return {name: seconds if name == "time" else str(labels.get(name, "")) for name in names}


def _first(values: Any) -> str:
    return str(values[0]).strip() if isinstance(values, list) and values else ""


def _require_one_clock(path: Path, parts: Sequence[Mapping[str, Array]]) -> None:
    """Segments may follow each other in time; two that overlap are two tests."""
    times = [part["time"] for part in parts if "time" in part and len(part["time"])]
    for k, (before, after) in enumerate(pairwise(times), start=1):
        if not after[0] > before[-1]:
            raise InputError(
                f"{path}: holds {len(parts)} segments, and segment {k + 1} begins at {after[0]:g} s, before segment {k} ends. "
                "Save one test in one file."
            )


def read_tdms(path: Path) -> RawTable:
    """The channels of a TDMS file that share the most common length; with one group by their own names, else `group/channel`.

    Where no channel is a time and all waveforms have one increment, a column `time` is made of it.

    Raises
    ------
    InputError
        npTDMS is not installed, a damaged file, no two channels of one length.
    """
    nptdms = required("nptdms", path, "a LabVIEW TDMS file", "labview", "export it as text")
    require_size(path)
    try:
        with _complaints() as said, nptdms.TdmsFile.open(path) as file:
            found = _tdms_vectors(path, file)
    except InputError:
        raise
    except Exception as error:  # damaged files raise whatever the place that they are damaged at leads to
        raise InputError(f"{path}: cannot be read as TDMS: {clipped(repr(error), _SHOWN)}. Save it again, or export it as text.") from error
    if said:
        raise InputError(f"{path}: is cut or damaged: {said[0]}. Save it again, or export what is whole of it as text.")
    return table_of(path, "TDMS", found)


@contextmanager
def _complaints() -> Iterator[list[str]]:
    """What npTDMS has to say of a file, which it would only log: it reads a cut file as far as it goes."""
    said: list[str] = []

    def kept(record: logging.LogRecord) -> bool:
        said.append(record.getMessage()[:200])
        return False

    handlers = {id(h): h for name in ("reader", "types", "tdms_segment") for h in logging.getLogger(f"nptdms.{name}").handlers}.values()
    for handler in handlers:
        handler.addFilter(kept)
    try:
        yield said
    finally:
        for handler in handlers:
            handler.removeFilter(kept)


def _tdms_vectors(path: Path, file: Any) -> Vectors:
    channels = [channel for group in file.groups() for channel in group.channels() if len(channel)]
    require_unpacked(path, sum(len(channel) for channel in channels))
    one_group = len({channel.group_name for channel in channels}) == 1
    notes = [f"{key} = {value}" for holder in (file, *file.groups()) for key, value in holder.properties.items()]
    found, clocks = Vectors(notes=notes), {}
    for channel in channels:
        values = numbers_of(channel[:])
        if values is not None:
            name = channel.name if one_group else f"{channel.group_name}/{channel.name}"
            is_instant = np.issubdtype(channel.dtype, np.datetime64)
            found.add(name, values, "s" if is_instant else str(channel.properties.get("unit_string", "")))
            clocks[name] = (len(values), channel.properties.get("wf_increment"), channel.properties.get("wf_start_offset", 0.0))
    return _with_time(found, list(clocks.values()))


def _with_time(found: Vectors, clocks: Sequence[tuple[int, Any, Any]]) -> Vectors:
    if not clocks or any(name.lower().startswith("time") for name in found.values):
        return found
    size = Counter(n for n, _, _ in clocks).most_common(1)[0][0]
    kept = {(increment, offset) for n, increment, offset in clocks if n == size}
    increment, offset = next(iter(kept))
    if len(kept) == 1 and increment:
        time = float(offset) + float(increment) * np.arange(size)
        return Vectors({"time": time, **found.values}, {"time": "s", **found.units}, found.notes)
    return found
