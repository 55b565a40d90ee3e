"""Films of a list of runs are measured once; their trajectories are kept in the folder `measured` beside the list."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from identify.campaign.campaign_file import ListedRun
from measure.common.errors import InputError
from measure.common.output import provenance_beside, sha256, temporary_prefix
from measure.common.output_gate import beside

FOLDER = "measured"


def table_of(row: ListedRun, folder: Path) -> Path:
    """Where the trajectory of a listed film is kept.

    Parameters
    ----------
    row, folder : the run, and the folder of the list.
    """
    parts = [part for part in Path(row.file).with_suffix("").parts if part not in ("..", "/")]
    return folder / FOLDER / f"{'-'.join(parts)}.csv"


def sources_of(row: ListedRun, folder: Path) -> list[Path]:
    """The film and its project file."""
    return [folder / name for name in (row.file, row.project) if name is not None]


def is_current(table: Path, sources: Iterable[Path]) -> bool:
    """Whether a trajectory is there, whole with what stands beside it, and was made from these files as they are now."""
    note = provenance_beside(table)
    if not (table.is_file() and note.is_file()) or _left_half(table):
        return False
    made_from = _made_from(note)
    return all(path.exists() and sha256(path) in made_from for path in sources)


def _left_half(table: Path) -> bool:
    """Whether a run was killed while it gave the trajectory, its note, figure or project their names; the next one tidies up."""
    written = (table, provenance_beside(table), beside(table, ".png"), beside(table, ".project.toml"))
    return any(left for path in written for left in table.parent.glob(f"{temporary_prefix(path)}*"))


def _made_from(note: Path) -> set[str]:
    """The hashes in a note of provenance; none where it is damaged."""
    try:
        return {str(entry["sha256"]) for entry in json.loads(note.read_text(encoding="utf-8"))["inputs"]}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return set()


def kept(row: ListedRun, folder: Path) -> Path:
    """The kept trajectory of a listed film.

    Raises
    ------
    InputError
        There is none, or the film or its project has changed since.
    """
    table, sources = table_of(row, folder), sources_of(row, folder)
    if is_current(table, sources):
        return table
    project = f" --project {sources[1]}" if row.project else ""
    raise InputError(
        f"{sources[0]}: is a film, and must be measured first. Type unspool run and the list, which keeps the trajectory as {table}, "
        f"or track-video {sources[0]}{project} -o {Path(row.file).stem}.csv and list that table."
    )
