"""Figures of loops: axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .actuator import ActuatorFit
from .loops import LoopData


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


def page(fit: ActuatorFit, loops: Sequence[LoopData], title: str) -> Any:
    """One page: the slowest and the fastest loop with the model, and the residual of all."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 7), layout="constrained")
    axes = figure.subplots(2, 2)
    order = np.argsort([np.nan_to_num(d.frequency_Hz) for d in loops])
    loop_and_model(axes[0, 0], fit, loops, int(order[0]))
    if len(loops) > 1:
        loop_and_model(axes[0, 1], fit, loops, int(order[-1]))
    else:
        residual_against(axes[0, 1], fit, loops, "time")
    residual_against(axes[1, 0], fit, loops, "elongation")
    residual_against(axes[1, 1], fit, loops, "speed")
    figure.suptitle(title, fontsize="medium")
    return figure


def save(figure: Any, path: Path) -> None:
    """Write a figure, whole or not at all; the ending of the name says what kind."""
    from measure.output import replacing

    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=150, metadata={"Software": None} if path.suffix == ".png" else None)
