"""`unspool demo`: the main job on shipped data, step by step; film and loops in, a named effect out. What `make demo` runs.

It calls the same functions as the commands and prints what came out of each.
"""

from __future__ import annotations

import shutil
import time
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from identify.commands.subcommands.shipped import shipped
from measure.common.command_line import DONE, VERDICT_BAD, complain, examples, parser, progress, run, say

if TYPE_CHECKING:
    from identify.gap.comparison import Comparison
    from identify.selection.explanation import Explanation
    from simulate.model.model import Model

NAME = "unspool demo"
DOES = "Measure a film, identify loops, simulate, compare and explain, on the data that are installed with the program."


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(NAME, DOES, output="folder for all results", output_default="out/demo")
    what = "another folder with rig.toml, film, loops, campaign.toml"
    made.add_argument("--data", type=Path, metavar="FOLDER", default=shipped("demo"), help=what)
    raw = "compute nothing, write the raw measurements there: the film, and the loops as a bench wrote them"
    made.add_argument("--raw", type=Path, metavar="FOLDER", help=raw)
    return examples(made, "unspool demo", "unspool demo --raw rig")


def _work(arguments: Sequence[str]) -> int:
    given = _parser().parse_args(arguments)
    from measure.common.errors import InputError
    from measure.common.output_gate import Outputs

    if not (given.data / "campaign.toml").is_file():
        raise InputError(f"{given.data}: no campaign.toml; name the folder with the demonstration's data by --data.")
    if given.raw is not None:
        return _raw(given)
    given.output.mkdir(parents=True, exist_ok=True)
    work = given.output / "data"
    Outputs({"--json": given.json}, {"--output": (work, ())}, [given.data]).require_usable()
    shutil.copytree(given.data, work, dirs_exist_ok=True)
    steps = _Steps(given, time.perf_counter())
    _measure(steps, work)
    model = _identify(steps, work)
    _simulate(steps, model)
    compared = _compare(steps, model, work)
    found = _explain(steps, model, work)
    report = _report(given, found, compared, work)
    steps.say("report", str(report), "")
    return DONE if found.verdict != "unknown" else VERDICT_BAD


def _raw(given: Namespace) -> int:
    """Write the raw files, and say how to go on."""
    from identify.commands.subcommands.raw_files import write_raw

    made = write_raw(given.data, given.raw)
    if not given.quiet:
        say(*(f"written   {path}" for path in made))
        say(f"next      unspool init {given.raw} --like demo, then: unspool check {given.raw}/campaign.toml")
    return DONE


class _Steps:
    """One line for each step on standard output, and what is under way on standard error."""

    def __init__(self, given: Namespace, start: float) -> None:
        self.quiet = given.quiet
        self.start = start

    def under_way(self, text: str) -> None:
        if not self.quiet:
            complain(f"  {time.perf_counter() - self.start:5.1f} s  {text} ...")

    def say(self, step: str, what: str, figures: str) -> None:
        if not self.quiet:
            say(f"{step:<9}{what:<38}  {figures}".rstrip())


def _measure(steps: _Steps, work: Path) -> None:
    steps.under_way("following the marks")
    from measure import open_footage, read_project, track
    from measure.common.output import provenance, write_provenance
    from measure.tables.trajectory import write_trajectory

    footage = open_footage(work / "film.avi")

    def watch(frames: Any) -> Any:
        return progress(frames, what="frames", total=footage.frames, quiet=steps.quiet)

    tracked = track(footage, read_project(work / "film.toml"), watch)
    assert tracked.trajectory is not None
    write_trajectory(tracked.trajectory, work / "film.csv")
    write_provenance(work / "film.csv", provenance([work / "film.avi", work / "film.toml"], command=[NAME]))
    result = tracked.summary
    millimetres = 1e3 * result["platform"]["median_sigma"]["z_m"]
    figures = f"sigma {result['sigma_px']:.4f} px a mark   {millimetres:.4f} mm the platform   {result['verdict']}"
    steps.say("measure", f"film of {result['film']['frames_read']} frames, {len(result['marks'])} marks", figures)


def _identify(steps: _Steps, work: Path) -> Model:
    steps.under_way("fitting the force law to the loops")
    from identify.actuator.fit_actuator import fit_actuator
    from identify.loops.prepare import prepare
    from identify.report.loop_result import model_of
    from measure.common.output import provenance
    from measure.tables.loop import read_loop
    from simulate.files.model_file import read_model, write_model

    files = sorted((work / "loops").glob("*.csv"))
    loops = [prepare(read_loop(path)) for path in files]
    fit = fit_actuator(loops)
    model = model_of(fit, read_model(work / "rig.toml"))
    write_model(model, work / "model.toml", provenance([work / "rig.toml", *files], command=[NAME]))
    beta, force = fit.estimates["beta_per_m"], fit.estimates["b_l_N"]
    frequencies = len({round(loop.frequency_Hz, 2) for loop in loops})
    figures = f"beta {_pm(beta.value, beta.stderr)} 1/m, b_l {_pm(force.value, force.stderr)} N   {fit.verdict.word}"
    steps.say("identify", f"{len(loops)} loops, {frequencies} frequencies", figures)
    return model


def _pm(value: float, stderr: float | None) -> str:
    return f"{value:.4g}" if stderr is None else f"{value:.4g} +- {stderr:.2g}"


def _simulate(steps: _Steps, model: Model) -> None:
    steps.under_way("simulating (the kernel is compiled the first time)")
    from simulate.deployment.deploy import deploy

    done = deploy(model)
    verdict = "ok" if done.diverged_at_s is None else f"diverged at {done.diverged_at_s:g} s"
    figures = f"energy closes to {done.energy_closure:.1g}, highest at {1e3 * done.channels['z_m'].max():.1f} mm   {verdict}"
    steps.say("simulate", f"six legs, {model.simulation.duration_s:.2f} s", figures)


def _compare(steps: _Steps, model: Model, work: Path) -> Comparison:
    steps.under_way("comparing")
    from identify.campaign.runs import read_campaign
    from identify.gap.compare import compare

    found = compare(model, [run for run in read_campaign([work / "campaign.toml"]) if not run.is_loop])
    film = {curve.channel: curve.numbers for curve in found.curves if curve.run == "film.csv"}
    figures = f"elevation fit {film['z_m']['fit_percent']:.1f} %, lateral {film['x_m']['fit_percent']:.1f} %"
    word = "is noise" if found.gap_is_noise else f"is {found.fit.rms:.3g} times the noise"
    steps.say("compare", f"{len({c.run for c in found.curves})} deployments", f"{figures}   the gap {word}")
    return found


def _explain(steps: _Steps, model: Model, work: Path) -> Explanation:
    from identify.campaign.runs import read_campaign
    from identify.report.result import parameters_of, result_of
    from identify.selection.explain import explain

    found = explain(model, read_campaign([work / "campaign.toml"]), say=steps.under_way)
    result = result_of(found)
    gap = result["gap"]
    held = gap.get("held_out")
    figures = f"gap {gap['before']['rms_over_noise']:.3g} -> {gap['after']['rms_over_noise']:.3g} times the noise"
    figures += f", held-out run {held['before']['rms_over_noise']:.3g} -> {held['after']['rms_over_noise']:.3g}" if held else ""
    steps.say("explain", result["sentence"], figures)
    for finding in found.findings:
        for name, row in parameters_of(finding).items():
            steps.say("", f"{finding.name} {name}", f"{row['value']:.5g}, 95 % {row['ci95'][0]:.5g} to {row['ci95'][1]:.5g}")
    return found


def _report(given: Namespace, found: Explanation, compared: Comparison, work: Path) -> Path:
    from identify.commands.compare_model import summary
    from identify.report.explained.extended_model import extended
    from identify.report.explained.page import report_html
    from identify.report.result import result_of
    from measure.common.output import provenance, write_json, write_text
    from simulate.files.model_file import write_model

    note = provenance(sorted(path for path in work.rglob("*") if path.suffix in (".csv", ".toml", ".avi")), command=[NAME])
    model = found.before.problem.model
    write_model(extended(model, found), given.output / "extended.toml", note)
    write_json(given.output / "result.json", {**result_of(found), "provenance": note})
    notes = {"Model against deployments, before": "\n".join(summary(compared))}
    if given.json is not None:
        write_json(given.json, {**result_of(found), "provenance": note})
    report = given.output / "report.html"
    write_text(report, report_html(found, "The demonstration: a film and six loops, explained", notes, note=note))
    return report
