"""`explain-gap`: which physical effect is missing between a model and its measurements."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from identify.commands.files_read import files_read
from identify.commands.parameter_options import add_parameter_options, changes_from
from measure.common.command_line import DONE, VERDICT_BAD, complain, examples, foretell, next_command, parser, run, say
from measure.common.output_gate import Outputs
from measure.readers.options import add_reading_options, mapping_from
from simulate.files.options import add_effects_option

if TYPE_CHECKING:
    from identify.estimation.problem import Problem
    from identify.selection.explanation import Explanation

NAME = "explain-gap"
_FITS = 10.0  # that a fitted hypothesis costs in all: the weighing of others beside it, and its own
_MANY = 4  # numbers; so many are counted, fewer are listed
WRITTEN = ("report.html", "result.json", "extended.toml", "missing_force.csv", "drafted_effect.py")
DOES = "Locate the gap between model and measurements, name the missing effect, add it and show the gap shrink."


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(NAME, DOES, output="folder for the report and the extended model", output_default="explanation")
    made.add_argument("model", type=Path, metavar="MODEL", help="model file (TOML)")
    made.add_argument("measured", nargs="+", type=Path, metavar="MEASURED", help="loops, trajectories, or lists of runs (TOML)")
    add_effects_option(made)
    add_reading_options(made)
    add_parameter_options(made)
    made.add_argument(
        "--covariate", default="", metavar="COLUMN", help="further column of the loops that part of the force is proportional to"
    )
    made.add_argument(
        "--tare",
        choices=("auto", "common", "each"),
        default="auto",
        help="whether the load cell was set to zero for each loop anew; auto finds out where a gap is left otherwise; default: %(default)s",
    )
    made.add_argument(
        "--budget", choices=("quick", "normal", "thorough"), default="normal", help="how many effects are fitted; default: %(default)s"
    )
    return examples(
        made,
        "explain-gap rig.toml film.csv loops/*.csv -o explanation",
        "explain-gap rig.toml campaign.toml --budget thorough --json gap.json",
    )


def _work(arguments: Sequence[str]) -> int:
    given = _parser().parse_args(arguments)
    with _gate(given).held():
        status, lines, own = _explained(given)
    if not given.quiet:
        again = next_command("compare-model", given.output / "extended.toml", *given.measured, *own)
        say(*lines, f"report   {given.output / 'report.html'}", again)
    return status


def _gate(given: Namespace) -> Outputs:
    """All that the command writes and reads."""
    return Outputs({"--json": given.json}, {"--output": (given.output, WRITTEN)}, files_read(given))


def _explained(given: Namespace) -> tuple[int, list[str], list[str | Path]]:
    """Explain, and write all that was asked for; status, the lines for people, and the options that the extended model wants."""
    from identify.campaign.posing import problem_of
    from identify.campaign.runs import read_campaign, remarks
    from identify.draft.effect_file import FILE
    from identify.selection.explain import explain
    from identify.selection.hypotheses import BUDGETS
    from simulate.deployment.deploy import warnings_of_rates
    from simulate.files.model_file import read_model
    from simulate.files.own_effects import catalogue_with

    catalogue = catalogue_with(given.effects)
    model = read_model(given.model, catalogue)
    runs = read_campaign(given.measured, mapping_from(given))
    budget = BUDGETS[given.budget]
    own_zeros = given.tare != "common"
    changes = changes_from(given, lambda: problem_of(model, runs, given.covariate, own_zeros=own_zeros), catalogue.values())
    _foretell(given, problem_of(model, [run for run in runs if not run.hold_out], given.covariate, own_zeros=own_zeros, changes=changes))
    found = explain(model, runs, catalogue, covariate=given.covariate, tare=given.tare, changes=changes, budget=budget, say=_say(given))
    with _gate(given).together():
        _write(given, found, [given.model, *(r.path for r in runs if r.path), *given.effects])
    said = [*(f"record   {text}" for text in remarks(runs)), *(f"model    {text}" for text in warnings_of_rates(model))]
    lines = [*said, *summary(found)]
    drafted = found.drafted is not None and found.drafted.carries_over
    files = [*given.effects, *([given.output / FILE] if drafted else [])]
    return (VERDICT_BAD if found.verdict == "unknown" else DONE), lines, [word for file in files for word in ("--effects", file)]


def _foretell(given: Namespace, problem: Problem) -> None:
    """Say about how long it takes: the fits that the budget allows, and every effect of the catalogue weighed beside some of them."""
    from identify.commands.foresight import seconds_of
    from identify.selection.hypotheses import BUDGETS

    budget = BUDGETS[given.budget]
    foretell(NAME, given.quiet, "Give fewer or shorter runs, or --budget quick.")(seconds_of(problem, _FITS * budget.fits))


def _say(given: Namespace) -> Any:
    def under_way(text: str) -> None:
        if not given.quiet:
            complain(f"{NAME}: {text} ...")

    return under_way


def summary(found: Explanation) -> list[str]:
    """What is printed for people."""
    from identify.report.result import parameters_of, result_of

    result = result_of(found)
    lines = [f"record   {result['noise_sentence']}"] if result["noise_sentence"] else []
    lines.append(f"verdict  {found.verdict}: {result['sentence']}")
    if left := result["law_not_written"]:
        lines.append(f"law      stays as the model file has it: {'; '.join(left)}")
    gap = result["gap"]
    lines.append(f"gap      {gap['before']['rms_over_noise']:.3g} -> {gap['after']['rms_over_noise']:.3g} times the noise")
    if "held_out" in gap:
        held = gap["held_out"]
        lines.append(f"held out {held['before']['rms_over_noise']:.3g} -> {held['after']['rms_over_noise']:.3g} times the noise")
    for finding in found.findings:
        lines += [f"         {finding.name} {text}" for text in _numbers(parameters_of(finding))]
    if zeros := result["loop_zeros_N"].values():
        lines.append(f"loops    each was given a zero of its own; they differ by up to {max(zeros) - min(zeros):.3g} N")
    lines += [f"         {text}" for text in (result["missing_force"], result["next_experiment"]) if text]
    return lines


def _numbers(rows: dict[str, Any]) -> list[str]:
    """Numbers of a finding with their intervals, one a line; those of which nothing shows (runs that are not there) on the last one."""
    hidden = [name for name, row in rows.items() if not row["identifiable"]]
    shown = [(name, row["value"], row["ci95"]) for name, row in rows.items() if row["identifiable"]]
    lines = [f"{name} = {value:.5g}   95 % {low:.5g} ... {high:.5g}" for name, value, (low, high) in shown]
    which = ", ".join(hidden) if len(hidden) < _MANY else f"{hidden[0]} ... {hidden[-1]} ({len(hidden)} of {len(rows)})"
    return lines + ([f"{which}: not identifiable from these runs"] if hidden else [])


def _write(given: Namespace, found: Explanation, inputs: list[Path]) -> None:
    """All results at once, after everything has been computed."""
    from identify.draft.effect_file import FILE
    from identify.report.explained.extended_model import extended
    from identify.report.explained.page import report_html
    from identify.report.result import missing_table, result_of
    from measure.common.output import json_text, provenance, write_json, write_text
    from measure.tables.csv_cells import write_columns
    from simulate.files.model_file import write_model

    note = provenance(inputs)
    missing = missing_table(found)
    table = given.output / "missing_force.csv" if missing is not None else None
    result = {**result_of(found, str(table) if table else None), "provenance": note}
    title = f"The gap between {found.before.problem.model.name} and its measurements"
    page = report_html(found, title, {}, str(table) if table else None, note=note)
    if table is not None and missing is not None:
        write_columns(missing, table)
    if found.drafted is not None:
        write_text(given.output / FILE, found.drafted.source)
    write_model(extended(found.before.problem.model, found), given.output / "extended.toml", note)
    write_json(given.output / "result.json", result)
    write_text(given.output / "report.html", page)
    if given.json is not None:
        write_text(given.json, json_text(result))
