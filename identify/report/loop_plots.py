"""Figures of loops: measured and modelled, side by side, and what is left; axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from identify.actuator.actuator_fit import ActuatorFit, corrected_force, transition_of
from identify.actuator.rates_and_strokes import by_frequency, by_stroke, correlation_sentence, frequency_amplitude_correlation
from identify.actuator.stiffness import friction_of
from identify.estimation.profile_likelihood import ProfileCurve
from identify.loops.loop_data import LoopData
from identify.report.rate_plots import coefficients_against_rate, level_against_elongation, profile_of_beta, stiffness_against

SHADES, STYLES = ("0.0", "0.35", "0.6"), ("-", "--", "-.", ":")
_BINS = 24
RESIDUAL_AXES = {
    "elongation": (1e3, "elongation (mm)", "elongation_m"),
    "speed": (1e3, "speed (mm/s)", "speed_m_per_s"),
    "acceleration": (1.0, "acceleration (m/s²)", "acceleration_m_per_s2"),
    "time": (1.0, "time (s)", "time_s"),
}


def loop_and_model(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData], which: int = 0) -> Any:
    """One loop measured and modelled, with its asymptotes (Aridon 2009, Fig. 10)."""
    data = loops[which]
    u, force = 1e3 * data.elongation_m[data.used], corrected_force(fit, which)[data.used]
    axes.plot(u, force, color="0.65", linewidth=0.8, label="measured")
    axes.plot(u, force - fit.residuals[which], color="black", linewidth=0.8, label="modelled")
    a_l, b_l, a_u, b_u, _ = fit.lines_of(which)
    ends, alone = np.array([u.min(), u.max()]), " of the law alone" if fit.effects else ""
    axes.plot(ends, a_l * ends / 1e3 + b_l, "k--", linewidth=0.8, label=f"lower asymptote{alone}")
    axes.plot(ends, a_u * ends / 1e3 + b_u, "k:", linewidth=1.0, label=f"upper asymptote{alone}")
    axes.set(xlabel="elongation (mm)", ylabel="force (N)", title=f"measured and modelled, {_name(data)}")
    axes.legend(fontsize="x-small")
    return axes


def _name(data: LoopData) -> str:
    return f"{data.frequency_Hz:.3g} Hz, stroke {2e3 * data.amplitude_m:.3g} mm"


def residual_against(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData], quantity: str) -> Any:
    """Measured minus modelled force of all loops against a quantity, with its mean, and how much of it the quantity explains."""
    scale, label, column = RESIDUAL_AXES[quantity]
    x = [scale * (getattr(data, column)[data.used] - (data.time_s[0] if quantity == "time" else 0.0)) for data in loops]
    for values, left in zip(x, fit.residuals, strict=True):
        axes.plot(values, left, ",", color="0.55")
    every, left = np.concatenate(x), np.concatenate(fit.residuals)
    edges = np.quantile(every, np.linspace(0.0, 1.0, _BINS + 1))
    place = np.searchsorted(edges[1:-1], every)
    count = np.maximum(np.bincount(place, minlength=_BINS), 1)
    middle, mean = (np.bincount(place, values, minlength=_BINS) / count for values in (every, left))
    axes.plot(middle, mean, "k-", linewidth=1.2, label="mean")
    axes.axhline(0.0, color="black", linewidth=0.5)
    share = fit.left.shares.get(quantity, 0.0)
    axes.set(xlabel=label, ylabel="measured - modelled (N)", title=f"residual: {quantity} explains {100 * share:.0f} %")
    axes.legend(fontsize="x-small")
    return axes


def loops_side_by_side(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData], chosen: Sequence[int], title: str) -> Any:
    """The last full cycle of these loops as measured (Aridon 2009, Figs. 7 and 8 by elongation, 11 by frequency)."""
    for place, k in enumerate(chosen):
        data = loops[k]
        a, b = data.cycles.spans[-1] if data.cycles.spans else (0, len(data.time_s))
        shade, style = SHADES[(place // len(STYLES)) % len(SHADES)], STYLES[place % len(STYLES)]
        axes.plot(1e3 * data.elongation_m[a:b], corrected_force(fit, k)[a:b], style, color=shade, linewidth=0.9, label=_name(data))
    axes.set(xlabel="elongation (mm)", ylabel="force (N)", title=title)
    if len(chosen) <= 12:
        axes.legend(fontsize="xx-small")
    return axes


def parameters_as_text(axes: Any, fit: ActuatorFit) -> Any:
    """The fitted numbers with their intervals; those of the lines in the middle of the abscissa where they follow one."""
    axes.axis("off")
    rows = [f"{name}\n    {e.value:.5g}   ({e.ci95[0]:.5g} to {e.ci95[1]:.5g})  {e.verdict}" for name, e in fit.estimates.items()]
    axes.text(0.0, 1.0, "\n".join(rows), va="top", fontsize="small", family="monospace", transform=axes.transAxes)
    axes.set_title("parameters, 95 % intervals")
    return axes


def findings_as_text(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData]) -> Any:
    """What the residual, the stiffness and the level say, in words."""
    axes.axis("off")
    said = [f"residual depends on {fit.left.sentence}", f"friction {friction_of(loops, fit.effects).sentence}"]
    said += [f"transition zone {transition_of(fit, loops).sentence}"]
    said += [f"paper's recipe: {fit.recipe.statement}"] if fit.recipe else []
    said += [text for text in [correlation_sentence(frequency_amplitude_correlation(loops))] if text]
    axes.text(0.0, 1.0, "\n\n".join("\n".join(wrap(text, 52)) for text in said), va="top", fontsize="small", transform=axes.transAxes)
    axes.set_title("findings")
    return axes


def page(fit: ActuatorFit, loops: Sequence[LoopData], title: str, profile: ProfileCurve | None = None) -> Any:
    """One page: loops and model, what is left, what follows rate and stroke, what is known."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(18, 16), layout="constrained")
    axes = figure.subplots(4, 4)
    order = np.argsort([np.nan_to_num(d.frequency_Hz) for d in loops], kind="stable")
    loop_and_model(axes[0, 0], fit, loops, int(order[0]))
    loop_and_model(axes[0, 1], fit, loops, int(order[-1])) if len(loops) > 1 else axes[0, 1].axis("off")
    for column, group, what in (
        (2, by_frequency(loops), "by elongation, one frequency"),
        (3, by_stroke(loops), "by frequency, one stroke"),
    ):
        alike = len(group) < len(loops) or len(loops) == 1
        heading = what if alike else f"{what.partition(',')[0]}, all loops"
        loops_side_by_side(axes[0, column], fit, loops, group, f"last full cycles {heading}")
    for column, quantity in enumerate(RESIDUAL_AXES):
        residual_against(axes[1, column], fit, loops, quantity)
    coefficients_against_rate(axes[2, 0], fit, loops, "level")
    coefficients_against_rate(axes[2, 1], fit, loops, "slope")
    stiffness_against(axes[2, 2], fit, loops, "frequency")
    stiffness_against(axes[2, 3], fit, loops, "amplitude")
    level_against_elongation(axes[3, 0], fit, loops)
    profile_of_beta(axes[3, 1], fit, profile)
    parameters_as_text(axes[3, 2], fit)
    findings_as_text(axes[3, 3], fit, loops)
    figure.suptitle("\n".join(wrap(title, 150)), fontsize="medium")
    return figure


def fit_figure(fit: ActuatorFit, loops: Sequence[LoopData]) -> Any:
    """The slowest and the fastest loop, measured and modelled, small."""
    from matplotlib.figure import Figure

    order = np.argsort([np.nan_to_num(d.frequency_Hz) for d in loops], kind="stable")
    chosen = list(dict.fromkeys((int(order[0]), int(order[-1]))))
    figure = Figure(figsize=(4.5 * len(chosen), 3.2), layout="constrained")
    for axes, k in zip(figure.subplots(1, len(chosen), squeeze=False)[0], chosen, strict=True):
        loop_and_model(axes, fit, loops, k)
    return figure


def save(figure: Any, path: Path) -> None:
    """Write a figure, whole or not at all; the ending of the name says what kind."""
    from measure.common.figure_plots import save_figure
    from measure.common.output import replacing

    with replacing(path) as temporary:
        save_figure(figure, temporary, path.suffix[1:])
