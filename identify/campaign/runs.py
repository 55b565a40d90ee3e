"""What was measured, run by run, and what each run changed about the model."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from identify.campaign.campaign_file import ListedRun, read_list
from identify.campaign.kept_films import kept
from identify.campaign.run import Run
from identify.loops.sign import oriented
from measure.common.errors import InputError
from measure.common.every_error import for_each
from measure.common.output import sha256
from measure.readers.column_mapping import ColumnMapping
from measure.readers.measurement import read_measurement
from measure.tables.loop import Loop


def read_campaign(paths: Iterable[Path], mapping: ColumnMapping | None = None) -> tuple[Run, ...]:
    """Read measurements: tables, or lists of runs (TOML); of a listed film the trajectory that `unspool run` keeps beside the list.

    Parameters
    ----------
    paths : of tables and lists.
    mapping : how tables are to be read that are not in the project's own columns, where a run says nothing itself.

    Returns
    -------
    tuple of Run
        In the order of the lists.

    Raises
    ------
    InputError
        A file cannot be read, a key is unknown, every run is held out, or two runs are the same file; all of them at once.
    """
    lists = for_each(lambda path: _runs_of(Path(path), mapping), paths)
    runs = tuple(run for listed in lists for run in listed)
    if all(run.hold_out for run in runs):
        raise InputError("every run is held out; at least one must be there to fit.")
    _require_distinct(runs)
    return _oriented(runs)


def files_of(paths: Iterable[Path]) -> list[Path]:
    """These files, and those that lists of runs (TOML) among them name, whether or not they exist.

    Raises
    ------
    InputError
        A list of runs cannot be read.
    """
    return [file for path in map(Path, paths) for file in (path, *(_named_in(path) if path.suffix.lower() == ".toml" else ()))]


def _named_in(path: Path) -> list[Path]:
    listed = read_list(path)
    rows = [name for row in listed.run for name in (row.file, row.mapping, row.project)]
    return [path.parent / name for name in (listed.model, *rows) if name is not None]


def _oriented(runs: Sequence[Run]) -> tuple[Run, ...]:
    """The runs with the signs of their loops as in the force law, and a remark where that took a turn."""
    loops = [run.table for run in runs if isinstance(run.table, Loop)]
    counted, turned = oriented(loops)
    if not turned.quantity:
        return tuple(runs)
    pairs = zip(counted, turned.each, strict=True)
    tables = iter(replace(loop, remarks=(*loop.remarks, said)) if said else loop for loop, said in pairs)
    return tuple(replace(run, table=next(tables)) if run.is_loop else run for run in runs)


def remarks(runs: Iterable[Run]) -> list[str]:
    """What was done to the rows of loops on reading them, in sentences."""
    return [f"{run.name}: {said}" for run in runs if isinstance(run.table, Loop) for said in run.table.remarks]


def _runs_of(path: Path, mapping: ColumnMapping | None) -> list[Run]:
    if path.suffix.lower() == ".toml":
        return for_each(lambda row: _listed_run(path.parent, row, mapping), _rows_of(path))
    return [Run(read_measurement(path, mapping), name=path.name, path=path)]


def _rows_of(path: Path) -> list[ListedRun]:
    rows = read_list(path).run
    if not rows:
        raise InputError(f'{path}: no [[run]] table; give one for each measurement, with file = "...".')
    return rows


def _listed_run(folder: Path, row: ListedRun, mapping: ColumnMapping | None) -> Run:
    if row.is_film(folder):
        table = kept(row, folder)
        return Run(read_measurement(table), row.model, row.hold_out, name=table.name, path=table)
    table = read_measurement(folder / row.file, row.reading(folder, mapping))
    return Run(table, row.model, row.hold_out, name=row.file, path=folder / row.file)


def _require_distinct(runs: Sequence[Run]) -> None:
    seen: dict[str, str] = {}
    for run in runs:
        if run.path is None:
            continue
        content = sha256(run.path)
        if content in seen:
            raise InputError(f"{run.name} and {seen[content]} hold the same measurement; give each run once.")
        seen[content] = run.name
