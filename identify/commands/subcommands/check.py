"""`unspool check`: everything that is wrong in files of any kind, at once, and what was understood of those that can be used."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.common.command_line import DONE, examples, parser, run, say

if TYPE_CHECKING:
    from simulate.model.model import Model

NAME = "unspool check"
DOES = "Read model, campaign, film project, bench columns, loops and trajectories; report all that is wrong, and what was understood."


def main(arguments: Sequence[str] | None = None) -> int:
    """The task."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    from measure.readers.options import add_reading_options
    from simulate.files.options import add_effects_option

    made = parser(NAME, DOES, output="write the text to this file")
    made.add_argument("files", nargs="+", type=Path, metavar="FILE", help="files of any kind, each recognised by what stands in it")
    add_effects_option(made)
    add_reading_options(made)
    return examples(made, "unspool check model.toml campaign.toml", "unspool check loops/*.txt --mapping bench.toml")


def _work(arguments: Sequence[str]) -> int:
    from measure.common.errors import InputError
    from measure.common.file_kinds import TEXT
    from measure.common.output_gate import Outputs

    given = _parser().parse_args(arguments)
    with Outputs({"--output": given.output, "--json": given.json}, {}, _files_read(given), {"--output": TEXT}).held():
        model = _the_model(given)
        found = [_looked_at(path, given, model) for path in given.files]
        wrong = [row for row in found if row["wrong"]]
        if not wrong:
            _write(given, found)
    if not given.quiet:
        say(*(line for row in found for line in _said(row)))
        say(f"{len(found) - len(wrong)} of {len(found)} files can be used" + ("" if wrong else f"\nnext     {_next(found)}"))
    if wrong:
        raise InputError(_refusal(given, wrong))
    return DONE


def _refusal(given: Namespace, wrong: Sequence[dict[str, Any]]) -> str:
    """What is said on standard error, with all that is wrong where it was not said yet; nothing is written then."""
    shown = [line for row in wrong for line in row["wrong"]] if given.quiet else []
    files = "1 file" if len(wrong) == 1 else f"{len(wrong)} files"
    return "\n".join([f"{files} cannot be used; nothing was written. Mend what is reported.", *shown])


def _files_read(given: Namespace) -> list[Path]:
    """All that is read, the files that a list of runs names included; what cannot be read as one names none."""
    from identify.campaign.runs import files_of
    from measure.common.errors import InputError

    found = [*given.files, *given.effects, *([given.mapping] if given.mapping else [])]
    for path in given.files:
        with suppress(InputError):
            found += files_of([path])
    return found


def _the_model(given: Namespace) -> Model | None:
    """The model with which the other files are compared: the only one among them that is one and can be used."""
    from measure.common.errors import InputError
    from measure.common.file_kinds import FITTED, MODEL, kind_of
    from simulate.files.model_file import read_model
    from simulate.files.own_effects import catalogue_with

    models = [path for path in given.files if path.is_file() and kind_of(path) in (FITTED, MODEL)]
    try:
        return read_model(models[0], catalogue_with(given.effects)) if len(models) == 1 else None
    except InputError:
        return None


def _looked_at(path: Path, given: Namespace, model: Model | None) -> dict[str, Any]:
    """One file: its kind, what was understood, or what is wrong."""
    from identify.commands.subcommands.understood import understood
    from measure.common.errors import InputError
    from measure.readers.options import mapping_from
    from simulate.files.own_effects import catalogue_with

    try:
        kind, lines = understood(path, mapping_from(given), catalogue_with(given.effects), model)
    except InputError as error:
        return {"file": str(path), "kind": "", "understood": [], "wrong": str(error).splitlines()}
    return {"file": str(path), "kind": kind, "understood": lines, "wrong": []}


def _said(row: dict[str, Any]) -> list[str]:
    if row["wrong"]:
        lines = [line.removeprefix(f"{row['file']}: ") for line in row["wrong"]]
        return [f"wrong    {row['file']}", *(f"           {line}" for line in lines)]
    return [f"ok       {row['file']}: {row['kind']}", *(f"           {line}" for line in row["understood"])]


def _next(found: Sequence[dict[str, Any]]) -> str:
    """What one would type next with files of these kinds."""
    of_kind = {row["kind"].split(",")[0]: row["file"] for row in reversed(found)}
    if "list of runs" in of_kind:
        return f"unspool run {of_kind['list of runs']}"
    model = of_kind.get("model", "MODEL")
    if "loop" in of_kind:
        return f"fit-actuator {of_kind['loop']} ... --model {model} -o fitted.toml"
    if "trajectory" in of_kind:
        return f"explain-gap {model} {of_kind['trajectory']}"
    if "film" in of_kind:
        return f"track-video {of_kind['film']} --project film.toml -o film.csv"
    if "film project" in of_kind:
        return f"track-video FILM --project {of_kind['film project']} -o film.csv"
    return f"simulate-deployment {model}" if "model" in of_kind else "fit-actuator LOOPS --mapping " + of_kind["columns of a bench"]


def _write(given: Namespace, found: Sequence[dict[str, Any]]) -> None:
    from measure.common.output import write_json, write_text

    if given.output is not None:
        write_text(given.output, "\n".join(line for row in found for line in _said(row)) + "\n")
    if given.json is not None:
        write_json(given.json, {"usable": not any(row["wrong"] for row in found), "files": found})
