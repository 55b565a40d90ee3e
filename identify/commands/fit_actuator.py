"""`fit-actuator`: force-elongation loops to the actuator table of a model file."""

from __future__ import annotations

import shlex
from argparse import BooleanOptionalAction, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from identify.commands.parameter_options import add_parameter_options, changes_from
from measure.common.command_line import DONE, VERDICT_BAD, examples, foretell, next_command, parser, run, say, watched
from measure.common.file_kinds import FITTED
from measure.common.inputs import whole
from measure.common.output_gate import Outputs
from measure.readers.options import add_reading_options, mapping_from
from simulate.files.options import add_effects_option

if TYPE_CHECKING:
    from identify.actuator.rate_order import RateOrder
    from identify.estimation.parameters import Change
    from identify.loops.loop_data import LoopData
    from identify.loops.sign import Turned
    from measure.readers.column_mapping import ColumnMapping
    from measure.readers.loop_file import Understood
    from measure.tables.loop import Loop

NAME = "fit-actuator"
_FITS, _FITS_WITH_SUGGESTIONS = 4.0, 20.0  # of the law, and of the law with an effect more, about
FIGURES = (".png", ".pdf", ".svg")
DOES = "Fit the restoring force of an actuator, its two asymptotes and the approach to them, to force-elongation loops."


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    return run(NAME, _work, arguments)


def _parser() -> Any:
    made = parser(NAME, DOES, output="model file with the actuator table (TOML)")
    made.add_argument("loops", nargs="+", type=Path, metavar="LOOPS", help="tables of time, elongation and force")
    read = add_reading_options(made)
    read.add_argument("--save-mapping", type=Path, metavar="FILE", help="keep all of the above in a file")
    read.add_argument("--preview", action="store_true", help="show what is understood of the files, fit nothing")
    read.add_argument("--as-given", action="store_true", help="never turn the elongation's or the force's sign round")
    fit = made.add_argument_group("fitting")
    fit.add_argument("--effect", action="append", default=[], metavar="NAME", help="fit this effect of the catalogue jointly; repeatable")
    fit.add_argument("--rate", choices=("none", "frequency", "speed"), default="none", help="what the asymptotes follow")
    fit.add_argument("--rate-order", choices=("auto", "0", "1", "2"), default="auto", help="order of their polynomials")
    fit.add_argument("--tare", choices=("auto", "common", "each"), default="auto", help="one force level for all loops or one each")
    fit.add_argument("--covariate", default="", metavar="COLUMN", help="a further column to which part of the force is proportional")
    fit.add_argument("--robust", action="store_true", help="samples far off the model count less")
    fit.add_argument(
        "--suggest", action=BooleanOptionalAction, default=True, help="try the effects of the catalogue on what is left (on by default)"
    )
    fit.add_argument("--profile", action="store_true", help="fit all the rest for betas around the best one")
    fit.add_argument(
        "--bootstrap", type=whole(0, 100_000), default=0, metavar="N", help="intervals from N fits to cycles drawn with replacement"
    )
    fit.add_argument("--seed", type=whole(0, 2**63 - 1), default=0, help="of the bootstrap")
    add_parameter_options(made)
    add_effects_option(made)
    made.add_argument("--model", type=Path, metavar="MODEL", help="put the actuator into this model instead of a bare one")
    made.add_argument("--curve", type=Path, metavar="FILE", help="measured, corrected and fitted force of every sample that counts (CSV)")
    made.add_argument(
        "--figure", type=Path, metavar="FILE", help="loops with the law, what is left, the numbers; pdf: all figures (png, pdf, svg)"
    )
    made.add_argument("--figures", type=Path, metavar="FOLDER", help="each figure alone, one a question, as png and pdf")
    made.add_argument("--page", type=Path, metavar="FILE", help="page with the law, every loop and what is left (HTML)")
    return examples(
        made,
        "fit-actuator loops/*.csv --model rig.toml -o fitted.toml",
        'fit-actuator *.txt --column force="Load (kN)" --unit force=kN --effect hub-inertia --figure loops.png',
    )


def _work(arguments: Sequence[str]) -> int:
    given = _parser().parse_args(arguments)
    _check_before(given)
    with _gate(given).held():
        status, lines = _done(given, arguments)
    if not given.quiet and lines:
        say("", *lines, _next(given))
    return status


def _next(given: Namespace) -> str:
    """What one would type with the fitted law."""
    if given.output is None:
        return next_command("fit-actuator", *given.loops, "--model", given.model or "MODEL", "-o", "fitted.toml")
    if given.model is None:
        return (
            next_command("simulate-deployment", given.output) + "   once it has the geometry of a rig; --model MODEL puts the law into one"
        )
    return next_command("compare-model", given.output, "MEASURED")


def _gate(given: Namespace) -> Outputs:
    """All that the command writes and reads."""
    files = {f"--{name.replace('_', '-')}": getattr(given, name) for name in ("output", "json", "figure", "curve", "page", "save_mapping")}
    read = [*given.loops, *given.effects, *filter(None, (given.model, given.mapping))]
    if given.preview:
        return Outputs({}, {}, read)
    return Outputs(files, {"--figures": (given.figures, figures_of(given))}, read, {"--output": FITTED})


def figures_of(given: Namespace) -> tuple[str, ...]:
    """Names of the files that --figures may write."""
    if given.figures is None:
        return ()
    from identify.report.fit_plots import FILES

    return FILES


def _done(given: Namespace, arguments: Sequence[str]) -> tuple[int, list[str]]:
    """Fit, and write all that was asked for; status, and the lines for people."""
    from identify.report.loop_result import summary

    mapping = mapping_from(given)
    loops, understood, notes = _read(given, mapping)
    if not given.quiet:
        say(*_shown(understood, given.preview))
    if given.preview:
        return DONE, []
    data, turned = _oriented(given, loops)
    fit, result = _fitted(given, data, [*notes, *([f"{turned.sentence} (--as-given forbids it)"] if turned.quantity else [])])
    result["notes"] += _contradictions(understood, data)
    for one in result["suggestions"]:
        one["command"] = _command_with(arguments, one["name"])
    profile = _resampled(given, fit, data, result)
    with _gate(given).together():
        _write(given, _saved(given, mapping, turned, understood), fit, data, result, profile)
    return (DONE if result["verdict"] in ("ok", "approximate") else VERDICT_BAD), summary(result)


def _command_with(arguments: Sequence[str], effect: str) -> str:
    """The command as it was typed, with an effect more."""
    return shlex.join([NAME, *arguments, "--effect", effect])


def _check_before(given: Namespace) -> None:
    """What can be refused before any work is done."""
    from measure.common.errors import InputError

    if given.figure and given.figure.suffix not in FIGURES:
        raise InputError(f"{given.figure}: figures are {', '.join(FIGURES)}. Change the ending of the name.")
    if given.bootstrap == 1:
        raise InputError("--bootstrap 1: give at least two repeats; 200 make an interval.")
    if given.model and not given.output:
        raise InputError(f"--model {given.model}: the actuator is put into a copy of it; name the copy with --output.")


def _read(given: Namespace, mapping: ColumnMapping) -> tuple[list[Loop], list[Understood], list[str]]:
    from measure.common.every_error import for_each
    from measure.common.output import sha256
    from measure.readers.loop_file import read_loop_file

    loops, understood, notes = [], [], []
    seen: dict[str, Path] = {}
    read = for_each(lambda path: read_loop_file(path, mapping), given.loops)
    for path, (loop, how) in zip(given.loops, read, strict=True):
        twin = seen.setdefault(sha256(path), path)
        if twin is not path:
            notes.append(f"{path} is the same file as {twin}; it was left out")
            continue
        loops.append(loop)
        understood.append(how)
    return loops, understood, notes


def _shown(understood: Sequence[Understood], whole: bool) -> list[str]:
    """What was understood of each file, or of those that differ from the file before them."""
    if whole:
        return [line for how in understood for line in how.sentences()]
    lines: list[str] = []
    before = None
    for how in understood:
        file, _, dialect = how.sentences()[0].partition(": ")
        columns = how.sentences()[1 : 1 + 3]
        alike = (dialect.rsplit(",", 1)[0], tuple(columns))
        lines += [f"{file}: {dialect}", *columns] if alike != before else []
        before = alike
    return [*lines, f"{len(understood)} loops read" + (", where not shown as the one before" if len(understood) > 1 else "")]


def _oriented(given: Namespace, loops: Sequence[Loop]) -> tuple[list[LoopData], Turned]:
    from identify.loops.prepare import prepare
    from identify.loops.sign import Turned, prepared

    return ([prepare(loop) for loop in loops], Turned("", "")) if given.as_given else prepared(loops)


def _saved(given: Namespace, mapping: ColumnMapping, turned: Turned, understood: Sequence[Understood]) -> ColumnMapping:
    """The mapping as it is kept: a sign that had to be turned is turned in it, so that the next command finds it right."""
    from measure.readers.column_mapping import with_sign_turned

    if not given.save_mapping or not turned.quantity:
        return mapping
    return with_sign_turned(mapping, turned.quantity, {how.units[turned.quantity].text for how in understood})


def _fitted(given: Namespace, data: Sequence[LoopData], notes: list[str]) -> tuple[Any, dict[str, Any]]:
    from identify.actuator.curves import statistics_of, statistics_sentence
    from identify.actuator.fit_actuator import fit_actuator
    from identify.loops.covariates import hint
    from identify.report.loop_result import result_of
    from simulate.files.own_effects import catalogue_with
    from simulate.model.effect import effect_from

    catalogue = catalogue_with(given.effects)
    kinds = tuple(type(effect_from(catalogue, name, {})) for name in dict.fromkeys(given.effect))
    abscissa: Any = {"none": "none", "frequency": "frequency_Hz", "speed": "speed_m_per_s"}[given.rate]
    changes = _changes(given, data, kinds, catalogue)
    _foretell(given, data, kinds)
    order, chosen = _order(given, data, kinds, abscissa, changes)
    fit = fit_actuator(data, kinds, abscissa, order, given.tare, given.covariate, given.robust, changes, given.suggest)
    said = ["the force at a deployment's start is seen in no steady loop; initial_force_N was set to b_l_N"]
    if any(fit.tares_N):
        said = [*said, f"the force level differs from loop to loop by up to {_spread(fit.tares_N):.3g} N; each loop was given its own"]
    said = [*said, *filter(None, [hint(fit.covariate_shares)])]
    said += chosen.sentences(order) if chosen else []
    result = result_of(fit, data, [*notes, *said])
    result["statistics"] = statistics_of(fit)
    result["notes"].append(statistics_sentence(result["statistics"]))
    if chosen:
        left_out = {str(k): 100.0 * error for k, error in chosen.left_out.items()}
        result["rate"] |= {"order": order, "left_out_nrmse_percent": left_out, "papers_order_2": chosen.papers, "imitated": chosen.imitated}
        result["rate"]["inertia"] = chosen.inertia_row
    return fit, result


def _foretell(given: Namespace, data: Sequence[LoopData], kinds: Any) -> None:
    """Say about how long the fit takes: the law itself, and with --suggest the effects that are tried on what is left."""
    from identify.actuator.loops_alone import problem_of_loops
    from identify.commands.foresight import seconds_of

    problem = problem_of_loops(data, kinds, covariate=given.covariate, own_zeros=given.tare != "common" and len(data) > 1)
    fits = _FITS_WITH_SUGGESTIONS if given.suggest else _FITS
    foretell(NAME, given.quiet, "Give fewer or shorter loops, or --no-suggest.")(seconds_of(problem, fits))


def _changes(given: Namespace, data: Sequence[LoopData], kinds: Any, catalogue: Any) -> tuple[Change, ...]:
    """What is wanted of the parameters; one that is held without a value is held at that of `--model`."""
    from dataclasses import replace

    from identify.actuator.loops_alone import problem_of_loops
    from identify.estimation.problem import Problem
    from simulate.files.model_file import read_model

    def problem() -> Problem:
        return problem_of_loops(data, kinds, covariate=given.covariate, own_zeros=given.tare != "common" and len(data) > 1)

    changes = changes_from(given, problem, valued=given.model is not None)
    if given.model is None or not changes:
        return changes
    model = read_model(given.model, catalogue)
    values = {parameter.name: parameter.start for parameter in Problem(model, (), (), model.effects).parameters}
    return tuple(replace(c, value=values.get(c.name, 0.0)) if c.held and c.value is None else c for c in changes)


def _contradictions(understood: Sequence[Understood], data: Sequence[LoopData]) -> list[str]:
    """Frequencies and amplitudes that files claim and their signals deny."""
    from measure.readers.stated_conditions import contradictions

    pairs = zip(understood, data, strict=True)
    return [text for how, loop in pairs for text in contradictions(loop.name, how.claims, loop.frequency_Hz, loop.amplitude_m)]


def _order(
    given: Namespace, data: Sequence[LoopData], kinds: Any, abscissa: Any, changes: Sequence[Change]
) -> tuple[int, RateOrder | None]:
    """The order of the polynomials, and what it was chosen by."""
    if abscissa == "none":
        return 0, None
    from tqdm import tqdm

    from identify.actuator.rate_order import choose_order
    from identify.actuator.rates_and_strokes import require_rates

    wanted = None if given.rate_order == "auto" else int(given.rate_order)
    require_rates(data, abscissa, wanted or 0)
    with tqdm(desc="frequencies left out", disable=given.quiet or not watched(), leave=False) as bar:
        chosen = choose_order(data, kinds, abscissa, changes, lambda made: bar.update(1))
    return (chosen.chosen if wanted is None else wanted), chosen


def _resampled(given: Namespace, fit: Any, data: Any, result: dict[str, Any]) -> Any:
    """The profile of beta and the bootstrap, where they were asked for, into the result."""
    from identify.estimation.bootstrap import bootstrap
    from measure.common.command_line import progress

    profile = fit.profile() if given.profile or given.figure or given.figures else None
    if profile:
        table = {"beta_per_m": profile.values, "rise": profile.rise, "ci95": list(profile.interval)}
        result["beta_profile"] = table
        result["notes"].append("profile of beta: 95 % from {:.5g} to {:.5g} 1/m".format(*profile.interval))
    if given.bootstrap:
        less = "Give a smaller --bootstrap; 200 make an interval."
        steps = progress(range(given.bootstrap), what="bootstrap", total=given.bootstrap, quiet=given.quiet, change=less)
        intervals = bootstrap(fit.fit, fit.names, given.bootstrap, given.seed, lambda _: next(steps, None))
        result["bootstrap"] = {"repeats": given.bootstrap, "seed": given.seed, "ci95": intervals}
        result["notes"] += [f"bootstrap by cycles: {name} 95 % from {a:.6g} to {b:.6g}" for name, (a, b) in intervals.items()]
    return profile


def _draw(given: Namespace, fit: Any, profile: Any) -> None:
    from identify.report.fit_plots import drawings, save_figure_file, save_figures

    made = drawings(fit, profile)
    if given.figure:
        save_figure_file(made, given.figure)
    if given.figures:
        save_figures(made, given.figures)


def _spread(values: Sequence[float]) -> float:
    return max(values) - min(values)


def _write(given: Namespace, mapping: ColumnMapping, fit: Any, data: Any, result: dict[str, Any], profile: Any) -> None:
    """Every file that was asked for."""
    from measure.common.output import provenance, write_json
    from measure.readers.column_mapping import write_mapping

    note = provenance([*given.loops, *given.effects], given.seed if given.bootstrap else None)
    if given.save_mapping:
        write_mapping(mapping, given.save_mapping)
    if given.output:
        from identify.report.loop_result import model_of, write_actuator
        from simulate.files.model_file import read_model
        from simulate.files.own_effects import catalogue_with

        base = read_model(given.model, catalogue_with(given.effects)) if given.model else None
        write_actuator(
            model_of(fit, base), given.output, {**note, "verdict": result["verdict"], "reason": result["reason"]}, whole=base is not None
        )
    if given.json:
        write_json(given.json, {**result, "provenance": note})
    if given.figure or given.figures:
        _draw(given, fit, profile)
    if given.curve:
        from identify.actuator.curves import curve_columns
        from measure.tables.csv_cells import write_columns

        write_columns(curve_columns(fit), given.curve)
    if given.page:
        from identify.report.loop_page import actuator_html
        from measure.common.output import write_text

        write_text(given.page, actuator_html(fit, result, note, _next(given).removeprefix("next").strip()))
