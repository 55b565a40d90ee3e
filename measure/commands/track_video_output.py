"""What `track-video` writes: trajectory, marks, summary, figures, and the project file that repeats the run."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from measure.common.file_kinds import PROJECT, TABLE
from measure.common.output import provenance_beside, write_json, write_provenance, write_text
from measure.common.output_gate import Outputs, beside
from measure.film.dispersion import Dispersion
from measure.film.overlay import overlaid, write_first_frame
from measure.film.saved_plots import FIGURES, write_dispersion_figure, write_pictures, write_trajectory_figure
from measure.film.tracked import Tracked
from measure.film_pages.report_page import report_page
from measure.footage.footage import Footage
from measure.footage.writers import write_film
from measure.geometry.film_project import Project, read_project, write_project
from measure.tables.csv_cells import write_columns
from measure.tables.trajectory import write_trajectory

_FIRST_FRAME = "first_frame.png"


@dataclass(frozen=True)
class Output:
    """Where each result goes; None where it is not wanted. `project` : the file that was read, which is never written."""

    trajectory: Path | None
    marks: Path | None
    json: Path | None
    pictures: Path | None
    overlay: Path | None
    project: Path | None
    report: Path | None = None


def gate(output: Output, inputs: Sequence[Path], compared: bool) -> Outputs:
    """All that the command writes, under the names that its sentences use, and what it reads besides.

    Parameters
    ----------
    output : Output
    inputs : sequence of Path
    compared : bool
        Whether other films are compared.
    """
    files: dict[str, Path | None] = {"--marks": output.marks, "--json": output.json, "--overlay": output.overlay, "--report": output.report}
    if output.trajectory is not None:
        files["the trajectory"] = output.trajectory
        files["its provenance"] = provenance_beside(output.trajectory)
        files["its figure"] = beside(output.trajectory, ".png")
        files["the figure of the dispersion"] = beside(output.trajectory, ".dispersion.png") if compared else None
    first = output.trajectory or output.marks
    files["the project file"] = None if first is None else _project_place(first, output.project)
    films = [film for path in inputs if path.suffix.lower() in (".mraw", ".cih", ".cihx") for film in path.parent.glob(f"{path.stem}.*")]
    folders = {"--pictures": (output.pictures, (_FIRST_FRAME, *FIGURES))}
    return Outputs(files, folders, [*inputs, *films], {"the trajectory": TABLE, "the project file": PROJECT})


def _project_place(first: Path, read: Path | None) -> Path:
    """Where the project file goes that repeats the run: never onto the one that was read."""
    place = beside(first, ".project.toml")
    if read is not None and place.exists() and place.samefile(read):
        return beside(first, ".repeat.project.toml")
    return place


def written(
    output: Output, tracked: Tracked, compared: Sequence[Dispersion], note: dict[str, Any], film: Path, mask: Path | None
) -> list[Path]:
    """Write tables, summary and project file.

    Parameters
    ----------
    output : Output
    tracked : Tracked
    compared : sequence of Dispersion
    note : dict
        Provenance.
    film, mask : Path
        What was read, for the project file; mask may be None.

    Returns
    -------
    list of Path
        The files that a user looks for.
    """
    files = []
    if output.trajectory is not None and tracked.trajectory is not None:
        write_trajectory(tracked.trajectory, output.trajectory)
        write_provenance(output.trajectory, note)
        files += [output.trajectory, write_trajectory_figure(tracked, beside(output.trajectory, ".png"))]
    if output.marks is not None:
        write_columns(tracked.marks.columns(), output.marks)
        files.append(output.marks)
    files += _written_project(files[0], output.project, tracked.project, film, mask)
    if output.json is not None:
        dispersion = {"dispersion": [found.summary() for found in compared]} if compared else {}
        write_json(output.json, {**tracked.summary, **dispersion, "provenance": note})
        files.append(output.json)
    return files


def _written_project(first: Path, read: Path | None, project: Project, film: Path, mask: Path | None) -> list[Path]:
    """The project file that repeats the run, beside an output; not needed where the file that was read does that."""
    if read is not None and read_project(read) == _with_files(project, film, mask, read):
        return []
    place = _project_place(first, read)
    write_project(_with_files(project, film, mask, place), place)
    return [place]


def _with_files(project: Project, film: Path, mask: Path | None, place: Path) -> Project:
    """The project with its files named from where it will stand."""

    def named(path: Path) -> str:
        return Path(os.path.relpath(path, place.parent)).as_posix()

    section = project.film.model_copy(update={"file": named(film)})
    marks = project.marks.model_copy(update={"mask": None if mask is None else named(mask)})
    return project.model_copy(update={"film": section, "marks": marks})


def written_for_the_eye(
    output: Output, footage: Footage, tracked: Tracked, compared: Sequence[Dispersion], note: dict[str, Any]
) -> list[Path]:
    """Write pictures, the overlaid film, the report and the figure of the dispersion. Returns their paths."""
    files = []
    if output.pictures is not None:
        output.pictures.mkdir(parents=True, exist_ok=True)
        files.append(write_first_frame(footage, tracked, output.pictures / _FIRST_FRAME))
        files += write_pictures(footage, tracked, output.pictures)
    if output.overlay is not None:
        write_film(output.overlay, overlaid(footage, tracked), "MJPG")
        files.append(output.overlay)
    if output.report is not None:
        write_text(output.report, report_page(footage, tracked, note))
        files.append(output.report)
    if compared and output.trajectory is not None and tracked.trajectory is not None:
        files.append(write_dispersion_figure(tracked.trajectory, compared, beside(output.trajectory, ".dispersion.png")))
    return files
