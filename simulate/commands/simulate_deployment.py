"""simulate-deployment: a model file in, one deployment out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.common.command_line import DONE, VERDICT_BAD, examples, next_command, parser, run, say
from measure.common.errors import InputError
from measure.common.file_kinds import TABLE
from measure.common.output import provenance_beside
from measure.common.output_gate import Outputs
from simulate.files.options import add_model_options, model_from_options

if TYPE_CHECKING:
    from measure.tables.trajectory import Trajectory
    from simulate.deployment.deploy import Deployment
    from simulate.deployment.gravity_study import Case
    from simulate.model.model import Model

NAME = "simulate-deployment"
STUDY = ("elevation.csv", "gravity.png")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(NAME, "Simulate one deployment of a model.", output="trajectory (CSV)", output_default="deployment.csv")
    add_model_options(made)
    made.add_argument("--legs", type=Path, metavar="FILE", help="write elongation, length and force of each leg (CSV)")
    made.add_argument("--energy", type=Path, metavar="FILE", help="write the energy balance against time (CSV)")
    made.add_argument("--mjcf", type=Path, metavar="FILE", help="write the rig for MuJoCo (XML), to be driven by six motors")
    made.add_argument("--page", type=Path, metavar="FILE", help="write a page that plays the deployment in 3D (.html)")
    made.add_argument("--measured", type=Path, metavar="FILE", help="trajectory (CSV) that the page lays over the modelled one")
    made.add_argument(
        "--gravity-study", type=Path, metavar="FOLDER", help="the elevation with and without weight, counterweight and four times the force"
    )
    made.add_argument("--figure", type=Path, metavar="FILE", help="draw the deviations and forces (.png, .svg or .pdf)")
    return examples(
        made,
        "simulate-deployment rig.toml -o deployment.csv --page deployment.html",
        "simulate-deployment rig.toml --set platform.mass_kg=0.9",
    )


def _work(arguments: Sequence[str]) -> int:
    options = _parser().parse_args(arguments)
    _require_consistent(options)
    with _gate(options).held():
        result = _simulated(options, arguments)
    if not options.quiet:
        say(_sentences(result, options.output))
        if options.gravity_study is not None:
            say(_study_sentences(result["gravity_study"], options.gravity_study))
        say(next_command("compare-model", options.model, "MEASURED"))
    return VERDICT_BAD if result["diverged_at_s"] is not None else DONE


def _gate(options: Any) -> Outputs:
    """All that the command writes and reads."""
    files = {f"--{name}": getattr(options, name) for name in ("output", "json", "legs", "energy", "mjcf", "page", "figure")}
    files["the provenance of --output"] = provenance_beside(options.output)
    read = [options.model, *options.effects, *([options.measured] if options.measured else [])]
    return Outputs(files, {"--gravity-study": (options.gravity_study, STUDY)}, read, {"--output": TABLE})


def _require_consistent(options: Any) -> None:
    if options.measured is not None and options.page is None:
        raise InputError("--measured: is laid over the modelled trajectory on a page; name one with --page FILE.")
    if options.figure is not None and options.figure.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise InputError(f"{options.figure}: a figure ends in .png, .svg or .pdf.")


def _simulated(options: Any, arguments: Sequence[str]) -> dict[str, Any]:
    """Simulate, and write all that was asked for; the result as JSON has it."""
    from measure.common.output import provenance
    from measure.tables.trajectory import read_trajectory
    from simulate.deployment.deploy import deploy_checked
    from simulate.deployment.mujoco_export import require_expressed

    model, _ = model_from_options(options)
    if options.mjcf is not None:
        require_expressed(model)
    measured = None if options.measured is None else read_trajectory(options.measured)
    deployed = deploy_checked(model)
    note = provenance([options.model, *options.effects], command=[NAME, *arguments])
    cases = _gravity_study(options, model)
    result = {**deployed.summary, **({"gravity_study": [case.report for case in cases]} if cases else {}), "provenance": note}
    with _gate(options).together():
        _write(options, deployed, result)
        if options.page is not None:
            _write_page(options.page, deployed, measured)
        if cases:
            _write_study(options.gravity_study, cases)
    return result


def _write(options: Any, deployed: Deployment, result: dict[str, Any]) -> None:
    from measure.common.output import replacing, write_json, write_provenance, write_text
    from measure.tables.csv_cells import write_columns
    from measure.tables.trajectory import write_trajectory

    write_trajectory(deployed.trajectory, options.output)
    write_provenance(options.output, result["provenance"])
    if options.legs is not None:
        write_columns(deployed.leg_columns, options.legs)
    if options.energy is not None:
        write_columns(deployed.energy_columns, options.energy)
    if options.figure is not None:
        from simulate.report.plots import deployment_figure, figure_bytes

        with replacing(options.figure) as temporary:
            temporary.write_bytes(figure_bytes(deployment_figure(deployed), options.figure.suffix[1:].lower()))
    if options.mjcf is not None:
        from simulate.deployment.mujoco_export import mjcf_of

        write_text(options.mjcf, mjcf_of(deployed.model))
    if options.json is not None:
        write_json(options.json, result)


def _write_page(path: Path, deployed: Deployment, measured: Trajectory | None) -> None:
    from measure.common.output import write_text
    from simulate.report.replay_page import playing_html

    write_text(path, playing_html(deployed, measured))


def _gravity_study(options: Any, model: Model) -> list[Case]:
    if options.gravity_study is None:
        return []
    from simulate.deployment.gravity_study import gravity_study

    return gravity_study(model)


def _write_study(folder: Path, cases: list[Case]) -> None:
    from measure.common.output import replacing
    from measure.tables.csv_cells import write_columns
    from simulate.deployment.gravity_study import elevation_columns
    from simulate.report.plots import figure_bytes, gravity_figure

    table, drawing = (folder / name for name in STUDY)
    write_columns(elevation_columns(cases), table)
    with replacing(drawing) as temporary:
        temporary.write_bytes(figure_bytes(gravity_figure(cases)))


def _study_sentences(cases: list[dict[str, Any]], folder: Path) -> str:
    lines = []
    for case in cases:
        reached = case["time_to_full_height_s"]
        height = f"rises to {1e3 * case['highest_m']:.0f} mm" if reached is None else f"full height after {reached:.3f} s"
        lines.append(f"          {case['case']}: {height}")
    return "\n".join(["gravity   the paper's study, Fig. 16", *lines, f"          written to {folder}"])


def _sentences(result: dict[str, Any], output: Path) -> str:
    diverged = result["diverged_at_s"] is not None
    if diverged:
        verdict = f"diverged at {result['diverged_at_s']:.3f} s; cells behind are empty"
    else:
        verdict = f"energy closes to {result['energy_closure']:.1g}"
    reached = result["time_to_full_height_s"]
    height = "full height is not reached" if reached is None else f"full height after {reached:.3f} s"
    turned = "none" if result["theta_z_deg"] is None else f"{result['theta_z_deg']:.3f} deg"
    return (
        f"simulate  six legs, {result['duration_s']:.2f} s, step {1e3 * result['step_s']:.3g} ms   {verdict}\n"
        f"          {height}; theta_z at its largest {turned}\n"
        f"          {_held(result['legs_condition'])}\n"
        f"          {'nothing of it is exact' if diverged else _exact(result['step_error'])}\n"
        + "".join(f"          warning: {sentence}\n" for sentence in result["warnings"])
        + f"          written to {output}"
    )


def _held(found: dict[str, Any]) -> str:
    """How well the legs hold the platform, and by how far it may turn before they do not."""
    largest, sides = found["largest"], found["singular_theta_z_deg"]["deployed"]
    said = "condition of the legs is infinite" if largest is None else f"condition of the legs at most {largest:.3g}"
    near = [f"{side:+.0f}" for side in sides if side is not None]
    return said + (f"; at full height they lose a direction at theta_z = {' and '.join(near)} deg" if near else "")


def _exact(error: dict[str, Any] | None) -> str:
    if error is None:
        return "how exact was not computed: half the step takes too many steps"
    whole = error["whole_run"]
    if not all(math.isfinite(value) for value in whole.values()):
        return "how exact is not known: with half the step the run diverges"
    place = 1e3 * max(value for name, value in whole.items() if name.endswith("_m"))
    turn = 57.29577951308232 * max(value for name, value in whole.items() if name.endswith("_rad"))
    return f"exact to {place:.1g} mm, {turn:.1g} deg"


if __name__ == "__main__":
    raise SystemExit(main())
