"""What was measured, run by run, and what each run changed about the model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from identify.campaign.run import Run
from identify.loops.sign import oriented
from measure.common.errors import InputError, nearest
from measure.common.output import sha256
from measure.readers.column_mapping import ColumnMapping, read_mapping
from measure.readers.measurement import read_measurement
from measure.tables.loop import Loop
from simulate.files.model_file import read_document

_RUN_KEYS = ("file", "model", "hold_out", "mapping")


def read_campaign(paths: Iterable[Path], mapping: ColumnMapping | None = None) -> tuple[Run, ...]:
    """Read measurements: tables, or lists of runs (TOML).

    Parameters
    ----------
    mapping : how loops are to be read that are not in the project's own columns, where a run names no mapping file of its own.

    Raises
    ------
    InputError
        A file cannot be read, a key is unknown, every run is held out, or two runs are the same file.
    """
    runs = tuple(run for path in paths for run in _runs_of(Path(path), mapping))
    if all(run.hold_out for run in runs):
        raise InputError("every run is held out; at least one must be there to fit.")
    _require_distinct(runs)
    return _oriented(runs)


def _oriented(runs: Sequence[Run]) -> tuple[Run, ...]:
    """The runs with the signs of their loops as in the force law, and a remark where that took a turn."""
    loops = [run.table for run in runs if isinstance(run.table, Loop)]
    counted, turned = oriented(loops)
    if not turned.quantity:
        return tuple(runs)
    tables = iter(replace(loop, remarks=(*loop.remarks, turned.sentence)) for loop in counted)
    return tuple(replace(run, table=next(tables)) if run.is_loop else run for run in runs)


def remarks(runs: Iterable[Run]) -> list[str]:
    """What was done to the rows of loops on reading them, in sentences."""
    return [f"{run.name}: {said}" for run in runs if isinstance(run.table, Loop) for said in run.table.remarks]


def _runs_of(path: Path, mapping: ColumnMapping | None) -> list[Run]:
    if path.suffix.lower() == ".toml":
        return _listed_runs(path, mapping)
    return [Run(read_measurement(path, mapping), name=path.name, path=path)]


def _listed_runs(path: Path, mapping: ColumnMapping | None) -> list[Run]:
    document = read_document(path)
    for key in document:
        if key != "run":
            raise InputError(f'{path}: unknown key "{key}"; a list of runs has [[run]] tables only.')
    rows = document.get("run", [])
    if not isinstance(rows, list) or not rows:
        raise InputError(f'{path}: no [[run]] table; give one for each measurement, with file = "...".')
    return [_listed_run(path, row, mapping) for row in rows]


def _listed_run(path: Path, row: Mapping[str, Any], mapping: ColumnMapping | None) -> Run:
    for key in row:
        if key not in _RUN_KEYS:
            raise InputError(f'{path}, [[run]]: unknown key "{key}"; {nearest(key, _RUN_KEYS)}')
    name, hold_out, changes = row.get("file"), row.get("hold_out", False), row.get("model", {})
    if not isinstance(name, str):
        raise InputError(f'{path}, [[run]]: file is {name!r}; give the name of a table, such as file = "test1.csv".')
    if not isinstance(hold_out, bool) or not isinstance(changes, Mapping):
        raise InputError(f"{path}, [[run]] {name}: hold_out is true or false, and model is a table of values to change.")
    if "mapping" in row:
        mapping = _named_mapping(path, name, row["mapping"])
    return Run(read_measurement(path.parent / name, mapping), changes, hold_out, name=name, path=path.parent / name)


def _named_mapping(path: Path, run: str, name: object) -> ColumnMapping:
    if not isinstance(name, str):
        raise InputError(f'{path}, [[run]] {run}: mapping is {name!r}; give the name of a mapping file, such as mapping = "rig.toml".')
    return read_mapping(path.parent / name)


def _require_distinct(runs: Sequence[Run]) -> None:
    seen: dict[str, str] = {}
    for run in runs:
        if run.path is None:
            continue
        content = sha256(run.path)
        if content in seen:
            raise InputError(f"{run.name} and {seen[content]} hold the same measurement; give each run once.")
        seen[content] = run.name
