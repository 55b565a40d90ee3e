"""Figures of loops: axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from .actuator import ActuatorFit
from .loops import LoopData
from .resampling import Profile
from .stiffness import stiffness_of_cycles


def loop_and_model(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData], which: int = 0) -> Any:
    """One loop measured and modelled, with its asymptotes (Aridon 2009, Fig. 10)."""
    data = loops[which]
    u, force = 1e3 * data.elongation_m[data.used], data.force_N[data.used] - fit.tares_N[which]
    axes.plot(u, force, color="0.65", linewidth=0.8, label="measured")
    axes.plot(u, force - fit.residuals[which], color="black", linewidth=0.8, label="modelled")
    a_l, b_l, a_u, b_u, _ = fit.lines_of(which)
    ends = np.array([u.min(), u.max()])
    axes.plot(ends, a_l * ends / 1e3 + b_l, "k--", linewidth=0.8, label="lower asymptote")
    axes.plot(ends, a_u * ends / 1e3 + b_u, "k:", linewidth=1.0, label="upper asymptote")
    axes.set(xlabel="elongation (mm)", ylabel="force (N)", title=f"{data.frequency_Hz:.3g} Hz, {1e3 * data.amplitude_m:.3g} mm")
    axes.legend(fontsize="small")
    return axes


def residual_against(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData], quantity: str) -> Any:
    """Measured minus modelled force of all loops against elongation, speed, acceleration or time."""
    scale, label, column = {
        "elongation": (1e3, "elongation (mm)", "elongation_m"),
        "speed": (1e3, "speed (mm/s)", "speed_m_per_s"),
        "acceleration": (1.0, "acceleration (m/s$^2$)", "acceleration_m_per_s2"),
        "time": (1.0, "time (s)", "time_s"),
    }[quantity]
    for k, (data, left) in enumerate(zip(loops, fit.residuals, strict=True)):
        axes.plot(scale * getattr(data, column)[data.used], left, ",", color=str(0.7 * k / max(len(loops), 2)))
    axes.axhline(0.0, color="black", linewidth=0.5)
    axes.set(xlabel=label, ylabel="measured - modelled (N)")
    return axes


def all_loops(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData]) -> Any:
    """The last full cycle of every loop as measured, by frequency (Aridon 2009, Figs. 7, 8, 11)."""
    for k, data in enumerate(loops):
        a, b = data.cycles.spans[-1] if data.cycles.spans else (0, len(data.time_s))
        label = f"{data.frequency_Hz:.3g} Hz, {1e3 * data.amplitude_m:.3g} mm"
        shade, style = str(0.75 * k / max(len(loops), 2)), ("-", "--", "-.", ":")[k % 4]
        axes.plot(1e3 * data.elongation_m[a:b], data.force_N[a:b] - fit.tares_N[k], style, color=shade, linewidth=0.8, label=label)
    axes.set(xlabel="elongation (mm)", ylabel="force (N)", title="last full cycles, measured")
    if len(loops) <= 10:
        axes.legend(fontsize="xx-small")
    return axes


def stiffness_against_frequency(axes: Any, fit: ActuatorFit, loops: Sequence[LoopData]) -> Any:
    """Effective stiffness with the inertia force subtracted (Aridon 2009, eq. (5), Fig. 13); amplitude in mm beside each mark."""
    for data in loops:
        values = stiffness_of_cycles(data, fit.effects)
        if len(values):
            axes.errorbar(data.frequency_Hz, np.median(values), yerr=np.std(values), fmt="ko", markersize=3, capsize=2)
            axes.annotate(f" {1e3 * data.amplitude_m:.3g}", (data.frequency_Hz, np.median(values)), fontsize="xx-small")
    axes.set(xlabel="frequency (Hz)", ylabel="effective stiffness (N/m)", title="amplitude in mm beside the marks", ylim=(0.0, None))
    return axes


def levels_against_rate(axes: Any, fit: ActuatorFit) -> Any:
    """Level of both asymptotes in the middle of the elongations against the abscissa, with 95 % band (Aridon 2009, Fig. 12)."""
    shape = fit.layout
    z = np.linspace(-1.0, 1.0, 60)
    powers = z[:, None] ** np.arange(shape.order + 1)
    for row, style, label in ((1, "k--", "lower asymptote"), (3, "k:", "upper asymptote")):
        part = slice(row * (shape.order + 1), (row + 1) * (shape.order + 1))
        level = powers @ fit.theta[part]
        band = 1.96 * np.sqrt(np.einsum("ij,jk,ik->i", powers, fit.theta_covariance[part, part], powers))
        x = shape.middle + shape.half * z
        axes.plot(x, level, style, label=label)
        axes.fill_between(x, level - band, level + band, color="0.8")
    label = "frequency (Hz)" if shape.abscissa == "frequency_Hz" else "mid-stroke speed (m/s)"
    axes.set(xlabel=label, ylabel="level in the middle (N)", title=f"polynomials of order {shape.order}")
    axes.legend(fontsize="small")
    return axes


def parameters_as_text(axes: Any, fit: ActuatorFit) -> Any:
    """The fitted numbers with their intervals, where no rate is fitted."""
    axes.axis("off")
    rows = [f"{name}\n    {e.value:.5g}   ({e.ci95[0]:.5g} to {e.ci95[1]:.5g})  {e.verdict}" for name, e in fit.estimates.items()]
    axes.text(0.0, 1.0, "\n".join(rows), va="top", fontsize="small", family="monospace", transform=axes.transAxes)
    axes.set_title("parameters, 95 % intervals")
    return axes


def profile_of_beta(axes: Any, fit: ActuatorFit, profile: Profile | None) -> Any:
    """Rise of the misfit along beta; where it stays below 3.84 beta is in the 95 % interval."""
    if profile is None:
        axes.axis("off")
        return axes
    axes.plot(profile.beta_per_m, profile.rise, "k.-", label="profile")
    axes.set_xscale("log" if profile.beta_per_m[-1] > 5.0 * profile.beta_per_m[0] else "linear")
    low, high = fit.estimates["beta_per_m"].ci95
    axes.axvspan(low, high, color="0.85", label="95 %, covariance")
    axes.axhline(3.84, color="black", linewidth=0.6, linestyle="--")
    axes.set(xlabel="beta (1/m)", ylabel="rise of the misfit", ylim=(0.0, 16.0))
    axes.legend(fontsize="small")
    return axes


def page(fit: ActuatorFit, loops: Sequence[LoopData], title: str, profile: Profile | None = None) -> Any:
    """One page: loops and model, what is left, and what follows the rate."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 10), layout="constrained")
    axes = figure.subplots(3, 3)
    order = np.argsort([np.nan_to_num(d.frequency_Hz) for d in loops])
    loop_and_model(axes[0, 0], fit, loops, int(order[0]))
    loop_and_model(axes[0, 1], fit, loops, int(order[-1]))
    all_loops(axes[0, 2], fit, loops)
    for column, quantity in enumerate(("elongation", "speed", "time")):
        residual_against(axes[1, column], fit, loops, quantity)
    stiffness_against_frequency(axes[2, 0], fit, loops)
    if fit.layout.abscissa == "none":
        parameters_as_text(axes[2, 1], fit)
    else:
        levels_against_rate(axes[2, 1], fit)
    profile_of_beta(axes[2, 2], fit, profile)
    figure.suptitle("\n".join(wrap(title, 130)), fontsize="medium")
    return figure


def save(figure: Any, path: Path) -> None:
    """Write a figure, whole or not at all; the ending of the name says what kind."""
    from measure.output import replacing

    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=150, metadata={"Software": None} if path.suffix == ".png" else None)
