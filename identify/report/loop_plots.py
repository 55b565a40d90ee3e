"""Loops with their law, side by side, and what is left; axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identify.actuator.actuator_fit import ActuatorFit, corrected_force
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array
from measure.common.figure_plots import COLOURS

STYLES = ("-", "--", "-.", ":")
_BINS, _MOST_DOTS, _MOST_LOOPS, _WIDEST = 24, 400, 6, 4.0
_QUIET = "0.35"
RESIDUAL_AXES = {
    "elongation": (1e3, "elongation (mm)", "elongation_m"),
    "speed": (1e3, "speed (mm/s)", "speed_m_per_s"),
    "acceleration": (1.0, "acceleration (m/s²)", "acceleration_m_per_s2"),
    "time": (1.0, "time (s)", "time_s"),
}


def some_loops(loops: Sequence[LoopData]) -> list[int]:
    """Places of at most six loops, from the slowest to the fastest and from the shortest to the longest."""
    order = sorted(
        range(len(loops)), key=lambda k: (float(np.nan_to_num(loops[k].frequency_Hz)), float(np.nan_to_num(loops[k].amplitude_m)))
    )
    places = np.unique(np.rint(np.linspace(0, len(order) - 1, min(len(order), _MOST_LOOPS))).astype(int))
    return [order[place] for place in places]


def last_cycle(data: LoopData) -> NDArray[np.intp]:
    """Places of the last full cycle's samples that count, or of all that do."""
    a, b = data.cycles.spans[-1] if data.cycles.spans else (0, len(data.time_s))
    places = np.arange(a, b)
    kept = places[data.used[places]]
    return kept if len(kept) else np.flatnonzero(data.used)


def name_of(data: LoopData) -> str:
    """Frequency and stroke of a loop; of one without a full cycle the file."""
    if not np.isfinite(data.frequency_Hz):
        return Path(data.name).name
    return f"{data.frequency_Hz:.3g} Hz, stroke {2e3 * data.amplitude_m:.3g} mm"


def names_of(loops: Sequence[LoopData], chosen: Sequence[int]) -> list[str]:
    """A name for each of these loops; the file stands with those that are alike otherwise."""
    names = [name_of(loops[k]) for k in chosen]
    return [f"{name}, {Path(loops[k].name).name}" if names.count(name) > 1 else name for name, k in zip(names, chosen, strict=True)]


def in_newtons(values: Array) -> tuple[float, str]:
    """Factor and unit in which forces of this size are written without leading zeros."""
    size = float(np.max(np.abs(values), initial=0.0))
    return (1e3, "mN") if size < 0.1 else (1.0, "N") if size < 1e4 else (1e-3, "kN")


def loops_and_law(axes: Any, fit: ActuatorFit, chosen: Sequence[int]) -> Any:
    """Last full cycles of some loops, measured and modelled, with the asymptotes of the law alone (Aridon 2009, Fig. 10).

    Measured forces are those at the mean of a covariate, and on one level. Asymptotes that follow a rate are drawn in its middle.
    """
    ends = np.array([min(fit.loops[k].elongation_m.min() for k in chosen), max(fit.loops[k].elongation_m.max() for k in chosen)])
    for place, (k, name) in enumerate(zip(chosen, names_of(fit.loops, chosen), strict=True)):
        _dots(axes, fit, k, COLOURS[place % len(COLOURS)], name)
    for k in chosen:
        _law(axes, fit, k, "law" if k == chosen[0] else None)
    a_l, b_l, a_u, b_u, _ = fit.lines
    alone = asymptotes_are(fit)
    axes.plot(1e3 * ends, a_u * ends + b_u, "-.", color=_QUIET, linewidth=1.2, label=f"upper asymptote{alone}")
    axes.plot(1e3 * ends, a_l * ends + b_l, "--", color=_QUIET, linewidth=1.2, label=f"lower asymptote{alone}")
    axes.set(xlabel="elongation (mm)", ylabel="force (N)")
    _room_above(axes, len(chosen) + 3)
    return axes


def _dots(axes: Any, fit: ActuatorFit, k: int, colour: str, name: str) -> None:
    """The last full cycle as measured, thinned."""
    kept = last_cycle(fit.loops[k])
    kept = kept[:: max(1, len(kept) // _MOST_DOTS)]
    axes.plot(1e3 * fit.loops[k].elongation_m[kept], corrected_force(fit, k)[kept], ".", markersize=3.0, color=colour, label=name)


def _law(axes: Any, fit: ActuatorFit, k: int, name: str | None) -> None:
    """The last full cycle as modelled."""
    kept, left = last_cycle(fit.loops[k]), np.full(len(fit.loops[k].force_N), np.nan)
    left[fit.loops[k].used] = fit.residuals[k]
    force = corrected_force(fit, k)[kept] - left[kept]
    axes.plot(1e3 * fit.loops[k].elongation_m[kept], force, color="black", linewidth=1.0, label=name)


def asymptotes_are(fit: ActuatorFit) -> str:
    """What the asymptotes in a figure are those of."""
    rate, alone = fit.fit.problem.rate, " of the law alone" if fit.effects else ""
    if rate.abscissa == "none" or rate.order == 0:
        return alone
    middle = f"{rate.middle:.3g} Hz" if rate.abscissa == "frequency_Hz" else f"{1e3 * rate.middle:.3g} mm/s"
    return f"{alone} at {middle}"


def _room_above(axes: Any, entries: int, columns: int = 2) -> None:
    """A legend above the curves, with room for it."""
    low, high = axes.get_ylim()
    rows = -(-entries // columns)
    axes.set_ylim(low, high + (high - low) * (0.05 + 0.05 * rows))
    axes.legend(loc="upper center", ncols=columns, fontsize="x-small")


def residual_against(axes: Any, fit: ActuatorFit, quantity: str) -> Any:
    """Measured minus modelled force of all loops against a quantity, its mean, and the noise of the samples."""
    scale, label, column = RESIDUAL_AXES[quantity]
    x = [scale * (getattr(d, column)[d.used] - (d.time_s[0] if quantity == "time" else 0.0)) for d in fit.loops]
    every, left = np.concatenate(x), np.concatenate(fit.residuals)
    factor, unit = in_newtons(left)
    noise = factor * float(np.sqrt(np.mean([d.force_sigma_N**2 for d in fit.loops])))
    few = slice(None, None, max(1, len(every) // (10 * _MOST_DOTS)))
    axes.plot(
        every[few], factor * left[few], ".", markersize=2.0, color=COLOURS[0], alpha=0.4, rasterized=True, label="samples of all loops"
    )
    axes.axhspan(-2.0 * noise, 2.0 * noise, color="0.85", zorder=0, label="noise of a sample, 2 sigma")
    middle, mean = binned(every, factor * left)
    axes.plot(middle, mean, "o-", color="black", markersize=3.0, linewidth=1.2, label="mean")
    axes.axhline(0.0, color="black", linewidth=0.6)
    _without_far_off(axes, factor * left)
    share = fit.left.shares.get(quantity, 0.0)
    axes.set(xlabel=label, ylabel=f"measured minus modelled ({unit})", title=f"{quantity} explains {100 * share:.0f} % of it")
    return axes


def _without_far_off(axes: Any, left: Array) -> None:
    """Limits that a few samples far off do not set; how many lie beyond is said."""
    most = _WIDEST * float(np.quantile(np.abs(left), 0.95))
    beyond = int(np.count_nonzero(np.abs(left) > most))
    if most > 0.0 and beyond:
        axes.set_ylim(-1.05 * most, 1.05 * most)
        axes.text(0.01, 0.01, f"{beyond} samples beyond", fontsize="x-small", transform=axes.transAxes)


def binned(x: Array, y: Array) -> tuple[Array, Array]:
    """Means of x and y, (<= 24,), over parts of x with about as many samples each."""
    edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, _BINS + 1)))
    place = np.searchsorted(edges[1:-1], x)
    count = np.bincount(place, minlength=max(len(edges) - 1, 1))
    sums = [np.bincount(place, values, minlength=len(count)) for values in (x, y)]
    kept = count > 0
    return sums[0][kept] / count[kept], sums[1][kept] / count[kept]


def loops_side_by_side(axes: Any, fit: ActuatorFit, chosen: Sequence[int], title: str, *, corrected: bool = True) -> Any:
    """Last full cycles of these loops (Aridon 2009, Figs. 7 and 8 by elongation, 11 by frequency), corrected or as measured."""
    for place, (k, name) in enumerate(zip(chosen, names_of(fit.loops, chosen), strict=True)):
        kept = last_cycle(fit.loops[k])
        force = corrected_force(fit, k) if corrected else fit.loops[k].force_N
        colour, style = COLOURS[place % len(COLOURS)], STYLES[place // len(COLOURS) % len(STYLES)]
        axes.plot(1e3 * fit.loops[k].elongation_m[kept], force[kept], style, color=colour, linewidth=1.2, label=name)
    axes.set(xlabel="elongation (mm)", ylabel="force (N)", title=title)
    if len(chosen) <= 2 * len(COLOURS):
        _room_above(axes, len(chosen))
    return axes


def loop_and_law(axes: Any, fit: ActuatorFit, which: int) -> Any:
    """One loop, measured and modelled, and how well it is met."""
    data = fit.loops[which]
    _dots(axes, fit, which, COLOURS[0], "measured")
    _law(axes, fit, which, "law")
    error = 100.0 * float(np.sqrt(np.mean(fit.residuals[which] ** 2))) / data.force_range_N
    axes.set(xlabel="elongation (mm)", ylabel="force (N)")
    axes.set_title(f"{name_of(data)}\nerror {error:.2g} % of its range", fontsize="small")
    return axes


def fit_figure(fit: ActuatorFit, loops: Sequence[LoopData]) -> Any:
    """The slowest and the fastest loop, measured and modelled, small."""
    from matplotlib.figure import Figure

    order = np.argsort([np.nan_to_num(d.frequency_Hz) for d in loops], kind="stable")
    chosen = list(dict.fromkeys((int(order[0]), int(order[-1]))))
    figure = Figure(figsize=(4.5 * len(chosen), 3.2), layout="constrained")
    for axes, k in zip(figure.subplots(1, len(chosen), squeeze=False)[0], chosen, strict=True):
        loops_and_law(axes, fit, [k]).set_title(f"measured and modelled, {name_of(fit.loops[k])}")
    return figure
