"""Figures of the forward problem: axes in, axes out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from measure.common.arrays import Array
from measure.common.figure_plots import save_figure
from simulate.deployment.result import Deployment

if TYPE_CHECKING:
    from simulate.deployment.gravity_study import Case
    from simulate.sweeps.result import SweepResult

_DEGREES = ("theta_x_rad", "theta_y_rad", "theta_z_rad")
_LINE_COLOURS = ("#1b5e8a", "#c2571a", "#3f7d3a", "#8a3b7a", "#6b6b6b", "#b08c00")


def draw_positions(axes: Any, run: Deployment) -> Any:
    """Elevation and lateral deviations against time, mm (Aridon 2009, Fig. 16)."""
    lateral = axes.twinx()
    lines = [*axes.plot(run.time_s, 1e3 * run.channels["z_m"], color="black", label="elevation z")]
    for name, colour in zip(("x_m", "y_m"), _LINE_COLOURS, strict=False):
        lines += lateral.plot(run.time_s, 1e3 * run.channels[name], color=colour, lw=1, label=f"lateral {name[0]}")
    axes.set_ylabel("elevation, mm")
    lateral.set_ylabel("lateral, mm")
    _spread_small(lateral, 1.0)
    _legend_above(axes, lines)
    return axes


def draw_rotations(axes: Any, run: Deployment) -> Any:
    """The three rotations against time, degrees (Fig. 17)."""
    for name, colour in zip(_DEGREES, (*_LINE_COLOURS[:2], "black"), strict=True):
        axes.plot(run.time_s, np.degrees(run.channels[name]), color=colour, lw=1, label=name.removesuffix("_rad"))
    axes.set_ylabel("rotation, deg")
    _spread_small(axes, 1.0)
    _legend_above(axes, axes.get_lines())
    return axes


def draw_leg_forces(axes: Any, run: Deployment) -> Any:
    """Force of each leg against time, N; beyond the stops it pulls."""
    for leg, colour in enumerate(_LINE_COLOURS):
        axes.plot(run.time_s, run.leg_force_N[:, leg], color=colour, lw=0.8, label=f"leg {leg + 1}")
    axes.set(xlabel="time, s", ylabel="leg force, N")
    _legend_above(axes, axes.get_lines())
    return axes


def deployment_figure(run: Deployment) -> Any:
    """Positions, rotations and leg forces of one deployment, one above the other."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 8.5), layout="constrained")
    figure.suptitle(run.model.name)
    axes = figure.subplots(3, 1, sharex=True)
    for draw, at in zip((draw_positions, draw_rotations, draw_leg_forces), axes, strict=True):
        draw(at, run)
    return figure


def gravity_figure(cases: Sequence[Case]) -> Any:
    """Elevation of every case against time, with the force as it is dashed and with four times it drawn through (Fig. 16)."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 4.5), layout="constrained")
    axes = figure.subplots()
    for case, colour in zip(cases, _LINE_COLOURS[:3] * 2, strict=True):
        style = "--" if case.times_the_force == 1 else "-"
        axes.plot(case.run.time_s, 1e3 * case.run.channels["z_m"], style, color=colour, lw=1.2, label=case.label)
    geometry = cases[0].run.model.geometry
    for height in () if geometry is None else (geometry.stowed_height_m, geometry.deployed_height_m):
        axes.axhline(1e3 * height, color="black", lw=0.5)
    axes.set(xlabel="time, s", ylabel="elevation, mm", title=cases[0].run.model.name)
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def draw_coefficients(axes: Any, coefficients: Mapping[str, float], unit: str, most: int = 30) -> Any:
    """The largest coefficients of a regression as bars, in their order of size (the constant is left out)."""
    named = sorted(((name, value) for name, value in coefficients.items() if name != "1"), key=lambda item: -abs(item[1]))[:most]
    names, values = [name for name, _ in named], [value for _, value in named]
    axes.bar(range(len(names)), values, color=[_LINE_COLOURS[0] if value > 0 else _LINE_COLOURS[1] for value in values])
    axes.set_xticks(range(len(names)), names, rotation=90)
    axes.axhline(0.0, color="black", lw=0.6)
    axes.set_xlim(-0.8, len(names) - 0.2)
    axes.set(ylabel=f"coefficient, {unit}", title=f"the {len(names)} largest of {len(coefficients) - 1} coefficients")
    return axes


def draw_responses(axes: Any, counts: Array, edges: Array, unit: str, limit: float | None = None) -> Any:
    """How the responses of a sweep are spread, (bins,) runs between (bins + 1,) edges; the limit of a failure as two lines."""
    axes.stairs(counts, edges, fill=True, color=_LINE_COLOURS[0])
    for edge in () if limit is None else (-limit, limit):
        axes.axvline(edge, color=_LINE_COLOURS[1], lw=1)
    axes.set(xlabel=f"response, {unit}", ylabel="runs", title=f"{int(np.sum(counts))} runs")
    return axes


def draw_map(axes: Any, values: Array, letters: tuple[str, str], unit: str) -> Any:
    """A response over the coded levels of two factors, the first upwards; the sign by colour, as of a rotation."""
    most = float(np.nanmax(np.abs(values), initial=0.0)) or 1.0
    levels = np.linspace(-1.0, 1.0, len(values))
    shown = axes.pcolormesh(levels, levels, values, cmap="RdBu_r", vmin=-most, vmax=most, shading="nearest")
    lines = axes.contour(levels, levels, np.nan_to_num(values), levels=8, colors="black", linewidths=0.5)
    axes.clabel(lines, fontsize=6, fmt="%g")
    axes.figure.colorbar(shown, ax=axes, label=unit)
    axes.set(xlabel=f"{letters[1]}, coded", ylabel=f"{letters[0]}, coded", title="response over two factors")
    return axes


def draw_tolerance(axes: Any, curve: Sequence[Mapping[str, float]], slope: Array, probability: float) -> Any:
    """Angle that a spread of the stored forces keeps, simulated, and the straight line of the slopes."""
    from scipy.stats import norm

    spreads = np.array([point["spread_N"] for point in curve])
    straight = float(norm.ppf((1 + probability) / 2)) * float(np.linalg.norm(slope)) * spreads
    axes.plot(1e3 * spreads, straight, color=_LINE_COLOURS[4], lw=1, label="by the slopes")
    axes.plot(1e3 * spreads, [point["angle_deg"] for point in curve], "o-", color=_LINE_COLOURS[0], ms=4, label="simulated")
    axes.set(xlabel="spread of the stored forces, mN (one sd)", ylabel="abs(theta_z), deg")
    axes.set_title(f"kept in {100 * probability:g} % of the runs")
    axes.set(xlim=(0.0, None), ylim=(0.0, None))
    axes.grid(lw=0.3)
    axes.legend(frameon=False)
    return axes


def sweep_figure(result: SweepResult, tolerance: Mapping[str, Any]) -> Any:
    """Coefficients above; below them responses, the response over the two largest factors, and the tolerance curve."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 8.0), layout="constrained")
    halves: Any = figure.subfigures(2, 1)
    upper, lower = halves
    draw_coefficients(upper.subplots(), result.coefficients, result.unit)
    panels: Any = lower.subplots(1, 3)
    spread, pair, curve = panels
    draw_responses(spread, *result.histogram(), result.unit, result.limit)
    places = result.largest_pair
    if places is None:
        pair.set_axis_off()
    else:
        draw_map(pair, result.map(*places), (result.letters[places[0]], result.letters[places[1]]), result.unit)
    if tolerance["curve"]:
        draw_tolerance(curve, tolerance["curve"], tolerance["slope_deg_per_N"], tolerance["probability"])
    else:
        curve.set_axis_off()
    return figure


def result_figure(result: SweepResult) -> Any:
    """The largest coefficients of a sweep and how its responses are spread, small."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_coefficients(left, result.coefficients, result.unit, 12)
    draw_responses(right, *result.histogram(), result.unit, result.limit)
    return figure


def figure_bytes(figure: Any, kind: str = "png") -> bytes:
    """A figure as the bytes of a file; the same figure gives the same bytes."""
    import io

    buffer = io.BytesIO()
    save_figure(figure, buffer, kind, dpi=130)
    return buffer.getvalue()


def _spread_small(axes: Any, least: float) -> None:
    """Keep an axis from blowing up rounding: it shows at least `least` units."""
    low, high = axes.get_ylim()
    if high - low < least:
        middle = (low + high) / 2
        axes.set_ylim(middle - least / 2, middle + least / 2)


def _legend_above(axes: Any, lines: Sequence[Any]) -> None:
    """A legend outside the axes, where no curve can run through it."""
    labels = [line.get_label() for line in lines]
    axes.legend(lines, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(labels), frameon=False)
