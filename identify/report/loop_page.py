"""The page of a fit of loops: the law, how well it meets each loop, and what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from identify.actuator.actuator_fit import ActuatorFit
from identify.actuator.rates_and_strokes import correlation_sentence
from identify.loops.loop_data import LoopData
from identify.report.loop_page_figures import covariate_section, last_cycle_of, loops_and_law, rate_section
from identify.report.loop_plots import name_of
from identify.report.phrases import sized, with_error
from measure.pages.figure import Band, Figure, Line, Panel
from measure.pages.page import facts_of, number, opened
from measure.pages.sections import Bars, Section, Table, sections_html
from measure.pages.summary import Number, Summary, Tone

_OPEN = 4  # loops that are not folded
_TONES: Mapping[str, Tone] = {"ok": "good", "approximate": "doubt", "loops-disagree": "doubt"}


def actuator_html(fit: ActuatorFit, result: Mapping[str, Any], note: Mapping[str, Any], next_word: str = "") -> str:
    """The whole page.

    Parameters
    ----------
    result : of `result_of`. note : provenance. next_word : the command that one would type now.
    """
    order = np.argsort([-row["misfit_percent_of_half_height"] for row in result["loops"]], kind="stable")
    figures = [_loop_figure(fit, int(k), f"loop-{place + 1}") for place, k in enumerate(order)]
    sections = [
        Section("Loops and law", figures=[loops_and_law(fit)]),
        Section("The law", tables=[_parameters(result), _statistics(result)], paragraphs=[_in_words(result)]),
        *rate_section(fit),
        *covariate_section(fit),
        Section("The loops, the one that is met worst first", tables=[_loops(result)], figures=figures[:_OPEN]),
        Section(
            "What is left",
            [opened(f"what is left depends on {result['residual_depends_on']}.")],
            bars=[_shares(result)],
            listed=_findings(result),
        ),
        *([Section(f"{len(figures) - _OPEN} more loops", figures=figures[_OPEN:], folded=True)] if figures[_OPEN:] else []),
        Section("Correlations of the parameters", tables=[_correlations(fit)], folded=True),
        Section("What the record holds", listed=[*result["record"], *result["notes"]], folded=True),
    ]
    return sections_html("The force law of an actuator", "unspool · fit-actuator", _summary(fit, result, note, next_word), sections, note)


def _summary(fit: ActuatorFit, result: Mapping[str, Any], note: Mapping[str, Any], next_word: str) -> Summary:
    names = ("b_l_N", "b_u_N", "beta_per_m")
    told = ", ".join(f"{name.split('_N')[0].split('_per')[0]} = {_with_interval(fit, name)}" for name in names)
    effects = "".join(f"; {sized(fit.fit.problem.effects_at(fit.fit.q)[i], result['parameters'])}" for i in range(len(fit.effects)))
    worth = f"the law meets {len(result['loops'])} loops to {result['pooled_nrmse_percent']:.2g} % of the range of all forces"
    faults = [f"{fault['loop']}: {fault['word']}, {fault['consequence']}: {fault['sentence']}" for fault in result["faults"]]
    steps = [f"{one['sentence']}: {one.get('command') or '--effect ' + one['name']}" for one in result["suggestions"]]
    return Summary(
        result["verdict"],
        _TONES.get(result["verdict"], "bad"),
        f"{opened(worth)}, with {told}{effects}.",
        [opened(result["reason"]) + ".", *faults],
        [
            Number("error of the law", f"{result['pooled_nrmse_percent']:.2g} %", "of the range of all forces", "effect"),
            Number(
                "comes again in every cycle", f"{result['misfit']['percent_of_half_height']:.2g} %", "of half the loops' height", "effect"
            ),
            Number("half height", f"{result['half_height_N']:.3g} N", "upper minus lower asymptote, halved"),
            Number("loops", str(len(result["loops"])), f"{len({round(row['frequency_Hz'], 2) for row in result['loops']})} frequencies"),
        ],
        [*steps, *([next_word] if next_word else [])],
        facts_of(note, data=f"{len(result['loops'])} loops, {sum(row['samples_used'] for row in result['loops'])} samples that count"),
    )


def _with_interval(fit: ActuatorFit, name: str) -> str:
    e, unit = fit.estimates[name], " 1/m" if name.endswith("per_m") else " N"
    low, high = (number(end, 4) for end in e.ci95)
    return f"{number(e.value, 4)}{unit} ({low} to {high})"


def _parameters(result: Mapping[str, Any]) -> Table:
    rows = [[name, *_rounded(e), e["verdict"]] for name, e in result["parameters"].items()]
    return Table("parameters", "Values with 95 % intervals", ["parameter", "value", "standard error", "95 % from", "to", "verdict"], rows)


def _rounded(e: Mapping[str, Any]) -> list[str]:
    """Value, standard error and the ends of the interval, with as many decimals as are known."""
    value, _, error = with_error(e["value"], e["stderr"]).partition(" ± ")
    return [value, error, *(with_error(end, e["stderr"], alone=True) for end in e["ci95"])]


def _statistics(result: Mapping[str, Any]) -> Table:
    found = result.get("statistics", {})
    names = {
        "points": "points",
        "effective_points": "independent points that they are worth",
        "free_parameters": "free parameters",
        "chi_square": "chi-square over the noise",
        "reduced_chi_square": "reduced chi-square",
        "aic_effective": "AIC, of independent points",
        "bic_effective": "BIC, of independent points",
    }
    return Table("statistics", "The fit in numbers", ["of the fit", "value"], [[names[key], found[key]] for key in names if key in found])


def _in_words(result: Mapping[str, Any]) -> str:
    recipe = result["paper_recipe"]
    return (
        f"The paper's recipe, by straight parts of the branches: {recipe['statement'] if recipe else 'no straight parts on both branches'}."
    )


def _loops(result: Mapping[str, Any]) -> Table:
    rows = [
        [
            Path(row["file"]).name,
            row["frequency_Hz"],
            2e3 * row["amplitude_m"],
            row["nrmse_percent"],
            row["area_error_percent"],
            row["misfit_percent_of_half_height"],
            row["effective_stiffness_N_per_m"],
            1e3 * row["force_noise_N"],
        ]
        for row in result["loops"]
    ]
    heads = [
        "loop",
        "Hz",
        "stroke, mm",
        "error, % of range",
        "area off, %",
        "misfit, % of half height",
        "effective stiffness, N/m",
        "noise, mN",
    ]
    return Table("loops", "Loop by loop", heads, rows)


def _shares(result: Mapping[str, Any]) -> Bars:
    sizes = {name: 100.0 * share for name, share in result["residual_shares"].items()}
    return Bars("residual", "How much of what is left each quantity explains", "share, %", sizes, "goes with")


def _findings(result: Mapping[str, Any]) -> list[str]:
    said = [f"Friction: {result['friction']}", f"Transition zone: {result['transition']['sentence']}"]
    said += [f"Slopes: {result['slopes']}"] if result["slopes"] else []
    said += [one["sentence"] for one in result["disagreements"]]
    return [*said, *(text for text in [correlation_sentence(result["frequency_amplitude_correlation"])] if text)]


def _correlations(fit: ActuatorFit) -> Table:
    covariance = fit.covariance
    sizes = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    table = covariance / np.outer(sizes, sizes)
    rows = [[name, *(f"{value:.2f}" for value in row)] for name, row in zip(fit.names, table, strict=True)]
    return Table("correlations", "Beyond 0.9 two numbers can hardly be told apart", ["parameter", *fit.names], rows)


def _loop_figure(fit: ActuatorFit, k: int, name: str) -> Figure:
    """The last full cycle of a loop: measured and modelled over the elongation, and what is left."""
    data: LoopData = fit.loops[k]
    u, force, left = last_cycle_of(fit, k)
    a_l, b_l, a_u, b_u, _ = fit.lines_of(k)
    ends = np.array([u.min(), u.max()])
    alone = ", law alone" if fit.effects else ""
    lines: Sequence[Line] = [
        Line("measured", u, force, "measured", dots=True),
        Line("modelled", u, force - left, "effect"),
        Line(f"lower asymptote{alone}", ends, a_l * ends / 1e3 + b_l, "limit"),
        Line(f"upper asymptote{alone}", ends, a_u * ends / 1e3 + b_u, "limit"),
    ]
    band = Band("noise, 2 sigma", np.sort(u), np.full(len(u), -2 * data.force_sigma_N), np.full(len(u), 2 * data.force_sigma_N))
    panels = [
        Panel("force, N", lines, height_px=240),
        Panel("measured minus modelled, N", [Line("left", u, left, "effect")], (band,), 130, 0.0),
    ]
    title = f"{Path(data.name).name}: {name_of(data)}"
    return Figure(name, title, "elongation, mm", panels, "Last full cycle.")
