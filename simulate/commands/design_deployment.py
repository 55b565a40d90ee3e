"""design-deployment: geometry, stops, force law or tolerances of a model, chosen by optimisation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from measure.common.command_line import DONE, VERDICT_BAD, examples, next_command, parser, progress, run, say
from measure.common.file_kinds import FITTED
from measure.common.inputs import number, whole
from measure.common.output_gate import Outputs
from simulate.files.options import add_model_options, model_from_options
from simulate.sweeps.limits import FAILURE_DEG

if TYPE_CHECKING:
    from simulate.design.problem import Problem
    from simulate.design.search import Found

NAME = "design-deployment"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(
        NAME,
        "Choose values of a model between bounds so that a measure of its deployments is least and limits are kept, over draws of what "
        "varies; the result is tried on fresh draws.",
        output="model with the values found (TOML)",
        output_default="designed.toml",
    )
    add_model_options(made)
    measure = "MEASURE<NUMBER"
    made.add_argument("--free", action="append", default=[], metavar="KEY=LOW..HIGH", help="value that may change; tolerance.KEY a spread")
    made.add_argument("--minimise", required=True, metavar="MEASURE", help="worst:theta_z_deg, mean:, robust:, p95:, cost ...")
    made.add_argument("--subject-to", action="append", default=[], metavar=measure, help="limit to be kept; > is a limit from below")
    made.add_argument("--factor", action="append", default=[], metavar="KEY=+-10%", help="what varies, as in sweep-deployments")
    made.add_argument("--cost", action="append", default=[], metavar="KEY=NUMBER", help="of a tolerance that is free (default: 1)")
    made.add_argument("--failure-deg", type=number(above=0.0), default=FAILURE_DEG, metavar="ANGLE", help="of failed_percent")
    made.add_argument("--draws", type=whole(1, 65_536), default=64, metavar="N", help="of what varies, for each candidate: a power of two")
    made.add_argument("--evaluations", type=whole(16, 1_000_000), default=400, metavar="N", help="candidates that are tried, about")
    made.add_argument("--seed", type=whole(0, 2**31), default=0, help="of draws and search (default: 0)")
    return examples(
        made,
        "design-deployment rig.toml --free end_stop.damping_N_s_per_m=5..80 --minimise worst:theta_z_deg "
        "--subject-to 'worst:stop_force_N<60' --factor actuator.stored_force_N[0]=sigma:0.01",
        "design-deployment rig.toml --factor actuator.stored_force_N[0]=sigma:0.01 --free tolerance.actuator.stored_force_N[0]=1e-4..0.1 "
        "--minimise cost --subject-to 'p95:theta_z_deg<5'",
    )


def _work(arguments: Sequence[str]) -> int:
    options = _parser().parse_args(arguments)
    with _gate(options).held():
        found = _designed(options, arguments)
    if not options.quiet:
        say(*_sentences(found.report, options))
        if found.verdict != "none-feasible":
            say(next_command("sweep-deployments", options.output))
    return DONE if found.verdict == "found" else VERDICT_BAD


def _gate(options: Any) -> Outputs:
    return Outputs({"--output": options.output, "--json": options.json}, {}, [options.model, *options.effects], {"--output": FITTED})


def _designed(options: Any, arguments: Sequence[str]) -> Found:
    """Search, and write all that was asked for; no model where no candidate kept the limits."""
    from measure.common.output import provenance, write_json
    from simulate.design.search import design_deployment
    from simulate.files.model_file import write_model

    problem = _problem(options)
    less = "Give fewer --evaluations or --draws, or a shorter simulation.duration_s."
    bar = iter(progress(range(options.evaluations), what=NAME, total=options.evaluations, quiet=options.quiet, change=less))
    found = design_deployment(problem, options.evaluations, lambda _: next(bar, None))
    note = provenance([options.model, *options.effects], seed=options.seed, command=[NAME, *arguments])
    with _gate(options).together():
        if found.verdict != "none-feasible":
            write_model(found.model, options.output, note)
        if options.json is not None:
            write_json(options.json, {**found.report, "provenance": note})
    return found


def _problem(options: Any) -> Problem:
    from simulate.design.measures import Limit, Measure
    from simulate.design.problem import Free, Problem, factor_costs
    from simulate.sweeps.factors import factors_of, with_named_effects

    model, catalogue = model_from_options(options)
    model = with_named_effects(model, [*options.factor, *options.free], catalogue)
    return Problem(
        model,
        tuple(Free.of(text) for text in options.free),
        Measure.of(options.minimise),
        tuple(Limit.of(text) for text in options.subject_to),
        tuple(factors_of(model, options.factor)) if options.factor else (),
        factor_costs(options.cost),
        options.draws,
        options.failure_deg,
        options.seed,
    )


def _sentences(report: Mapping[str, Any], options: Any) -> list[str]:
    verdicts = {
        "found": "found",
        "not-kept": "a limit does not hold on fresh draws; give more --draws or --evaluations, or ask for a margin",
        "none-feasible": "no candidate keeps all limits; widen --free or the limits",
    }
    lines = [f"design    {verdicts[report['verdict']]}; {report['evaluations']} candidates on {max(1, report['draws'])} draws each"]
    for free in report["free"]:
        ending = "" if free["at_bound"] is None else f", at its {free['at_bound']} bound"
        lines.append(f"          {free['key']} {free['value']:.6g} (before {free['before']:.6g}){ending}")
    goal = report["objective"]
    lines.append(f"          {goal['measure']} {goal['fresh']:.4g} on {_fresh(report)} (before {goal['before']:.4g})")
    for limit in report["limits"]:
        side, kept = ("<", "below") if "below" in limit else (">", "above"), "kept" if limit["kept"] else "NOT kept"
        lines.append(
            f"          {limit['measure']} {limit['fresh']:.4g} {side[0]} {limit[side[1]]:g}: {kept} (before {limit['before']:.4g})"
        )
    written = report["verdict"] != "none-feasible"
    return [*lines, f"          written to {options.output}" if written else "          nothing is written"]


def _fresh(report: Mapping[str, Any]) -> str:
    return f"{report['fresh_draws']} fresh draws" if report["fresh_draws"] else "the model as it stands"


if __name__ == "__main__":
    raise SystemExit(main())
