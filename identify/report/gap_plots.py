"""Figures of a gap and of what closed it: axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from identify.gap.comparison import Curve, curves_of
from identify.gap.localise import force_in_loops
from identify.gap.platform_force import MissingForce
from identify.selection.explanation import Explanation

BEFORE, AFTER, MEASURED = "#c2571a", "#1b5e8a", "black"
_SHOWN = {"_m": (1e3, "mm"), "_rad": (1e3, "mrad"), "_N": (1.0, "N")}
_FORCE_PANELS = (
    ("missing force, N", ((0, "vertical, up", AFTER), (1, "lateral, x", BEFORE))),
    ("missing moment, N m", ((2, "about y", AFTER),)),
)


def _unit(channel: str) -> tuple[float, str, str]:
    for ending, (factor, unit) in _SHOWN.items():
        if channel.endswith(ending):
            return factor, unit, channel.removesuffix(ending)
    return 1.0, "", channel


def draw_curves(axes: Any, before: Curve, after: Curve | None) -> Any:
    """Measured against modelled, before and after."""
    factor, unit, name = _unit(before.channel)
    axes.plot(before.time_s, factor * before.measured, ".", color=MEASURED, ms=3, label="measured")
    axes.plot(before.time_s, factor * before.modelled, "--", color=BEFORE, lw=1.3, label="model as given")
    if after is not None:
        axes.plot(after.time_s, factor * after.modelled, "-", color=AFTER, lw=1.0, label="with the effect")
    axes.set_ylabel(f"{'elevation' if name == 'z' else name}, {unit}")
    _legend_above(axes)
    return axes


def _legend_above(axes: Any) -> None:
    """On the right above the curves, where it hides nothing."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1, frameon=False, fontsize="small", ncols=3)


def draw_residual(axes: Any, curve: Curve, colour: str, label: str) -> Any:
    """Measured minus modelled, with a band of two standard deviations of the noise."""
    factor, unit, _ = _unit(curve.channel)
    band = 2 * factor * curve.sigma
    axes.fill_between(curve.time_s, -band, band, color="0.85", lw=0, label="2 sigma of the noise")
    axes.plot(curve.time_s, factor * curve.gap, color=colour, lw=1.0, label=label)
    axes.set_ylabel(f"gap, {unit}")
    _legend_above(axes)
    return axes


def elevation_figure(found: Explanation) -> Any:
    """Measured against modelled elevation, as the model was given and after, with the gaps below, each on its own scale.

    Another channel where there is no elevation.
    """
    before, after = _first_shown(curves_of(found.as_given)), _first_shown(curves_of(found.after))
    return pair_figure(before, after if found.findings else None)


def _first_shown(curves: Sequence[Curve]) -> Curve:
    return next((curve for curve in curves if curve.channel == "z_m"), curves[0])


def pair_figure(before: Curve, after: Curve | None) -> Any:
    """One channel, with its gap before and after below."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 6.4), layout="constrained")
    rows = 2 if after is None else 3
    top, *below = figure.subplots(rows, 1, sharex=True, height_ratios=(2, 1, 1)[:rows])
    draw_curves(top, before, after)
    draw_residual(below[0], before, BEFORE, "model as given")
    if after is not None:
        draw_residual(below[1], after, AFTER, "with the effect")
    below[-1].set_xlabel("time, s")
    top.set_title(f"{before.run}", loc="left", fontsize="medium")
    return figure


def gaps_figure(found: Explanation) -> Any:
    """The gap of every run and channel over its noise, before and after; what was held out stands last."""
    pairs = [(before, after, "") for before, after in zip(curves_of(found.before), curves_of(found.after), strict=True)]
    for held in found.held:
        pairs += [(b, a, ", held out") for b, a in zip(curves_of(held.before), curves_of(held.after), strict=True)]
    return _grid_of_gaps([(b, a if found.findings else None, note) for b, a, note in pairs])


def _grid_of_gaps(pairs: Sequence[tuple[Curve, Curve | None, str]]) -> Any:
    from matplotlib.figure import Figure

    columns = min(3, len(pairs))
    rows = -(-len(pairs) // columns)
    figure = Figure(figsize=(9.0, 1.9 * rows), layout="constrained")
    for axes, (before, after, note) in zip(figure.subplots(rows, columns, squeeze=False).flat, pairs, strict=False):
        for curve, colour, width in ((before, BEFORE, 1.1), (after, AFTER, 0.8)):
            if curve is not None:
                axes.plot(curve.time_s, curve.gap / curve.sigma, color=colour, lw=width)
        _wide_scale(axes, float(np.max(np.abs(before.gap / before.sigma))))
        axes.axhspan(-2, 2, color="0.85", lw=0)
        axes.set_title(f"{before.run}, {before.channel}{note}", fontsize="x-small", loc="left")
        axes.tick_params(labelsize="x-small")
    for axes in figure.axes[len(pairs) :]:
        axes.set_visible(False)
    figure.supxlabel("time, s", fontsize="small")
    figure.supylabel("gap over noise", fontsize="small")
    return figure


def _wide_scale(axes: Any, largest: float) -> None:
    """Straight up to ten times the noise and logarithmic beyond, where a gap is so large that the noise would not show."""
    if largest > 100:
        axes.set_yscale("symlog", linthresh=10)
        powers = [10.0**k for k in range(1, int(np.log10(largest)) + 1)]
        axes.set_yticks([*(-p for p in reversed(powers)), 0.0, *powers])


def ranking_figure(found: Explanation) -> Any:
    """How much each effect that was tried gains, on a scale that shows small and large."""
    from matplotlib.figure import Figure

    rows = list(reversed(found.ranking[:20]))
    figure = Figure(figsize=(8.0, 0.8 + 0.28 * len(rows)), layout="constrained")
    axes = figure.subplots()
    named = {finding.name for finding in found.findings} | {e for finding in found.findings for e in finding.equivalents}
    colours = [AFTER if row.name in named else "0.7" for row in rows]
    axes.barh([row.name for row in rows], [max(row.delta_bic, 0.0) for row in rows], color=colours)
    axes.set_xscale("symlog", linthresh=10)
    axes.set_xlabel("twice the log evidence gained (10 is very strong)")
    axes.tick_params(labelsize="small")
    return figure


def missing_force_figure(missing: MissingForce) -> Any:
    """The estimated missing force along what it goes with, with a band of two standard deviations."""
    from matplotlib.figure import Figure

    told = [bool(np.isfinite(column).any()) for column in missing.sigma_N.T]
    panels = [panel for panel in _FORCE_PANELS if any(told[column] for column, _, _ in panel[1])] or list(_FORCE_PANELS)
    figure = Figure(figsize=(8.0, 2.4 * len(panels)), layout="constrained")
    for axes, (label, columns) in zip(figure.subplots(len(panels), 1, sharex=True, squeeze=False).flat, panels, strict=True):
        for column, name, colour in columns:
            if told[column]:
                _draw_force(axes, missing, column, name, colour)
        axes.axhline(0.0, color="0.5", lw=0.7)
        axes.set_ylabel(label)
        _legend_above(axes)
    figure.axes[-1].set_xlabel(missing.label)
    if len(missing.places) == 1:
        figure.axes[-1].set_xlim(missing.places[0] - missing.spacing, missing.places[0] + missing.spacing)
    return figure


def _draw_force(axes: Any, missing: MissingForce, column: int, name: str, colour: str) -> None:
    known = np.isfinite(missing.sigma_N[:, column])
    places, force, sigma = missing.places[known], missing.force_N[known, column], missing.sigma_N[known, column]
    axes.fill_between(places, force - 2 * sigma, force + 2 * sigma, color=colour, alpha=0.2, lw=0)
    axes.errorbar(places, force, 2 * sigma, fmt="o-", ms=3, elinewidth=0.7, color=colour, label=name)


def loop_force_figure(found: Explanation) -> Any:
    """The force missing in each loop against elongation and against speed, before and after."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    pair = figure.subplots(1, 2, sharey=True)
    shown = [(found.before, BEFORE, "before")] + ([(found.after, AFTER, "after")] if found.findings else [])
    for fit, colour, label in shown:
        _, rows = force_in_loops(fit)
        for axes, column in zip(pair, ("elongation_m", "speed_m_per_s"), strict=True):
            axes.plot(rows[column], rows["missing_force_N"], ".", ms=1.2, color=colour, label=label, rasterized=True)
    pair[0].set(xlabel="elongation, m", ylabel="missing force, N")
    pair[1].set(xlabel="speed of elongation, m/s")
    pair[0].legend(frameon=False, fontsize="small", markerscale=6)
    return figure


def comparison_figure(curves: Sequence[Curve]) -> Any:
    """Every run and channel: measured, modelled, and the gap below."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.6 * min(2, len(curves)), 3.4 * -(-len(curves) // 2)), layout="constrained")
    places = figure.subfigures(-(-len(curves) // 2), min(2, len(curves)), squeeze=False)
    for place, curve in zip(places.flat, curves, strict=False):
        top, bottom = place.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        factor, unit, name = _unit(curve.channel)
        top.plot(curve.time_s, factor * curve.measured, ".", color=MEASURED, ms=2, label="measured")
        top.plot(curve.time_s, factor * curve.modelled, color=BEFORE, lw=1, label="modelled")
        top.set_title(f"{curve.run}, {curve.channel}", fontsize="small", loc="left")
        top.set_ylabel(f"{name}, {unit}")
        top.legend(frameon=False, fontsize="x-small")
        draw_residual(bottom, curve, BEFORE, "measured minus modelled").get_legend().remove()
        bottom.set_xlabel("time, s")
    return figure
