"""`unspool run`: a whole campaign from raw files. It types the other commands for you, and shows what it types."""

from __future__ import annotations

import shlex
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.common.command_line import UNUSABLE, VERDICT_BAD, examples, parser, run, say

if TYPE_CHECKING:
    from identify.campaign.campaign_file import Campaign, ListedRun

NAME = "unspool run"
_FITTED, _COMPARED = "model.toml", "comparison.png"
DOES = "Measure the films of a list of runs, fit the force law to its loops, compare with the model, and name the effect it lacks."


def main(arguments: Sequence[str] | None = None) -> int:
    """The task."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(NAME, DOES, output="folder for all results", output_default="results")
    made.add_argument("campaign", type=Path, metavar="CAMPAIGN", help="list of runs (TOML): films, loops and trajectories")
    made.add_argument("--model", type=Path, metavar="MODEL", help="model file, instead of the one that the list names")
    made.add_argument("--effects", action="append", default=[], type=Path, metavar="FILE", help="Python file with effects of your own")
    made.add_argument("--budget", choices=("quick", "normal", "thorough"), default="normal", help="how many effects are fitted")
    return examples(made, "unspool run campaign.toml", "unspool run campaign.toml --model rig/model.toml -o results --budget quick")


def _work(arguments: Sequence[str]) -> int:
    given = _parser().parse_args(arguments)
    from identify.campaign.campaign_file import read_list

    listed = read_list(given.campaign)
    model = _model(given, listed)
    _require_usable(given, model)
    status = UNUSABLE
    before = _as_it_is(given.output)
    given.output.mkdir(exist_ok=True)
    try:
        status = _typed_in_turn(given, listed, model)
    finally:
        if status not in (0, VERDICT_BAD):
            _put_back(given.output, before)
    return status


def _as_it_is(output: Path) -> dict[Path, bytes] | None:
    """What stands in the folder under the names of the results that appear before the last; None where there is no folder."""
    there = [path for path in (output / _FITTED, output / _COMPARED) if path.is_file()]
    return {path: path.read_bytes() for path in there} if output.exists() else None


def _put_back(output: Path, before: Mapping[Path, bytes] | None) -> None:
    """Leave a folder as it was: a refusal half way leaves no law that was fitted and no picture of it."""
    from measure.common.output import replacing

    for path in (output / _FITTED, output / _COMPARED):
        if path not in (before or {}):
            path.unlink(missing_ok=True)
        elif path.read_bytes() != (before or {})[path]:
            with replacing(path) as old:
                old.write_bytes((before or {})[path])
    if before is None:
        with suppress(OSError):  # somebody else has put something there
            output.rmdir()


def _typed_in_turn(given: Namespace, listed: Campaign, model: Path) -> int:
    """The other commands in their order, as far as they go; the status of the last."""
    folder = given.campaign.parent
    status = _films_measured(given, listed, folder, model)
    if status:
        return status
    fitting, model = _law_fitted(given, listed, folder, model)
    if fitting:
        return fitting
    from identify.commands import compare_model, explain_gap

    own = [word for path in given.effects for word in ("--effects", str(path))]
    both = [str(model), str(given.campaign), *own]
    status = _typed(given, compare_model.main, [compare_model.NAME, *both, "-o", str(given.output / _COMPARED)])
    if status not in (0, VERDICT_BAD):
        return status
    wanted = [*both, "-o", str(given.output), "--budget", given.budget, *(["--json", str(given.json)] if given.json else [])]
    return _typed(given, explain_gap.main, [explain_gap.NAME, *wanted])


def _model(given: Namespace, listed: Campaign) -> Path:
    """The model file that the work begins with."""
    from measure.common.errors import InputError
    from simulate.files.model_file import read_model
    from simulate.files.own_effects import catalogue_with

    if given.model is None and listed.model is None:
        raise InputError(f'{given.campaign}: names no model. Add --model MODEL, or at the top of the list\nmodel = "model.toml"')
    path = given.model or given.campaign.parent / str(listed.model)
    read_model(path, catalogue_with(given.effects))
    return path


def _require_usable(given: Namespace, model: Path) -> None:
    """Everything that is wrong with the files of the list, or with what the commands will write, before the long work begins."""
    from identify.campaign.runs import files_of
    from identify.commands.explain_gap import WRITTEN
    from identify.commands.subcommands.understood import understood
    from measure.common.output_gate import Outputs
    from measure.readers.column_mapping import ColumnMapping
    from simulate.files.model_file import read_model
    from simulate.files.own_effects import catalogue_with

    catalogue = catalogue_with(given.effects)
    understood(given.campaign, ColumnMapping(), catalogue, read_model(model, catalogue))
    folders = {"--output": (given.output, (_FITTED, _COMPARED, *WRITTEN))}
    Outputs({"--json": given.json}, folders, [model, *given.effects, *files_of([given.campaign])]).require_usable()


def _films_measured(given: Namespace, listed: Campaign, folder: Path, model: Path) -> int:
    """Measure the films that are not measured yet, or have changed; 0, or the status of the first that cannot be used."""
    from identify.campaign.kept_films import is_current, sources_of, table_of
    from measure.commands import track_video

    for row in (row for row in listed.run if row.is_film(folder)):
        table, sources = table_of(row, folder), sources_of(row, folder)
        if is_current(table, [*sources, model]):
            _say(given, f"kept     {table}: {row.file} and its project have not changed since it was measured")
            continue
        table.parent.mkdir(exist_ok=True)
        project = ["--project", str(sources[1])] if row.project else []
        words = ["track-video", str(sources[0]), *project, "--model", str(model), "-o", str(table)]
        if _typed(given, track_video.main, words) not in (0, VERDICT_BAD):
            return UNUSABLE
    return 0


def _law_fitted(given: Namespace, listed: Campaign, folder: Path, model: Path) -> tuple[int, Path]:
    """The model with the force law of the loops, where all of them are of one actuator as the model has it; else the model itself.

    With it 0, or the status of a fit that cannot be used: an answer with the law as it was before would look like one with the new law.
    """
    from identify.commands import fit_actuator

    loops = [row for row in listed.run if not row.is_film(folder) and not row.hold_out and _is_loop(row, folder)]
    mappings = {row.mapping for row in loops}
    if not loops or len(mappings) > 1 or any(row.model for row in loops):
        return 0, model
    fitted = given.output / _FITTED
    how = [word for name in mappings if name is not None for word in ("--mapping", str(folder / name))]
    files = [str(folder / row.file) for row in loops]
    status = _typed(given, fit_actuator.main, [fit_actuator.NAME, *files, *how, "--model", str(model), "-o", str(fitted)])
    return (0, fitted) if status in (0, VERDICT_BAD) else (status, model)


def _is_loop(row: ListedRun, folder: Path) -> bool:
    from measure.readers.measurement import read_measurement
    from measure.tables.loop import Loop

    return isinstance(read_measurement(folder / row.file, row.reading(folder)), Loop)


def _typed(given: Namespace, command: Callable[[Sequence[str]], int], words: Sequence[str]) -> int:
    """Run a command as if these words had been typed, and show them."""
    _say(given, f"\n$ {shlex.join(words)}")
    return command([*words[1:], *(["--quiet"] if given.quiet else [])])


def _say(given: Namespace, text: str) -> None:
    if not given.quiet:
        say(text)
