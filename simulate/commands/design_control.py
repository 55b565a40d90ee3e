"""design-control: gains of a controller that keeps the platform from turning, with a certificate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.common.command_line import DONE, VERDICT_BAD, examples, foretell, next_command, parser, progress, run, say
from measure.common.errors import InputError
from measure.common.file_kinds import FITTED
from measure.common.inputs import number, whole
from measure.common.output_gate import Outputs
from simulate.files.options import add_model_options, model_from_options

if TYPE_CHECKING:
    from simulate.control.task import Design, Task
    from simulate.model.model import Model

NAME = "design-control"
_PARTS = 6  # about as many parts of the work


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(
        NAME,
        "Choose the gains of a controller that keeps abs(theta_z) below an angle, with the least force and then the least energy, and "
        "certify it on fresh draws of what differs between deployments.",
        output="model with the controller (TOML)",
        output_default="controlled.toml",
    )
    add_model_options(made)
    made.add_argument("--law", default="synchronise", metavar="NAME", help="law of control (default: synchronise)")
    angle, share = number(above=0.0), number(0.5, 0.999999)
    made.add_argument("--angle", type=angle, action="append", metavar="DEG", help="abs(theta_z) to stay below (default: 30)")
    made.add_argument("--probability", type=share, action="append", metavar="P", help="of it, one for each --angle (default: 0.999)")
    made.add_argument("--force-limit", type=angle, default=1.5, metavar="N", help="most that one actuator may give")
    made.add_argument("--sample-rate", type=angle, default=1000.0, metavar="HZ", help="of sensors and law")
    made.add_argument("--delay", type=number(0.0), default=0.002, metavar="S", help="from a reading to the command")
    made.add_argument("--lag", type=number(0.0), default=0.005, metavar="S", help="of the actuator's force behind its command")
    made.add_argument("--noise", type=number(0.0), default=1e-4, metavar="M", help="of an elongation sensor, one standard deviation")
    made.add_argument("--actuator", choices=("brake", "motor"), default="brake", help="what acts on the legs (default: brake)")
    made.add_argument("--disparity", type=number(0.0, 90.0), default=10.0, metavar="PERCENT", help="by which stored forces may be off")
    made.add_argument("--confidence", type=number(0.5, 0.9999), default=0.95, metavar="P", help="of the certificate")
    made.add_argument("--draws", type=whole(16, 200_000), metavar="N", help="for the certificate (default: what the probability asks for)")
    made.add_argument("--seed", type=whole(0, 2**31), default=0, help="of the draws (default: 0)")
    made.add_argument("--page", type=Path, metavar="FILE", help="write a page with before and after (.html)")
    return examples(
        made,
        "design-control rig.toml -o controlled.toml --page control.html",
        "design-control rig.toml --angle 30 --probability 0.999 --angle 10 --probability 0.95 --force-limit 1.5",
    )


def _work(arguments: Sequence[str]) -> int:
    options = _parser().parse_args(arguments)
    requirements = _requirements(options)
    with _gate(options).held():
        design = _designed(options, arguments, requirements)
    if not options.quiet:
        say(*_sentences(design.report, options))
        if design.controller is not None:
            say(next_command("simulate-deployment", options.output, "--legs", "legs.csv"))
    return DONE if design.certified else VERDICT_BAD


def _requirements(options: Any) -> list[tuple[float, float]]:
    angles, probabilities = options.angle or [30.0], options.probability or [0.999]
    if len(angles) != len(probabilities):
        raise InputError(f"{len(angles)} --angle and {len(probabilities)} --probability; give one probability for each angle.")
    return list(zip(angles, probabilities, strict=True))


def _gate(options: Any) -> Outputs:
    files = {"--output": options.output, "--json": options.json, "--page": options.page}
    return Outputs(files, {}, [options.model, *options.effects], {"--output": FITTED})


def _designed(options: Any, arguments: Sequence[str], requirements: Sequence[tuple[float, float]]) -> Design:
    """Design, and write all that was asked for; no model where no controller was found."""
    from measure.common.output import provenance, write_json, write_text
    from simulate.control.design import design_control
    from simulate.files.model_file import write_model

    model, _ = model_from_options(options)
    task = _task(model, options, requirements)
    bar = iter(progress(range(_PARTS), what=NAME, total=_PARTS, quiet=options.quiet))
    less = "Give fewer --draws, a lower --sample-rate, or a shorter simulation.duration_s."
    design = design_control(task, lambda _: next(bar, None), foretell(NAME, options.quiet, less))
    note = provenance([options.model, *options.effects], seed=options.seed, command=[NAME, *arguments])
    with _gate(options).together():
        if design.controller is not None:
            write_model(design.model, options.output, note)
        if options.json is not None:
            write_json(options.json, {**design.report, "provenance": note})
        if options.page is not None:
            from simulate.report.control_page import control_html

            write_text(options.page, control_html(design))
    return design


def _task(model: Model, options: Any, requirements: Sequence[tuple[float, float]]) -> Task:
    from simulate.control.task import Requirement, Task
    from simulate.control.uncertainty import Uncertainty

    spread = model.nuisance
    return Task(
        model,
        options.law,
        _fixed(options),
        options.force_limit,
        tuple(Requirement(angle, probability) for angle, probability in requirements),
        Uncertainty(options.disparity / 100.0, spread.release_position_m, spread.release_theta_rad, spread.joints_m),
        options.confidence,
        options.draws,
        options.seed,
    )


def _fixed(options: Any) -> dict[str, Any]:
    """Keys of the controller that the options give."""
    sensed = {"sample_rate_Hz": options.sample_rate, "delay_s": options.delay, "sensor_noise_m": options.noise}
    return {**sensed, "lag_s": options.lag, "actuator": options.actuator}


def _sentences(report: Mapping[str, Any], options: Any) -> list[str]:
    controller = report["controller"]
    gains = ", ".join(f"{key} {value:g}" for key, value in controller.items() if _is_chosen(key, value, options))
    lines = [f"control   {report['law']}: {gains}", *_certificate(report)]
    worst = [row for row in report["margins"] if row["failed"][0]["failed_percent"] > 0.0]
    lines += [f"          {row['change']}: {row['failed'][0]['failed_percent']:.1f} % beyond" for row in worst]
    if not worst:
        lines.append("          no change of delay, noise, lag or gains that was tried, and no failed part, takes it beyond the angle")
    for row in (*report["without_control"][1:2], *report["other_laws"]):
        kept, energy = row["kept"][0], row["control_energy_J"][1]
        name = row.get("law", "without control")
        lines.append(
            f"          {name}: {kept['failed_percent']:.1f} % beyond, {kept['failed_before_stop_percent']:.1f} % before the first stop"
            + (f"; {row['control_force_N']:.3g} N, {energy:.2g} J" if "law" in row else "")
        )
    ending = f"written to {options.output}" if report["verdict"] != "none-found" else "no gains are good enough; nothing is written"
    return [*lines, f"          {ending}"]


def _is_chosen(key: str, value: Any, options: Any) -> bool:
    return isinstance(value, float) and value != 0.0 and key not in _fixed(options) and not key.startswith(("failure", "brake_speed"))


def _certificate(report: Mapping[str, Any]) -> list[str]:
    lines = []
    for row in report["certificate"]:
        for kept in row["kept"]:
            sure = "certified" if kept["certified"] else "NOT certified"
            lines.append(
                f"          stops {row['stops']}: {kept['failures']} of {row['draws']} beyond {kept['angle_deg']:g} deg, "
                f"below {kept['upper_bound_percent']:.3f} % by {100 * report['confidence']:g} %; {sure} for {kept['probability']:g}"
            )
        force, energy = row["control_force_N"], row["control_energy_J"]
        lines.append(f"          {force:.3g} N at most, {energy[0]:.2g} to {energy[1]:.2g} J")
    return lines


if __name__ == "__main__":
    raise SystemExit(main())
