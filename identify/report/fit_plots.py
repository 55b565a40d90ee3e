"""The figures of a fit of loops: a first page with loops, law, what is left and the numbers; then one figure for each question."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from identify.actuator.actuator_fit import ActuatorFit
from identify.actuator.curves import statistics_of
from identify.actuator.rates_and_strokes import by_frequency, by_stroke
from identify.actuator.verdict import errors, pooled_error
from identify.estimation.profile_likelihood import ProfileCurve
from identify.report.loop_plots import (
    RESIDUAL_AXES,
    loop_and_law,
    loops_and_law,
    loops_side_by_side,
    residual_against,
    some_loops,
)
from identify.report.phrases import with_error
from identify.report.rate_plots import (
    coefficients_against_rate,
    level_against_elongation,
    polynomials_as_text,
    profile_of_beta,
    stiffness_against,
)

NAMES: tuple[str, ...] = (
    "01-fit",
    "02-each-loop",
    "03-stroke-and-rate",
    "04-residual",
    "05-asymptotes",
    "06-friction",
    "07-level",
    "08-beta",
)
NAMES += ("09-correlations", "10-covariate")
_MOST_LINES = 12  # of a text at full size
FILES = tuple(f"{name}.{ending}" for name in NAMES for ending in ("png", "pdf"))
_PAGE = (11.69, 8.27)  # A4, inches
_WIDE, _ONE = (7.2, 4.0), (5.4, 4.2)  # of a printed page's text, and two thirds of it
_STYLE: Any = {
    "font.size": 9.0,
    "axes.titlesize": "medium",
    "axes.grid": True,
    "grid.color": "0.92",
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
}


@dataclass(frozen=True)
class Drawing:
    """A figure, and the name of its file without an ending."""

    name: str
    figure: Any


def drawings(fit: ActuatorFit, profile: ProfileCurve | None = None) -> list[Drawing]:
    """The first page, and each figure that these loops have something to show in."""
    import matplotlib

    with matplotlib.rc_context(_STYLE):
        return [Drawing(name, figure) for name, figure in _drawn(fit, profile)]


def _drawn(fit: ActuatorFit, profile: ProfileCurve | None) -> Iterator[tuple[str, Any]]:
    several = len(fit.loops) > 1
    yield NAMES[0], first_page(fit)
    yield NAMES[1], _each_loop(fit)
    if several:
        yield NAMES[2], _stroke_and_rate(fit)
    yield NAMES[3], _residual(fit)
    if several:
        yield NAMES[4], _asymptotes(fit)
    yield NAMES[5], _friction(fit)
    yield NAMES[6], _level(fit)
    if profile is not None:
        yield NAMES[7], _beta(fit, profile)
    yield NAMES[8], _correlations(fit)
    if fit.fit.problem.covariate:
        yield NAMES[9], _covariate(fit)


def save_figure_file(made: Sequence[Drawing], path: Path) -> None:
    """Write the first page, or as pdf all of them, whole or not at all; the ending of the name says what kind."""
    from measure.common.figure_plots import save_figure, save_pages
    from measure.common.output import replacing

    with replacing(path) as temporary:
        if path.suffix == ".pdf":
            save_pages([one.figure for one in made], temporary)
        else:
            save_figure(made[0].figure, temporary, path.suffix[1:], dpi=150)


def save_figures(made: Sequence[Drawing], folder: Path) -> None:
    """Write each figure alone, as png and as pdf."""
    from measure.common.figure_plots import save_figure
    from measure.common.output import replacing

    for one in made:
        for ending in ("png", "pdf"):
            with replacing(folder / f"{one.name}.{ending}") as temporary:
                save_figure(one.figure, temporary, ending, dpi=200)


def _figure(size: tuple[float, float], question: str) -> Any:
    from matplotlib.figure import Figure

    made = Figure(figsize=size, layout="constrained")
    made.get_layout_engine().set(w_pad=0.08, h_pad=0.08)  # type: ignore[union-attr]
    made.suptitle(question, fontsize="large", fontweight="bold")
    return made


def first_page(fit: ActuatorFit) -> Any:
    """Loops with law and asymptotes; what is left; the numbers."""
    figure = _figure(_PAGE, "")
    figure.suptitle("\n".join(wrap(f"{fit.verdict.word}: {fit.verdict.reason}", 140)), fontsize="medium")
    grid = figure.add_gridspec(2, 2, height_ratios=(2.6, 1.0))
    chosen = some_loops(fit.loops)
    loops = loops_and_law(figure.add_subplot(grid[0, 0]), fit, chosen)
    part = "" if len(chosen) == len(fit.loops) else f", {len(chosen)} of {len(fit.loops)} loops"
    loops.set_title(f"loops and law, last full cycles{part}")
    left = residual_against(figure.add_subplot(grid[0, 1]), fit, _strongest(fit))
    left.set_title(f"what is left: {left.get_title() if _goes_with(fit) else 'nothing looked at explains it'}")
    left.legend(loc="upper right", fontsize="x-small")
    _text(figure.add_subplot(grid[1, 0]), "parameters with standard error and 95 % interval", numbers(fit), mono=True)
    _text(figure.add_subplot(grid[1, 1]), "the fit", fit_in_words(fit))
    return figure


def _goes_with(fit: ActuatorFit) -> bool:
    """Whether a quantity explains a part of the residual that is worth naming."""
    return fit.left.sentence.startswith(fit.left.strongest)


def _strongest(fit: ActuatorFit) -> str:
    """The quantity that explains most of the residual; the elongation where none does."""
    return fit.left.strongest if _goes_with(fit) else "elongation"


def _text(axes: Any, title: str, lines: Sequence[str], *, mono: bool = False) -> None:
    axes.axis("off")
    axes.set_title(title, loc="left", fontweight="bold")
    family = "monospace" if mono else "sans-serif"
    shown = lines if mono else [part for line in lines for part in wrap(line, 104)]
    size = 8.0 if len(shown) <= _MOST_LINES else 8.0 * _MOST_LINES / len(shown)
    text = "\n".join(shown)
    axes.text(0.0, 0.98, text, va="top", fontsize=size, family=family, transform=axes.transAxes, linespacing=1.35, in_layout=False)


def numbers(fit: ActuatorFit) -> list[str]:
    """Each parameter with its error, in a line, with as many decimals as are known."""
    wide = max(map(len, fit.estimates))
    return [
        f"{name:<{wide}} {with_error(e.value, e.stderr):>20}  {with_error(e.ci95[0], e.stderr, alone=True):>9} to "
        f"{with_error(e.ci95[1], e.stderr, alone=True):<9}{'' if e.verdict == 'ok' else f' {e.verdict}'}"
        for name, e in fit.estimates.items()
    ]


def fit_in_words(fit: ActuatorFit) -> list[str]:
    """Error, misfit, and the statistics, in lines."""
    found, worst = statistics_of(fit), max(errors(fit.loops, fit.residuals))
    sure = fit.misfit.significance
    return [
        f"error: {100 * pooled_error(fit.loops, fit.residuals):.2g} % of the range of all forces",
        f"error of the loop that is met worst: {100 * worst:.2g} % of its own range",
        f"comes again in every cycle: {100 * fit.misfit.pooled:.2g} % of half the loops' height"
        + (f" ({sure:.1f} standard deviations of noise)" if np.isfinite(sure) else ""),
        f"residual: {fit.left.sentence}",
        f"half height: {fit.half_height_N:.4g} N at {1e3 * fit.centre_m:.0f} mm",
        f"{found['points']} points of {len(fit.loops)} loops, worth {found['effective_points']:.0f} independent ones",
        f"{found['free_parameters']} parameters",
        f"chi-square {found['chi_square']:.4g}, reduced {found['reduced_chi_square']:.3g}",
        f"AIC {found['aic_effective']:.1f}, BIC {found['bic_effective']:.1f} (independent points)",
        *_faults(fit),
    ]


def _faults(fit: ActuatorFit) -> list[str]:
    """Each kind of fault, and in how many loops it is."""
    kinds = list(dict.fromkeys((fault.word, fault.channel, fault.consequence) for fault in fit.faults))
    loops = [[f.loop for f in fit.faults if (f.word, f.channel, f.consequence) == kind] for kind in kinds]
    where = [Path(names[0]).name if len(names) == 1 else f"{len(names)} loops" for names in loops]
    return [f"{word} in the {channel} of {place}: {done}" for (word, channel, done), place in zip(kinds, where, strict=True)]


def _each_loop(fit: ActuatorFit) -> Any:
    order = np.argsort(-np.array(errors(fit.loops, fit.residuals)), kind="stable")[:6]
    columns = min(3, len(order))
    rows = -(-len(order) // columns)
    figure = _figure((7.2 if columns > 1 else 5.4, 0.6 + 2.7 * rows if columns > 1 else 4.2), "How well is each loop met?")
    places = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, k in zip(places, order, strict=False):
        loop_and_law(axes, fit, int(k))
    for axes in places[len(order) :]:
        axes.axis("off")
    places[0].legend(loc="best", fontsize="x-small")
    return figure


def _stroke_and_rate(fit: ActuatorFit) -> Any:
    figure = _figure((7.2, 4.4), "What do stroke and frequency change?")
    pairs = ((by_frequency(fit.loops), "by stroke, one frequency"), (by_stroke(fit.loops), "by frequency, one stroke"))
    for axes, (group, what) in zip(figure.subplots(1, 2), pairs, strict=True):
        title = what if len(group) < len(fit.loops) else f"{what.partition(',')[0]}, all loops"
        loops_side_by_side(axes, fit, group, title)
    return figure


def _residual(fit: ActuatorFit) -> Any:
    figure = _figure((7.2, 6.0), "What does what is left go with?")
    places = figure.subplots(2, 2).ravel()
    for axes, quantity in zip(places, RESIDUAL_AXES, strict=True):
        residual_against(axes, fit, quantity)
    handles, labels = places[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize="small")
    return figure


def _asymptotes(fit: ActuatorFit) -> Any:
    title, lines = polynomials_as_text(fit)
    figure = _figure((7.2, 6.4 if lines else 4.4), "How do the asymptotes follow the rate?")
    grid = figure.add_gridspec(2, 2, height_ratios=(16.0, 1.0 + len(lines)))
    handles, labels = [], []
    for column, which in enumerate(("level", "slope")):
        axes = coefficients_against_rate(figure.add_subplot(grid[0, column]), fit, fit.loops, which)
        handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, fontsize="small")
    _text(figure.add_subplot(grid[1, :]), title, lines, mono=True)
    return figure


def _friction(fit: ActuatorFit) -> Any:
    figure = _figure(_WIDE, "Is the friction dry or viscous?")
    for axes, which in zip(figure.subplots(1, 2, sharey=True), ("frequency", "amplitude"), strict=True):
        stiffness_against(axes, fit, fit.loops, which)
    return figure


def _level(fit: ActuatorFit) -> Any:
    figure = _figure(_ONE, "From which length on is the level a straight line?")
    level_against_elongation(figure.subplots(), fit, fit.loops)
    return figure


def _beta(fit: ActuatorFit, profile: ProfileCurve) -> Any:
    figure = _figure(_ONE, "How well is beta known?")
    profile_of_beta(figure.subplots(), fit, profile)
    return figure


def _correlations(fit: ActuatorFit) -> Any:
    found = statistics_of(fit)["correlations"]
    names, matrix = found["names"], np.array(found["matrix"])
    size = max(4.2, 1.9 + 0.55 * len(names))
    figure = _figure((size + 1.0, size), "Which numbers can hardly be told apart?")
    axes = figure.subplots()
    axes.grid(visible=False)
    drawn = axes.imshow(matrix, cmap="PuOr", vmin=-1.0, vmax=1.0)
    for i, row in enumerate(matrix):
        for j, value in enumerate(row):
            axes.text(j, i, f"{value:.2f}", ha="center", va="center", fontsize="small", color="white" if abs(value) > 0.6 else "black")
    axes.set_xticks(range(len(names)), names, rotation=35, ha="right")
    axes.set_yticks(range(len(names)), names)
    figure.colorbar(drawn, ax=axes, label="correlation of the estimates", shrink=0.8)
    return figure


def _covariate(fit: ActuatorFit) -> Any:
    name = fit.fit.problem.covariate
    e = fit.estimates[f"covariate.{name}"]
    figure = _figure((7.2, 4.4), f"What does {name} do to the force? {with_error(e.value, e.stderr)} N per unit")
    chosen = some_loops(fit.loops)
    before, after = figure.subplots(1, 2)
    loops_side_by_side(before, fit, chosen, "as measured", corrected=False)
    loops_side_by_side(after, fit, chosen, "corrected to its mean")
    return figure
