"""The options of `track-video`, and the project that they and a project file make together."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.common import command_line as command
from measure.common.errors import InputError
from measure.common.inputs import number, number_in, whole

if TYPE_CHECKING:
    from measure.geometry.film_project import Project

_DOES = "Track marks through a film and give the platform's trajectory, in metres, with an uncertainty for every frame."


def options() -> command.Parser:
    """The options of the command."""
    made = command.parser("track-video", _DOES, output="trajectory (CSV); its figure and project file stand beside it")
    made.add_argument("footage", nargs="?", type=Path, metavar="FOOTAGE", help="film file, or folder of numbered pictures")
    made.add_argument("--fps", type=number(), metavar="F", help="capture rate; needed unless the file carries the camera's own")
    made.add_argument(
        "--mark", type=_numbers(2), action="append", metavar="X,Y", help="a mark in the first frame, px; repeat it. Else marks are found"
    )
    made.add_argument("--subset", type=whole(-(10**9), 10**9), metavar="N", help="side of the compared square, odd, px (31)")
    made.add_argument("--warp", metavar="KIND", help="richest warp of a subset: translation, euclidean (and rotation) or affine (affine)")
    made.add_argument(
        "--mask", type=Path, metavar="FILE", help="a picture as large as the film's, white where marks are in the first frame"
    )
    made.add_argument("--mm-per-px", type=number(), metavar="S", help="scale at the platform's depth")
    made.add_argument("--scale-from", type=_numbers(5), metavar="X1,Y1,X2,Y2,LENGTH_MM", help="scale from two points and their distance")
    made.add_argument("--rule", type=_numbers(5), metavar="X1,Y1,X2,Y2,PITCH_MM", help="scale from a rule: a line across its graduation")
    made.add_argument("--plumb", type=_numbers(4), metavar="X1,Y1,X2,Y2", help="direction of up, from two points near a plumb line")
    made.add_argument("--checkerboard", type=Path, metavar="FOLDER", help="calibrate the lens with numbered pictures of a checkerboard")
    made.add_argument("--board", type=_numbers(3), metavar="COLUMNS,ROWS,MM", help="its inner corners and the side of a square")
    made.add_argument("--up", type=number(), metavar="DEG", help="direction of up in the picture, clockwise from the picture's own (0)")
    made.add_argument("--start-height-m", type=number(), metavar="H", help="height of the platform's origin in the first frame (0)")
    made.add_argument(
        "--project", type=Path, metavar="FILE", help="all of that, camera and mark geometry in TOML; it is read and never written"
    )
    made.add_argument(
        "--model", type=Path, metavar="MODEL", help="model file: start height and radius of the platform, where nothing else gives them"
    )
    made.add_argument("--radius-m", type=number(), metavar="R", help="radius of the upright cylinder that carries the marks")
    made.add_argument("--distance-m", type=number(), metavar="D", help="from the camera to the platform's origin")
    made.add_argument("--from", type=number(), metavar="T", dest="from_s", help="begin at this film time, s; zero is the first frame")
    made.add_argument("--to", type=number(), metavar="T", dest="to_s", help="end at this film time, s")
    made.add_argument("--fields", action="store_true", help="take each field of an interlaced film as a picture")
    made.add_argument("--readout-s", type=number(), metavar="T", help="rolling shutter: time from the first row of a picture to the last")
    made.add_argument("--marks", type=Path, metavar="FILE", help="write every mark in every frame (CSV)")
    made.add_argument("--pictures", type=Path, metavar="FOLDER", help="marks on the first frame, contact sheet and quality page (PNG)")
    made.add_argument("--overlay", type=Path, metavar="FILE", help="write the film with marks, status and residual drawn into it (.avi)")
    made.add_argument(
        "--choose",
        type=Path,
        metavar="PAGE",
        help="only write a page (.html) on which marks, scale, plumb line and time are chosen by eye",
    )
    made.add_argument("--report", type=Path, metavar="PAGE", help="write a page (.html): frames with marks and residuals, curves, quality")
    made.add_argument(
        "--compare", type=Path, action="append", metavar="CSV", help="trajectory of another film: how much the two differ; repeat it"
    )
    return command.examples(
        made,
        "track-video film.avi --fps 250 --mm-per-px 0.5 --model rig.toml -o film.csv",
        "track-video film.avi --fps 250 --choose page.html",
        "track-video film.avi --project film.toml -o film.csv --report report.html",
    )


def _numbers(count: int):
    def parse(text: str) -> tuple[float, ...]:
        try:
            values = tuple(number_in(part) for part in text.split(","))
        except ValueError:
            values = ()
        if len(values) != count or not all(abs(v) < 1e9 for v in values):
            raise argparse.ArgumentTypeError(f'"{text}" is not {count} numbers with commas between them')
        return values

    return parse


def project_from(given: argparse.Namespace) -> Project:
    """The project file with the options laid over it.

    Parameters
    ----------
    given : argparse.Namespace
        Parsed options.

    Returns
    -------
    Project

    Raises
    ------
    InputError
        The project file or a value cannot be used, options contradict each other.
    """
    from measure.geometry.film_project import make_project, read_project

    known = read_project(given.project) if given.project else make_project({})
    sections: dict[str, Any] = {"film": {}, "marks": {}, "scale": {}, "platform": {}, "camera": {}}
    table = {**sections, **known.model_dump(by_alias=True, exclude_none=True, exclude_unset=True)}
    scales = {"mm_per_px": given.mm_per_px, "from_px_mm": given.scale_from, "rule_px_mm": given.rule}
    if sum(value is not None for value in scales.values()) > 1:
        raise InputError("--mm-per-px, --scale-from and --rule each give the scale; give one.")
    if any(value is not None for value in scales.values()):
        table["scale"] = {k: v for k, v in table["scale"].items() if k not in scales}
    if given.up is not None:
        table["scale"].pop("plumb_px", None)
    table["camera"].update(_lens(given))
    table["platform"].update(_rig(given, known))
    laid_over = (
        ("film", "fps", given.fps),
        ("film", "from_s", given.from_s),
        ("film", "to_s", given.to_s),
        ("film", "fields", given.fields or None),
        ("marks", "place_px", given.mark),
        ("marks", "subset_px", given.subset),
        ("marks", "warp", given.warp),
        ("scale", "mm_per_px", given.mm_per_px),
        ("scale", "from_px_mm", given.scale_from),
        ("scale", "rule_px_mm", given.rule),
        ("scale", "plumb_px", given.plumb),
        ("scale", "up_deg", given.up),
        ("platform", "start_height_m", given.start_height_m),
        ("platform", "radius_m", given.radius_m),
        ("camera", "distance_m", given.distance_m),
        ("camera", "readout_s", given.readout_s),
    )
    for section, key, value in laid_over:
        if value is not None:
            table[section][key] = value
    return make_project(table, "options")


def _rig(given: argparse.Namespace, known: Project) -> dict[str, float]:
    """What `--model` says of the platform at the start, by the keys of the project file, unless that file gives it."""
    if given.model is None:
        return {}
    from measure.geometry.rig_at_start import read_rig_at_start

    rig = read_rig_at_start(given.model)
    found = {"start_height_m": rig.start_height_m, "radius_m": rig.radius_m}
    return {key: value for key, value in found.items() if key not in known.platform.model_fields_set}


def _lens(given: argparse.Namespace) -> dict[str, Any]:
    """The camera's lens from pictures of a checkerboard, by the keys of the project file."""
    if (given.checkerboard is None) != (given.board is None):
        raise InputError("--checkerboard FOLDER and --board COLUMNS,ROWS,MM belong together; give both.")
    if given.checkerboard is None:
        return {}
    from measure.footage.formats import open_footage
    from measure.geometry.lens_calibration import calibrate

    columns, rows, pitch_mm = given.board
    lens = calibrate(open_footage(given.checkerboard), int(columns), int(rows), pitch_mm)
    if not given.quiet:
        print(
            f"lens      focal length {lens.focal_px:.1f} +- {lens.focal_sigma_px:.1f} px; "
            f"{lens.views} of {lens.pictures} views, corners to {lens.rms_px:.3f} px"
        )
    keys = ("focal_px", "focal_sigma_px", "principal_px", "distortion")
    return {key: getattr(lens, key) for key in keys}
