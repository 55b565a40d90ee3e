"""`track-video`: a film of the deployment becomes the platform's trajectory."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.common import command_line as command
from measure.common.errors import InputError
from measure.film.options import options, project_from

if TYPE_CHECKING:
    from measure.film.dispersion import Dispersion
    from measure.film.track import Tracked
    from measure.footage.footage import Footage
    from measure.geometry.film_project import Project


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of the command."""
    return command.run("track-video", _work, arguments)


def _work(arguments: Sequence[str]) -> int:
    given = options().parse_args(arguments)
    project = project_from(given)
    footage_path = _footage_path(given, project)
    output = _output(given, project)
    _require_folders(output, given.marks, given.json, given.project, given.pictures, given.overlay)
    _require_files(given)
    from measure.film.summary import dispersion_lines, lines_for_people
    from measure.film.track import track
    from measure.footage.footage import open_footage

    footage = open_footage(footage_path)

    def watch(frames: Any) -> Any:
        return command.progress(frames, what="frames", total=footage.frames, quiet=given.quiet)

    tracked = track(footage, project, watch, _mask(given, project, footage))
    compared = _compared(given, tracked)
    note = _note(arguments, footage_path)
    written = _write(given, tracked, compared, note, footage_path, output)
    written += _shown(given, footage, tracked, compared, output)
    if not given.quiet:
        print("\n".join([*lines_for_people(tracked.summary), *dispersion_lines(compared), *(f"written   {path}" for path in written)]))
    return command.DONE if tracked.summary["verdict"] == "ok" else command.VERDICT_BAD


def _footage_path(given: argparse.Namespace, project: Project) -> Path:
    if given.footage is not None:
        return given.footage
    if project.film.file is None:
        raise InputError("no film; name a film file or a folder of numbered pictures.")
    return given.project.parent / project.film.file


def _output(given: argparse.Namespace, project: Project) -> Path | None:
    """Where the trajectory goes; without a scale there is none, and the marks in pixels must have been asked for."""
    if project.has_scale():
        return given.output or Path("trajectory.csv")
    if given.output is None and given.marks is not None:
        return None
    raise InputError(
        "no scale, so no metres. Give --mm-per-px S or --scale-from X1,Y1,X2,Y2,LENGTH_MM; "
        "for the marks in pixels alone give --marks FILE and no --output."
    )


def _require_folders(*files: Path | None) -> None:
    """All places must be there before the work begins, so that not half of the results are written."""
    for file in files:
        if file is not None and not file.parent.is_dir():
            raise InputError(f"{file}: the folder {file.parent} does not exist. Make it, or name another.")


def _mask_path(given: argparse.Namespace, project: Project) -> Path | None:
    if given.mask is not None or project.marks.mask is None:
        return given.mask
    return given.project.parent / project.marks.mask


def _mask(given: argparse.Namespace, project: Project, footage: Footage) -> Any:
    """Which pixels belong to marks, None where all of a subset does."""
    path = _mask_path(given, project)
    if path is None:
        return None
    from measure.footage.images import read_mask

    return read_mask(path, footage.width, footage.height)


def _require_files(given: argparse.Namespace) -> None:
    """What is read or written at the end must be usable before the long work begins."""
    for file in given.compare or ():
        command.existing_file(file, what="a trajectory (CSV)")
    if given.overlay is not None and given.overlay.suffix.lower() != ".avi":
        raise InputError(f"--overlay {given.overlay}: the film is written as .avi; name it so.")


def _note(arguments: Sequence[str], footage_path: Path) -> dict[str, Any]:
    from measure.common.output import provenance

    return provenance([footage_path], command=["track-video", *arguments])


def _compared(given: argparse.Namespace, tracked: Tracked) -> list[Dispersion]:
    """This film against those of `--compare`, before anything is written."""
    if not given.compare:
        return []
    if tracked.trajectory is None:
        raise InputError("--compare needs a scale, because trajectories are compared in metres; give --mm-per-px S.")
    from measure.film.dispersion import compare_with_files

    return compare_with_files(tracked.trajectory, given.compare)


def _shown(given: argparse.Namespace, footage: Footage, tracked: Tracked, compared: list[Dispersion], output: Path | None) -> list[Path]:
    """What is for the eye alone."""
    shown = []
    if given.pictures is not None:
        from measure.film.mark_plots import write_pictures

        shown += write_pictures(footage, tracked, given.pictures)
    if given.overlay is not None:
        from measure.film.overlay import overlaid
        from measure.footage.writers import write_film

        write_film(given.overlay, overlaid(footage, tracked), "MJPG")
        shown.append(given.overlay)
    if compared and output is not None and tracked.trajectory is not None:
        from measure.film.mark_plots import write_dispersion_figure

        shown.append(write_dispersion_figure(tracked.trajectory, compared, output.with_suffix(".dispersion.png")))
    return shown


def _write(
    given: argparse.Namespace,
    tracked: Tracked,
    compared: list[Dispersion],
    note: dict[str, Any],
    footage_path: Path,
    output: Path | None,
) -> list[Path]:
    from measure.common.output import write_json, write_provenance
    from measure.correlation.marks import write_marks
    from measure.geometry.film_project import read_project, write_project
    from measure.tables.trajectory import write_trajectory

    written = []
    if output is not None and tracked.trajectory is not None:
        from measure.film.mark_plots import write_trajectory_figure

        write_trajectory(tracked.trajectory, output)
        write_provenance(output, note)
        written += [output, write_trajectory_figure(tracked, output.with_suffix(".png"))]
    if given.marks is not None:
        write_marks(tracked.marks, given.marks)
        written.append(given.marks)
    place = given.project or written[0].with_suffix(".project.toml")
    complete = _with_files(tracked.project, footage_path, _mask_path(given, tracked.project), place)
    if not place.exists() or read_project(place) != complete:
        write_project(complete, place)
        written.append(place)
    if given.json is not None:
        dispersion = {"dispersion": [found.summary() for found in compared]} if compared else {}
        write_json(given.json, {**tracked.summary, **dispersion, "provenance": note})
        written.append(given.json)
    return written


def _with_files(project: Project, footage: Path, mask: Path | None, place: Path) -> Project:
    """The project with its files named from where it will stand."""
    import os

    def named(path: Path) -> str:
        return Path(os.path.relpath(path, place.parent)).as_posix()

    film = project.film.model_copy(update={"file": named(footage)})
    marks = project.marks.model_copy(update={"mask": None if mask is None else named(mask)})
    return project.model_copy(update={"film": film, "marks": marks})
