"""sweep-deployments: many deployments of one model, and what their responses depend on."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.command import DONE, VERDICT_BAD, parser, progress, run
from measure.errors import InputError

if TYPE_CHECKING:
    from simulate.chunks import Chunks
    from simulate.sweep import Sweep
    from simulate.sweep_result import SweepResult

NAME = "sweep-deployments"
DESIGNS = ("full", "fractional", "latin-hypercube", "sobol", "random")
FAILURE_DEG = 30.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(
        NAME,
        "Simulate a design of deployments and regress a response on its factors. Without options: stored force and slope of each leg "
        "at +-10 %, all 4096 combinations.",
        output="folder for the tables and the figure",
        output_default="sweep",
    )
    made.add_argument("model", type=Path, metavar="MODEL", help="model file (TOML)")
    made.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change a value of the model first; repeatable")
    made.add_argument("--design", choices=DESIGNS, default="full", help="how the factors are combined (default: full)")
    made.add_argument(
        "--factor", action="append", default=[], metavar="KEY=+-10%", help="vary a value, +-10%%, +-0.02 or 2.6..3.0; repeatable"
    )
    made.add_argument("--runs", type=int, metavar="N", help="number of runs of a sampled or fractional design")
    made.add_argument("--response", default="theta_z_deg", metavar="NAME", help="what the regression explains (default: theta_z_deg)")
    made.add_argument("--failure-deg", type=float, default=FAILURE_DEG, metavar="ANGLE", help="a run beyond this abs(theta_z) failed")
    made.add_argument("--seed", type=int, default=0, help="of sampled designs (default: 0)")
    made.add_argument("--resume", action="store_true", help="go on with an interrupted sweep of the same model and design")
    made.add_argument("--workers", type=int, metavar="N", help="cores (default: all); the answer does not depend on it")
    return made


def _work(arguments: Sequence[str]) -> int:
    options = _parser().parse_args(arguments)
    _check(options)

    from measure.output import provenance
    from simulate.chunks import Chunks, key_of
    from simulate.designs import design_of, factors_of
    from simulate.model_file import read_model
    from simulate.settings import with_settings
    from simulate.sweep import Sweep

    model = with_settings(read_model(options.model), options.set)
    factors = tuple(factors_of(model, options.factor))
    sweep = Sweep(model, factors, design_of(options.design, len(factors), options.runs, options.seed))
    started = time.perf_counter()
    sweep.require_runnable()
    kept = Chunks(options.output.with_name(options.output.name + ".part"), key_of(sweep, options.seed))
    kept.open(options.resume)
    result = _result(sweep, kept, options)
    note = provenance([options.model], seed=options.seed, command=[NAME, *arguments])
    report = {**result.report, "wall_s": time.perf_counter() - started, "provenance": note}
    _write(options, result, report, note)
    kept.remove()
    if not options.quiet:
        print(_sentences(report, options))
    return VERDICT_BAD if report["diverged"] else DONE


def _check(options: Any) -> None:
    from simulate.responses import RESPONSES

    if options.response not in RESPONSES:
        from measure.errors import nearest

        raise InputError(f'no response is named "{options.response}"; {nearest(options.response, RESPONSES)}')
    if options.output.exists() and not options.output.is_dir():
        raise InputError(f"{options.output}: is a file, and a folder is written. Name another --output.")
    if not options.output.absolute().parent.is_dir():
        raise InputError(f"{options.output}: its folder does not exist. Make it, or name another --output.")
    if options.workers is not None and options.workers < 1:
        raise InputError(f"--workers {options.workers}: at least one is needed.")


def _result(sweep: Sweep, kept: Chunks, options: Any) -> SweepResult:
    from simulate.sweep_result import SweepResult

    pieces = progress(kept.run(sweep, options.workers), what="sweep", total=len(sweep.pieces()), quiet=options.quiet)
    return SweepResult.of(sweep, [answers for _, answers in pieces], options.response, options.failure_deg)


def _write(options: Any, result: SweepResult, report: dict[str, Any], note: dict[str, Any]) -> None:
    from measure.output import replacing, write_json, write_provenance
    from measure.tables import write_columns
    from simulate.plots import figure_bytes, sweep_figure

    drawn = figure_bytes(sweep_figure(report["coefficients"], result.values, result.unit, result.limit))
    options.output.mkdir(exist_ok=True)
    write_columns(result.run_columns(), options.output / "responses.csv")
    write_columns(result.coefficient_columns(), options.output / "coefficients.csv")
    write_provenance(options.output / "responses.csv", note)
    with replacing(options.output / "sweep.png") as temporary:
        temporary.write_bytes(drawn)
    if options.json is not None:
        write_json(options.json, report)


def _sentences(report: dict[str, Any], options: Any) -> str:
    interval = report["failed_interval_percent"]
    sure = "" if interval is None else f" (95 % interval {interval[0]:.2f} to {interval[1]:.2f})"
    lines = [
        f"sweep     {report['runs']} runs, {report['diverged']} diverged, {report['wall_s']:.1f} s",
        f"          {report['failed_percent']:.1f} % beyond {options.failure_deg:g} deg{sure}",
        f"          {report['formula']}",
    ]
    for angle, spread in report["tolerance"]["stored_force_spread_N"].items():
        if spread is not None:
            percent = 100 * report["tolerance"]["probability"]
            lines.append(
                f"          stored forces within {spread:.2g} N (one sd) keep abs(theta_z) under {angle} deg in {percent:g} % of runs"
            )
    return "\n".join([*lines, f"          written to {options.output}"])


if __name__ == "__main__":
    raise SystemExit(main())
