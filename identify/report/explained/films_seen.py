"""The film behind a trajectory, found by the note that stands beside the table."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from identify.campaign.campaign_file import is_film
from identify.campaign.run import Run
from measure.common.errors import InputError
from measure.common.output import provenance_beside
from measure.geometry.film_project import read_project
from measure.pages.film_frame import FilmFrame, film_frame


def frame_of(runs: Iterable[Run]) -> tuple[str, FilmFrame] | None:
    """The first film that a run was measured from and that is still there: the run's name and its picture; none where there is none.

    A trajectory as `track-video` writes it has a note of what it was made from beside it, and a project file with the marks.
    """
    for run in runs:
        if run.path is not None and not run.is_loop and provenance_beside(run.path).is_file():
            frame = _frame(run.path)
            if frame is not None:
                return run.name, frame
    return None


def _frame(table: Path) -> FilmFrame | None:
    note = json.loads(provenance_beside(table).read_text(encoding="utf-8"))
    files = [Path(one["file"]) for one in note.get("inputs", [])]
    film = next((path for path in files if path.exists() and is_film(path)), None)
    projects = [path for path in (table.with_suffix(".project.toml"), *files) if path.suffix == ".toml" and path.is_file()]
    if film is None:
        return None
    for project in projects:
        try:
            marks = read_project(project).marks
            return film_frame(film, [(float(x), float(y)) for x, y in marks.place_px], marks.subset_px)
        except InputError:
            continue
    return None
