"""`compare-model`: a model against what was measured, in numbers and a figure."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from identify.commands.files_read import files_read
from identify.commands.parameter_options import add_parameter_options, changes_from
from measure.common.command_line import DONE, examples, next_command, parser, run, say
from measure.common.errors import InputError
from measure.common.output_gate import Outputs
from measure.readers.options import add_reading_options, mapping_from
from simulate.files.options import add_effects_option

if TYPE_CHECKING:
    from identify.gap.comparison import Comparison

NAME = "compare-model"
DOES = "Compare a model with loops and deployments: error, fit and noise of each channel, and whether the gap is noise."


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(NAME, DOES, output="figure (png, pdf or svg)")
    made.add_argument("model", type=Path, metavar="MODEL", help="model file (TOML)")
    made.add_argument("measured", nargs="+", type=Path, metavar="MEASURED", help="loops, trajectories, or lists of runs (TOML)")
    made.add_argument("--page", type=Path, metavar="FILE", help="page with the numbers and every run (HTML)")
    made.add_argument("--as-given", action="store_true", help="take the release from the model file instead of fitting each run's own")
    add_effects_option(made)
    add_reading_options(made)
    add_parameter_options(made)
    return examples(
        made, "compare-model rig.toml film.csv -o comparison.png", "compare-model rig.toml campaign.toml --page comparison.html"
    )


def _work(arguments: Sequence[str]) -> int:
    given = _parser().parse_args(arguments)
    if given.output is not None and given.output.suffix not in (".png", ".pdf", ".svg"):
        raise InputError(f"{given.output}: a figure ends in .png, .pdf or .svg.")
    with _gate(given).held():
        lines = _compared(given)
    if not given.quiet:
        say(*lines)
    return DONE


def _gate(given: Namespace) -> Outputs:
    """All that the command writes and reads."""
    return Outputs({"--output": given.output, "--json": given.json, "--page": given.page}, {}, files_read(given))


def _compared(given: Namespace) -> list[str]:
    """Compare, and write all that was asked for; the lines for people."""
    from identify.campaign.posing import problem_of
    from identify.campaign.runs import read_campaign, remarks
    from identify.gap.compare import compare
    from simulate.deployment.deploy import warnings_of_rates
    from simulate.files.model_file import read_model
    from simulate.files.own_effects import catalogue_with

    model = read_model(given.model, catalogue_with(given.effects))
    runs = read_campaign(given.measured, mapping_from(given))
    found = compare(model, runs, fit_release=not given.as_given, changes=changes_from(given, lambda: problem_of(model, runs)))
    with _gate(given).together():
        _write(given, found, [given.model, *(r.path for r in runs if r.path), *given.effects])
    further = [] if found.gap_is_noise else [next_command("explain-gap", given.model, *given.measured)]
    said = [*(f"record   {text}" for text in remarks(runs)), *(f"model    {text}" for text in warnings_of_rates(model))]
    return [*said, *summary(found), *further]


def result_of(found: Comparison) -> dict[str, Any]:
    """The result of `compare-model --json`."""
    from identify.gap.dragged import dragged

    names = list(dict.fromkeys(curve.run for curve in found.curves))
    return {
        "runs": [{"file": name, "channels": {c.channel: c.numbers for c in found.curves if c.run == name}} for name in names],
        "dispersion_percent": found.dispersion_percent,
        "gap_is_noise": found.gap_is_noise,
        "rms_over_noise": found.fit.rms,
        "p_value": found.test.p_value,
        "dragged": [{**asdict(one), "sentence": one.sentence} for one in dragged(found.fit)],
    }


def summary(found: Comparison) -> list[str]:
    """What is printed for people."""
    from identify.gap.dragged import dragged, in_words
    from identify.gap.gap_test import p_words

    moved = [f"moved    {words}" for words in in_words(dragged(found.fit))]
    lines = [*moved, f"{'run':<24}{'channel':<14}{'rmse':>11}{'largest':>11}{'nrmse %':>10}{'fit %':>9}{'noise':>11}"]
    for curve in found.curves:
        n = curve.numbers
        lines.append(
            f"{curve.run[-23:]:<24}{curve.channel:<14}{n['rmse']:>11.3g}{n['max_abs']:>11.3g}"
            f"{n['nrmse_percent']:>10.3g}{n['fit_percent']:>9.4g}{n['noise_sigma']:>11.3g}"
        )
    word = "noise" if found.gap_is_noise else "more than noise"
    return [*lines, f"the gap is {found.fit.rms:.3g} times the noise: {word} ({p_words(found.test.p_value)})"]


def _write(given: Namespace, found: Comparison, inputs: list[Path]) -> None:
    from measure.common.figure_plots import save_figure
    from measure.common.output import provenance, replacing, write_json

    note = provenance(inputs)
    if given.output is not None:
        from identify.report.gap_plots import comparison_figure

        with replacing(given.output) as temporary:
            save_figure(comparison_figure(found.curves), temporary, given.output.suffix[1:])
    if given.json is not None:
        write_json(given.json, {**result_of(found), "provenance": note})
    if given.page is not None:
        from identify.report.compare_page import compare_html
        from measure.common.output import write_text

        further = (
            []
            if found.gap_is_noise
            else [f"Find out what is missing: {next_command('explain-gap', given.model, *given.measured).removeprefix('next').strip()}"]
        )
        write_text(given.page, compare_html(found, further, note))
