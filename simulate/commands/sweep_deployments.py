"""sweep-deployments: many deployments of one model, and what their responses depend on."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from measure.common.command_line import DONE, VERDICT_BAD, examples, foretell, next_command, parser, progress, run, say
from measure.common.errors import InputError
from measure.common.inputs import number, whole
from measure.common.limits import DATASET_ENDINGS
from measure.common.output_gate import Outputs
from simulate.files.options import add_model_options, model_from_options
from simulate.sweeps.limits import DESIGNS, FAILURE_DEG, FEWEST_RARE, INDICES

if TYPE_CHECKING:
    from simulate.sweeps.result import SweepResult

NAME = "sweep-deployments"
_LESS = "Give fewer --runs or factors, or a shorter simulation.duration_s; an interrupted sweep goes on with --resume."
TABLES = ("sweep.png", "responses.csv", "responses.csv.provenance.json", "coefficients.csv", "indices.png")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(
        NAME,
        "Simulate a design of deployments and regress a response on its factors. Without options: stored force and slope of each leg "
        "at +-10 %, all 4096 combinations.",
        output="folder for the tables and the figure, or one file with all runs: NAME.nc (netCDF) or NAME.h5 (HDF5)",
        output_default="sweep",
    )
    add_model_options(made)
    made.add_argument("--design", choices=DESIGNS, help="how the factors are combined (default: full)")
    made.add_argument("--indices", choices=INDICES, help="sensitivity indices with intervals, on runs chosen for them")
    made.add_argument(
        "--rare", type=whole(FEWEST_RARE, 1_000_000), metavar="N", help="failure probability by subset simulation, N runs a level"
    )
    made.add_argument(
        "--factor",
        action="append",
        default=[],
        metavar="KEY=+-10%",
        help="vary a value, +-10%%, +-0.02, 2.6..3.0, or with a normal spread, sigma:0.001 or sigma:1%%; repeatable",
    )
    made.add_argument("--runs", type=whole(1, 10_000_000), metavar="N", help="number of runs of a sampled or fractional design")
    made.add_argument("--response", default="theta_z_deg", metavar="NAME", help="what the regression explains (default: theta_z_deg)")
    made.add_argument(
        "--failure-deg", type=number(above=0.0), default=FAILURE_DEG, metavar="ANGLE", help="a run beyond this abs(theta_z) failed"
    )
    made.add_argument(
        "--tolerance-deg", type=number(above=0.0), action="append", metavar="ANGLE", help="angle to keep under (default: 5 and 30)"
    )
    made.add_argument("--probability", type=number(0.001, 0.999), default=0.95, metavar="P", help="of keeping under it (default: 0.95)")
    made.add_argument("--seed", type=whole(0, 2**63 - 1), default=0, help="of sampled designs (default: 0)")
    made.add_argument("--page", type=Path, metavar="FILE", help="page with failures, factors and tolerances (HTML)")
    made.add_argument("--resume", action="store_true", help="go on with an interrupted sweep of the same model and design")
    made.add_argument("--workers", type=whole(1, 100_000), metavar="N", help="cores (default: all); the answer does not depend on it")
    made.add_argument("--dask", metavar="ADDRESS", help="compute on the cluster of this scheduler, as tcp://host:8786")
    return examples(
        made,
        "sweep-deployments rig.toml -o sweep",
        "sweep-deployments rig.toml --design sobol --runs 4096 --factor platform.mass_kg=+-5% -o sweep.nc",
        "sweep-deployments rig.toml --indices sobol --factor platform.mass_kg=+-5% --factor end_stop.damping_N_s_per_m=+-30%",
    )


def _work(arguments: Sequence[str]) -> int:
    options = _parser().parse_args(arguments)
    _check(options)
    with _gate(options).held():
        report, wall_s = _reported(options, arguments)
    if not options.quiet:
        say(_sentences(report, wall_s, options), next_command("simulate-deployment", options.model, "--set", "KEY=VALUE"))
    return VERDICT_BAD if report["diverged"] else DONE


def _gate(options: Any) -> Outputs:
    """All that the command writes and reads; the pieces of the sweep stand in a folder beside that of the result."""
    one = _is_one_file(options)
    files = {"--json": options.json, "--page": options.page, "--output": options.output if one else None}
    folders = {"--output": (None if one else options.output, TABLES), "the pieces": (_pieces(options), ())}
    return Outputs(files, folders, [options.model, *options.effects])


def _is_one_file(options: Any) -> bool:
    """Whether all runs go into one file instead of a folder; it is no folder of that name that is there already."""
    return options.output.suffix in DATASET_ENDINGS and not options.output.is_dir()


def _pieces(options: Any) -> Path:
    return options.output.with_name(options.output.name + ".part") if options.output.name else options.output / ".part"


def _reported(options: Any, arguments: Sequence[str]) -> tuple[dict[str, Any], float]:
    """Sweep, and write all that was asked for; the result as JSON has it, and how long the runs took, which is no part of it."""
    from measure.common.output import provenance
    from simulate.deployment.deploy import warnings_of_rates
    from simulate.model.possible import warnings_of
    from simulate.sweeps.chunks import remove_pieces, require_of_a_sweep
    from simulate.sweeps.tolerance import tolerance_of

    require_of_a_sweep(_pieces(options))
    try:
        result = _swept(options)
    except KeyboardInterrupt as stop:
        if _pieces(options).exists():
            stop.add_note(f"what was computed is kept in {_pieces(options)}, and --resume goes on with it")
        raise
    model = result.sweep.model
    tolerance = tolerance_of(model, options.tolerance_deg or (5.0, FAILURE_DEG), options.probability, options.seed)
    note = provenance([options.model, *options.effects], seed=options.seed, command=[NAME, *_without_how(arguments)])
    report = {
        **result.report,
        "step": result.step,
        "tolerance": tolerance,
        "warnings": [*warnings_of(model), *warnings_of_rates(model)],
        "wall_s": None,  # a key of the contract; a time here would make other bytes of the same input
        "provenance": note,
    }
    with _gate(options).together():
        _write(options, result, report)
    remove_pieces(_pieces(options))
    return report, result.wall_s


def _check(options: Any) -> None:
    from simulate.model.responses import response_named

    response_named(options.response)
    if _is_one_file(options):
        from measure.tables.dataset_file import require_dataset_file

        require_dataset_file(options.output)
    if options.indices is not None and options.design is not None:
        raise InputError(f"--design {options.design} and --indices {options.indices} both choose the runs; leave one out.")
    if options.dask is not None and options.effects:
        raise InputError(f"{options.effects[0]}: the workers of a cluster do not have effects of your own; sweep without --dask.")


def _swept(options: Any) -> SweepResult:
    """The sweep, its responses on disk until the result stands; nothing is begun before a cluster answers."""
    from simulate.sweeps.factors import with_named_effects
    from simulate.sweeps.run_sweep import sweep

    model, catalogue = model_from_options(options)
    model = with_named_effects(model, options.factor, catalogue)
    design = (options.factor, options.design or "full", options.runs, options.seed, options.workers, options.response, options.failure_deg)
    with _executor(options) as executor:
        return sweep(
            model,
            *design,
            indices=options.indices,
            rare=options.rare,
            executor=executor,
            folder=_pieces(options),
            resume=options.resume,
            progress=lambda pieces, total: progress(pieces, what="sweep", total=total, quiet=options.quiet, change=_LESS),
            foretell=foretell(NAME, options.quiet, _LESS),
        )


def _executor(options: Any) -> AbstractContextManager[Executor | None]:
    """The cluster's, or none for this machine."""
    if options.dask is None:
        return nullcontext()
    from simulate.sweeps.cluster import connected

    return connected(options.dask)


def _without_how(arguments: Sequence[str]) -> list[str]:
    """The arguments of the command without those that change no byte of the result."""
    words, kept = iter(arguments), []
    for word in words:
        if word in ("--workers", "--dask"):
            next(words)
        elif word not in ("--resume", "--quiet") and not word.startswith(("--workers=", "--dask=")):
            kept.append(word)
    return kept


def _write(options: Any, result: SweepResult, report: dict[str, Any]) -> None:
    from measure.common.output import write_json
    from simulate.sweeps.dataset import write_sweep

    if _is_one_file(options):
        write_sweep(result, options.output, report["provenance"])
    else:
        _write_folder(options, result, report)
    if options.json is not None:
        write_json(options.json, report)
    if options.page is not None:
        from measure.common.output import write_text
        from simulate.report.sweep_page import sweep_html

        write_text(options.page, sweep_html(result, report, [line.strip() for line in _tolerance_sentences(report["tolerance"])]))


def _write_folder(options: Any, result: SweepResult, report: dict[str, Any]) -> None:
    from measure.common.output import replacing, write_provenance
    from measure.tables.csv_cells import write_columns
    from simulate.report.index_plots import indices_figure
    from simulate.report.plots import figure_bytes, sweep_figure

    figure, responses, _, coefficients, indices = (options.output / name for name in TABLES)
    with replacing(figure) as temporary:
        temporary.write_bytes(figure_bytes(sweep_figure(result, report["tolerance"])))
    if result.indices is not None and result.indices["indices"] is not None:
        with replacing(indices) as temporary:
            temporary.write_bytes(figure_bytes(indices_figure(result.indices, result.response, result.unit)))
    write_columns(result.run_columns(), responses)
    write_columns(result.coefficient_columns(), coefficients)
    write_provenance(responses, report["provenance"])


def _sentences(report: dict[str, Any], wall_s: float, options: Any) -> str:
    interval, step = report["failed_interval_percent"], report["step"]
    sure = "" if interval is None else f" (95 % interval {interval[0]:.2f} to {interval[1]:.2f})"
    exact = "" if step["largest_error_deg"] is None else f", theta_z good to {step['largest_error_deg']:.1g} deg"
    share = 100 * step["sensitive_probes"] / step["probes"]
    lines = [
        f"sweep     {report['runs']} runs, {report['diverged']} diverged, {wall_s:.1f} s",
        f"          steps up to {1e3 * step['step_s']:.3g} ms{exact}; {share:.0f} % of the runs are sensitive to the release",
        f"          {report['failed_percent']:.1f} % beyond {options.failure_deg:g} deg{sure}",
        f"          {report['failed_before_stop_percent']:.1f} % were before the first stop; the others turned in the rebound",
        f"          {report['formula']}",
        *_regression_sentence(report),
        *_index_sentences(report),
        *_rare_sentence(report, options.failure_deg),
        *_tolerance_sentences(report["tolerance"]),
        *(f"          warning: {sentence}" for sentence in report["warnings"]),
    ]
    return "\n".join([*lines, f"          written to {options.output}"])


def _regression_sentence(report: dict[str, Any]) -> list[str]:
    fresh = report["fresh"]
    if fresh["rms"] is None:
        return []
    return [
        f"          on {fresh['runs']} fresh runs off by {fresh['rms']:.3g} (rms), the response itself is {fresh['rms_of_response']:.3g}"
    ]


def _index_sentences(report: dict[str, Any]) -> list[str]:
    """A line for each factor, those that matter most first."""
    found = report["indices"]
    if found is None:
        return []
    if found["indices"] is None:
        return ["          no indices: the response does not vary, or too few runs have one"]
    sobol = found["method"] == "sobol"
    leading, beside = ("total", "first_order") if sobol else ("mean_size", "spread")
    rows, others, keys = found["indices"][leading], found["indices"][beside], {f["letter"]: f["key"] for f in report["factors"]}
    words = ("share of the variance, with all it has to do with", "by itself") if sobol else ("mean size of its effect", "spread")
    return [f"          {words[0]}, and {words[1]}, 95 % intervals:"] + [
        f"          {letter} {keys[letter]}: {_ranged(rows[letter])}, {_ranged(others[letter])}"
        for letter in sorted(rows, key=lambda letter: -rows[letter]["value"])
    ]


def _ranged(row: dict[str, Any]) -> str:
    low, high = row["interval"]
    return f"{row['value']:.3g} ({low:.3g} to {high:.3g})"


def _rare_sentence(report: dict[str, Any], failure_deg: float) -> list[str]:
    found = report["subset_simulation"]
    if found is None:
        return []
    low, high = found["interval"]
    said = f"{found['probability']:.2g} (95 % interval {low:.2g} to {high:.2g})" if found["reached"] else f"below {high:.2g}; never reached"
    return [f"          probability beyond {failure_deg:g} deg {said}, by {found['runs']} runs of a subset simulation"]


def _tolerance_sentences(tolerance: dict[str, Any]) -> list[str]:
    lines, percent = [], 100 * tolerance["probability"]
    for angle, spread in tolerance["stored_force_spread_N"].items():
        if spread is not None:
            low, high = tolerance["simulated"][angle]["interval"]
            lines.append(
                f"          stored forces within {spread:.2g} N (one sd) keep abs(theta_z) under {angle} deg in {percent:g} % of runs"
                f" (simulated: {100 * low:.0f} to {100 * high:.0f} %)"
            )
    adjust, order = tolerance["adjust"], tolerance["sort"]
    if order is not None:
        now = f"{adjust['theta_z_before_deg']:.1f} deg now"
        lines.append(f"          leg {adjust['leg']} by {adjust['by_N']:+.2g} N leaves {adjust['theta_z_after_deg']:.1f} deg, {now}")
        placed = " ".join(map(str, order["order"]))
        lines.append(f"          legs {placed} in places 1 to 6 leave {order['theta_z_after_deg']:.1f} deg")
    return lines


if __name__ == "__main__":
    raise SystemExit(main())
