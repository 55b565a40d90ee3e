"""`track-video`: a film of the deployment becomes the platform's trajectory."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.commands.track_video_choose import require_page, write_choose_page
from measure.commands.track_video_missing import assumptions, require_complete
from measure.commands.track_video_options import options, project_from
from measure.common import command_line as command
from measure.common.errors import InputError
from measure.common.inputs import LARGEST_TABLE, existing_file

if TYPE_CHECKING:
    from measure.commands.track_video_output import Output
    from measure.film.dispersion import Dispersion
    from measure.film.tracked import Tracked
    from measure.footage.footage import Footage
    from measure.geometry.film_project import Project


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the process unless given.

    Returns
    -------
    int
        Exit status: 0 done; 1 done, but the verdict is not ok: film incomplete, marks lost, nothing moves, no rigid
        body; 2 unusable input, nothing written.
    """
    return command.run("track-video", _work, arguments)


def _work(arguments: Sequence[str]) -> int:
    given = options().parse_args(arguments)
    project = project_from(given)
    film, mask = _film_path(given, project), _mask_path(given, project)
    if given.choose is not None:
        lines = write_choose_page(given, project, film, _inputs(given, film, mask))
        if not given.quiet:
            command.say(*lines)
        return command.DONE
    _require_usable(given, mask)
    from measure.commands.track_video_output import Output, gate

    output = Output(_trajectory_path(given, project), given.marks, given.json, given.pictures, given.overlay, given.project, given.report)
    with gate(output, _inputs(given, film, mask), bool(given.compare)).held():
        status, lines = _tracked(given, arguments, project, output, film, mask)
    if not given.quiet:
        command.say(*lines)
    return status


def _tracked(
    given: argparse.Namespace, arguments: Sequence[str], project: Project, output: Output, film: Path, mask: Path | None
) -> tuple[int, list[str]]:
    """Follow the marks and write what came out; status, and the lines for people."""
    from measure.commands.track_video_output import gate, written, written_for_the_eye
    from measure.common.output import provenance
    from measure.film.part import part_of
    from measure.film.summary import dispersion_lines, lines_for_people
    from measure.film.track import track
    from measure.footage.formats import open_footage

    whole = open_footage(film)
    require_complete(given, project, whole)
    footage = part_of(whole, project)
    note = provenance(_inputs(given, film, mask), command=["track-video", *arguments])

    less = "Give fewer marks, a smaller --subset, or a part of the film by --from and --to."

    def watch(frames: Any) -> Any:
        return command.progress(frames, what="frames", total=footage.frames, quiet=given.quiet, change=less)

    tracked = track(footage, project, watch, _read_mask(mask, footage))
    note["film"] = {key: tracked.summary["film"][key] for key in ("from_s", "to_s", "first_frame")}
    note["noise"] = tracked.summary["noise"]
    compared = _compared(given, tracked)
    with gate(output, (), bool(compared)).together():
        files = written(output, tracked, compared, note, film, mask) + written_for_the_eye(output, footage, tracked, compared, note)
    assumed = [f"assumed   {one}" for one in assumptions(project)] if output.trajectory is not None else []
    lines = [*lines_for_people(tracked.summary), *assumed, *dispersion_lines(compared), *(f"written   {path}" for path in files)]
    if output.trajectory is not None:
        lines.append(command.next_command("explain-gap", given.model or "MODEL", output.trajectory, "LOOPS"))
    return (command.DONE if tracked.summary["verdict"] == "ok" else command.VERDICT_BAD), lines


def _film_path(given: argparse.Namespace, project: Project) -> Path:
    if given.footage is not None:
        return given.footage
    if project.film.file is None:
        raise InputError("no film; name a film file or a folder of numbered pictures.")
    return (given.project.parent if given.project else Path()) / project.film.file


def _mask_path(given: argparse.Namespace, project: Project) -> Path | None:
    if given.mask is not None or project.marks.mask is None:
        return given.mask
    return given.project.parent / project.marks.mask


def _trajectory_path(given: argparse.Namespace, project: Project) -> Path | None:
    """Where the trajectory goes; None without a scale."""
    return given.output or Path("trajectory.csv") if project.has_scale() else None


def _inputs(given: argparse.Namespace, film: Path, mask: Path | None) -> list[Path]:
    return [path for path in (film, given.project, given.model, mask, given.checkerboard, *(given.compare or ())) if path is not None]


def _require_usable(given: argparse.Namespace, mask: Path | None) -> None:
    """What is read or written at the end must be usable before the long work begins."""
    for file in given.compare or ():
        existing_file(file, what="a trajectory (CSV)", most=LARGEST_TABLE)
    if mask is not None:
        existing_file(mask, what="a mask (PNG, BMP, TIFF)", most=LARGEST_TABLE)
    require_page("--report", given.report)
    if given.overlay is not None and given.overlay.suffix.lower() != ".avi":
        raise InputError(f"--overlay {given.overlay}: the film is written as .avi; name it so.")


def _read_mask(path: Path | None, footage: Footage) -> Any:
    """Which pixels belong to marks, None where all of a subset does."""
    if path is None:
        return None
    from measure.footage.picture_file import read_mask

    return read_mask(path, footage.width, footage.height)


def _compared(given: argparse.Namespace, tracked: Tracked) -> list[Dispersion]:
    """This film against those of `--compare`, before anything is written."""
    if not given.compare or tracked.trajectory is None:
        return []
    from measure.film.dispersion import compare_with_files

    return compare_with_files(tracked.trajectory, given.compare)
