"""Figures of what follows rate, stroke and length: coefficients, effective stiffness, force level; and the profile of beta."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from identify.actuator.actuator_fit import ActuatorFit, corrected_force, line_at, polynomial_errors_of, transition_of
from identify.actuator.rates_and_strokes import rates_of, strokes
from identify.actuator.stiffness import stiffness_of_cycles
from identify.criteria import STRAIGHT_FROM
from identify.estimation.profile_likelihood import ProfileCurve
from identify.loops.loop_data import LoopData, free_start
from identify.loops.paper_recipe import shifted, straight_lines
from identify.report.phrases import with_error
from measure.common.arrays import Array
from measure.common.figure_plots import COLOURS

_STRAIGHT = 5.0  # lengths 1 / beta behind a reversal, from which on a branch is straight
_MARKS = ("o", "s", "^", "D", "v", "P")
_UNITS = ("N/m", "N", "N/m", "N")  # of a_l, b_l, a_u, b_u
_ABSCISSA = {"frequency_Hz": "frequency (Hz)", "speed_m_per_s": "mid-stroke speed (m/s)"}


def coefficients_against_rate(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData], which: str) -> Any:
    """Level or slope of both asymptotes against the rate: the fit with its 95 % band, and each loop by itself (Aridon 2009, Fig. 12).

    The level is taken in the middle of the elongations. A loop by itself is a straight line through each branch, effects taken out;
    a stroke that is too short to have straight branches has none.
    """
    rate, row = fit.fit.problem.rate, {"slope": 0, "level": 1}[which]
    abscissa = rate.abscissa if rate.abscissa != "none" else "speed_m_per_s"
    x = rates_of(loops, abscissa)
    known = np.isfinite(x)
    low, high = (float(bound(x[known])) if np.any(known) else 0.0 for bound in (np.min, np.max))
    ends = np.linspace(low, high, 60) if high > low else np.array([0.95, 1.05]) * low
    alone = [line_alone(fit, k, data) for k, data in enumerate(loops)]
    sides = ((row, "--", "o", COLOURS[0], "lower asymptote"), (row + 2, "-.", "s", COLOURS[1], "upper asymptote"))
    for side, (line, style, mark, colour, label) in enumerate(sides):
        if np.any(known):
            value, error = line_at(fit, line, ends, fit.centre_m if which == "level" else None)
            axes.plot(ends, value, style, color=colour, linewidth=1.3, label=f"{label}, fitted to all, with 95 % band")
            axes.fill_between(ends, value - 1.96 * error, value + 1.96 * error, color=colour, alpha=0.2, linewidth=0.0)
        single = [np.nan if lines is None else lines[2 * side + row] for lines in alone]
        axes.plot(x, single, mark, color=colour, markerfacecolor="white", markersize=5, linestyle="none", label=f"{label}, each loop")
    ylabel = "slope of the asymptotes (N/m)" if which == "slope" else f"level at {1e3 * fit.centre_m:.0f} mm (N)"
    axes.set(xlabel=_ABSCISSA[abscissa], ylabel=ylabel, title=f"{which}s, order {rate.order}")
    axes.locator_params(axis="x", nbins=6)
    axes.ticklabel_format(axis="y", useOffset=False)
    return axes


def polynomials_as_text(fit: ActuatorFit) -> tuple[str, list[str]]:
    """A title, and the lines of a table: each line of the law at the lowest, the middle and the highest rate, and its coefficients."""
    rate = fit.fit.problem.rate
    if rate.abscissa == "none":
        return "the law is one for all rates: --rate frequency or --rate speed lets the asymptotes follow one", []
    unit = "Hz" if rate.abscissa == "frequency_Hz" else "m/s"
    at = rate.middle + rate.half * np.array([-1.0, 0.0, 1.0])
    errors, made = polynomial_errors_of(fit), fit.polynomials()
    lines = [" " * 10 + "".join(f"{f'at {one:.3g} {unit}':>20}" for one in at)]
    for line, (name, of) in enumerate(zip(errors, _UNITS, strict=True)):
        values = [with_error(float(v), float(e)) for v, e in zip(*line_at(fit, line, at), strict=True)]
        lines.append(f"{name:<4}{of:<6}" + "".join(f"{text:>20}" for text in values))
    lines += [
        "",
        " " * 10
        + "".join(f"{head:>20}" for head in ("constant", f"per {unit}", "per Hz²" if unit == "Hz" else "per (m/s)²")[: rate.order + 1]),
    ]
    for name, of in zip(errors, _UNITS, strict=True):
        coefficients = [with_error(c, e) for c, e in zip(made[name], errors[name], strict=True)]
        lines.append(f"{name:<4}{of:<6}" + "".join(f"{text:>20}" for text in coefficients))
    return "lines of the law at three rates, and their coefficients, with standard errors", lines


def line_alone(fit: ActuatorFit, k: int, data: LoopData) -> Array | None:
    """Slope and level in the middle, lower then upper, of one loop by itself, the forces of effects taken out of it."""
    lines, centre = fit.lines_of(k), fit.centre_m
    without = free_start(lines, data)[1] - (free_start(lines, data, fit.effects)[1] if fit.effects else free_start(lines, data)[1])
    straight = straight_lines([replace(data, force_N=corrected_force(fit, k) + without)])
    if straight is None or (1.0 - STRAIGHT_FROM) * 2.0 * data.amplitude_m * lines[4] < _STRAIGHT:
        return None
    a_l, b_l, a_u, b_u, _ = shifted(straight, float(lines[4]))
    return np.array([a_l, b_l + a_l * centre, a_u, b_u + a_u * centre])


def stiffness_against(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData], which: str) -> Any:
    """Effective stiffness, inertia force subtracted, against frequency or amplitude (Aridon 2009, eq. (5), Fig. 13).

    Against the frequency, loops of one stroke are joined: level means dry friction.
    """
    amplitude = which == "amplitude"
    for place, group in enumerate(strokes([data for data in loops if data.cycles.spans])):
        group = sorted(group, key=lambda data: data.frequency_Hz)
        x = [1e3 * data.amplitude_m if amplitude else data.frequency_Hz for data in group]
        values = [stiffness_of_cycles(data, fit.effects) for data in group]
        mark, colour = _MARKS[place % len(_MARKS)], COLOURS[place % len(COLOURS)]
        middle, spread = [np.median(v) for v in values], [np.std(v) for v in values]
        label = f"stroke {2e3 * group[0].amplitude_m:.3g} mm"
        axes.errorbar(x, middle, yerr=spread, fmt=mark, color=colour, markerfacecolor="white", markersize=5, capsize=2, label=label)
        if not amplitude:
            axes.plot(x, middle, "-", color=colour, linewidth=0.8)
    label = "amplitude (mm)" if amplitude else "frequency (Hz)"
    tail = ", inertia subtracted" if any(effect.leg_mass is not None for effect in fit.effects) else ""
    axes.set(xlabel=label, ylabel=f"effective stiffness{tail} (N/m)", title=f"effective stiffness by {which}")
    axes.set_ylim(0.0, 1.15 * axes.get_ylim()[1])
    axes.locator_params(axis="x", nbins=5)
    if axes.get_legend_handles_labels()[0] and not amplitude:
        axes.legend(fontsize="x-small")
    return axes


def level_against_elongation(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData]) -> Any:
    """Mean of both branches against the unrolled length, and from where on it is straight (Aridon 2009, section 3.2)."""
    level = transition_of(fit, loops)
    u = 1e3 * level.elongation_m
    axes.errorbar(
        u,
        level.level_N,
        yerr=1.96 * level.stderr_N,
        fmt="o",
        color=COLOURS[0],
        markersize=3,
        capsize=2,
        label="mean of both branches, 95 %",
    )
    if np.all(np.isfinite(level.departure_N)) and len(u):
        axes.plot(u, level.level_N - level.departure_N, "k--", linewidth=0.8, label="line of the longest third")
        axes.axvline(1e3 * level.complete_from_m, color="0.5", linewidth=0.8, linestyle=":", label="straight from here on")
    axes.set(xlabel="elongation (mm)", ylabel="force level (N)", title="transition zone: level by unrolled length")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize="x-small")
    return axes


def profile_of_beta(axes: Any, fit: ActuatorFit, profile: ProfileCurve) -> Any:
    """Rise of the misfit along beta; where it stays below 3.84 beta is in the 95 % interval."""
    axes.plot(profile.values, profile.rise, ".-", color=COLOURS[0], label="everything else fitted again")
    if profile.values[-1] > 5.0 * profile.values[0]:
        axes.set_xscale("log", subs=(2, 5))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter("{x:g}")
    low, high = fit.estimates["beta_per_m"].ci95
    axes.axvspan(low, high, color="0.85", label="95 %, covariance")
    axes.axhline(3.84, color="black", linewidth=0.6, linestyle="--", label="95 %, one parameter")
    axes.set(xlabel="beta (1/m)", ylabel="rise of the misfit", ylim=(0.0, 16.0), title="profile of beta")
    axes.legend(fontsize="x-small", loc="upper center", frameon=True, framealpha=1.0)
    return axes
