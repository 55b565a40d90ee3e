"""`track-video --choose`: the page on which marks and scale are chosen by eye, in place of tracking."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from measure.common import command_line as command
from measure.common.errors import InputError

if TYPE_CHECKING:
    from measure.geometry.film_project import Project


def write_choose_page(given: argparse.Namespace, project: Project, film: Path, inputs: Sequence[Path]) -> list[str]:
    """Write the page. Lines for people.

    Parameters
    ----------
    given : argparse.Namespace
        Parsed options.
    project : Project
        What is known already.
    film : Path
    inputs : sequence of Path
        All that is read.

    Raises
    ------
    InputError
        The page is not named .html, another output is asked for besides, the film cannot be read.
    """
    page: Path = given.choose
    others = {"-o": given.output, "--marks": given.marks, "--json": given.json, "--pictures": given.pictures}
    others |= {"--overlay": given.overlay, "--report": given.report}
    asked = [option for option, path in others.items() if path is not None]
    if asked:
        raise InputError(f"--choose only writes its page and tracks nothing; leave {', '.join(asked)} away, or leave --choose away.")
    require_page("--choose", page)
    from measure.common.output import write_text
    from measure.common.output_gate import Outputs
    from measure.film.part import part_of
    from measure.film_pages.choose_page import choose_page
    from measure.footage.formats import open_footage

    with Outputs({"--choose": page}, inputs=inputs).held():
        footage = part_of(open_footage(film), project)
        write_text(page, choose_page(footage, project, film, page))
    stem = film.stem or film.name
    return [
        f"written   {page}",
        "Open it in a browser, set marks and scale, download the project file and put it beside the film. Then:",
        command.next_command("track-video", film, "--project", f"{stem}.toml", "-o", f"{stem}.csv"),
    ]


def require_page(option: str, page: Path | None) -> None:
    """Refuse a page that a browser would not take for one.

    Raises
    ------
    InputError
        Its name does not end in .html.
    """
    if page is not None and page.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{option} {page}: the page is written as .html; name it so.")
