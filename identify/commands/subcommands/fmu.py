"""`unspool fmu`: the force law of a fitted leg for the simulation tools of others."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from typing import Any

from measure.common.command_line import DONE, examples, parser, run, say

NAME = "unspool fmu"
DOES = "Write the force law of a leg as an FMU (FMI 3.0, co-simulation): elongation in, force out, exact along every step."


def main(arguments: Sequence[str] | None = None) -> int:
    """The task."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    from measure.common.inputs import whole
    from simulate.files.options import add_model_options

    made = parser(NAME, DOES, output="FMU to write", output_default="leg.fmu")
    add_model_options(made)
    made.add_argument("--leg", type=whole(1, 6), metavar="N", help="which leg, 1 to 6; needed where they differ")
    return examples(made, "unspool fmu fitted.toml -o leg.fmu", "unspool fmu fitted.toml --leg 3 --set actuator.beta_per_m=400")


def _work(arguments: Sequence[str]) -> int:
    given = _parser().parse_args(arguments)
    from measure.common.file_kinds import ARCHIVE
    from measure.common.output_gate import Outputs

    files = {"--output": given.output, "--json": given.json}
    outputs = Outputs(files, {}, [given.model, *given.effects], {"--output": ARCHIVE})
    with outputs.held():
        law = _written(given, outputs)
    if not given.quiet:
        say(*_sentences(given, law))
    return DONE


def _written(given: Namespace, outputs: Any) -> dict[str, Any]:
    """Write all that was asked for; what stands in the FMU."""
    from measure.common.output import provenance, write_json
    from simulate.files.leg_fmu import law_of, write_fmu
    from simulate.files.options import model_from_options

    model, _ = model_from_options(given)
    with outputs.together():
        write_fmu(model, given.output, given.leg)
        law = law_of(model, given.leg)
        if given.json is not None:
            write_json(given.json, {**law, "provenance": provenance([given.model, *given.effects])})
    return law


def _sentences(given: Namespace, law: dict[str, Any]) -> list[str]:
    values = [f"          {name:<16} {value:.6g} {unit}" for name, (value, unit, _) in law["parameters"].items()]
    what, _, without = law["description"].partition("; ")
    apart = [f"          {without}: add that in your tool"] if without else []
    return [f"fmu       {what}", *values, *apart, f"          written to {given.output}; it runs where Python with NumPy is"]
