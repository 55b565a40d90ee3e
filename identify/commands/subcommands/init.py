"""`unspool init`: a folder with commented templates of every file that a user writes, and their JSON Schemas for editors."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.common.command_line import DONE, examples, parser, run, say

if TYPE_CHECKING:
    from measure.common.output_gate import Outputs

NAME = "unspool init"
DOES = "Write commented templates of the model, the film, the columns of the bench and the list of runs, with a schema of each for editors."


def main(arguments: Sequence[str] | None = None) -> int:
    """The task."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(NAME, DOES, output="the same as FOLDER")
    made.add_argument("folder", nargs="?", type=Path, metavar="FOLDER", help="where the files are put; it is made where it is absent")
    like = "whose values stand in the files: those of the paper's rig, or of the demonstration's; default: %(default)s"
    made.add_argument("--like", choices=("prototype", "demo"), default="prototype", help=like)
    return examples(made, "unspool init rig", "unspool init rig --like demo")


def _work(arguments: Sequence[str]) -> int:
    given = _parser().parse_args(arguments)
    from measure.common.errors import InputError

    folder = given.folder or given.output
    if folder is None:
        raise InputError("no folder; name the one that the files are to be put into, such as: unspool init rig")
    texts = _texts(given.like)
    _require_absent(folder, texts)
    gate = _gate(given, folder, texts)
    with gate.held(), gate.together():
        _write(given, folder, texts)
    if not given.quiet:
        say(*_said(folder, texts))
    return DONE


def _texts(like: str) -> dict[str, str]:
    """The files by name: templates, then schemas."""
    from identify.campaign import campaign_file
    from identify.commands.subcommands.template_values import values_like
    from measure.common.output import json_text
    from measure.geometry import film_project
    from measure.readers import column_mapping
    from measure.tables.toml_template import commented
    from simulate.files import schema

    formats = {
        "model": (schema, "simulate/files/axes.txt"),
        "film": (film_project, "measure/geometry/picture_axes.txt"),
        "bench": (column_mapping, "measure/readers/mapping_head.txt"),
        "campaign": (campaign_file, "identify/campaign/campaign_head.txt"),
    }
    values = values_like(like)
    templates, schemas = {}, {}
    for name, (module, head) in formats.items():
        described = module.json_schema()
        schemas[f"schemas/{name}.schema.json"] = json_text(described)
        text = (Path(__file__).resolve().parents[3] / head).read_text(encoding="utf-8")
        templates[f"{name}.toml"] = commented(described, values[name], head=text, schema_file=f"schemas/{name}.schema.json")
    return {**templates, **schemas}


def _require_absent(folder: Path, texts: dict[str, str]) -> None:
    from measure.common.errors import InputError

    there = [str(folder / name) for name in texts if (folder / name).exists()]
    if there:
        raise InputError(f"{', '.join(there)}: there already, and nothing is written over. Name another folder, or move them away.")


def _gate(given: Namespace, folder: Path, texts: Iterable[str]) -> Outputs:
    """All that is written."""
    from measure.common.output_gate import Outputs

    own = [Path(name) for name in texts]
    inside = {parent: [name.name for name in own if name.parent == parent] for parent in (Path(), Path("schemas"))}
    folders = {"FOLDER": (folder, inside[Path()]), "FOLDER/schemas": (folder / "schemas", inside[Path("schemas")])}
    return Outputs({"--json": given.json}, folders)


def _write(given: Namespace, folder: Path, texts: dict[str, str]) -> None:
    from measure.common.output import write_json, write_text

    for name, text in texts.items():
        write_text(folder / name, text)
    if given.json is not None:
        write_json(given.json, {"folder": folder, "like": given.like, "files": list(texts)})


def _said(folder: Path, texts: dict[str, str]) -> list[str]:
    about = {
        "model.toml": "platform, geometry, force law, stops, gravity, release, effects",
        "film.toml": "rate, scale and marks of a film; for track-video and unspool run",
        "bench.toml": "what the columns of the loop files are; for fit-actuator and unspool run",
        "campaign.toml": "the list of films, loops and trajectories; for unspool run",
    }
    lines = [f"written   {folder / name}   {does}" for name, does in about.items()]
    lines.append(
        f"written   {folder / 'schemas'}   {len(texts) - len(about)} JSON Schemas: an editor that knows TOML completes keys with them"
    )
    return [*lines, f"next      change the values, then: unspool check {folder}/*.toml"]
