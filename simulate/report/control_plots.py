"""Figure of a designed controller: what the platform does before and after, what the brakes do, and what they take out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from measure.common.arrays import Array
from simulate.deployment.result import Deployment

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BEFORE, _AFTER, _LIMIT = "#c2571a", "#1b5e8a", "#6b6b6b"


def control_figure(before: Sequence[Deployment], after: Sequence[Deployment], angles_deg: Sequence[float]) -> Figure:
    """Fans of theta_z without and with control, force of the actuators and energy taken out, of the same draws."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 6.5), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True)
    draw_fan(axes[0, 0], before, angles_deg, _BEFORE, "without control")
    draw_fan(axes[0, 1], after, angles_deg, _AFTER, "with control")
    draw_bands(
        axes[1, 0], after[0].time_s, [np.max(np.abs(run.control_force_N), axis=1) for run in after], "largest force of an actuator, N"
    )
    draw_bands(axes[1, 1], after[0].time_s, [-run.effects_J["controller"] for run in after], "energy taken out, J")
    for one in axes[1]:
        one.set_xlabel("time, s")
    return figure


def draw_fan(axes: Any, runs: Sequence[Deployment], angles_deg: Sequence[float], colour: str, title: str) -> Any:
    """theta_z of every run against time, deg, and the angles to stay below."""
    for run in runs:
        axes.plot(run.time_s, np.degrees(run.channels["theta_z_rad"]), color=colour, lw=0.7, alpha=0.6)
    for angle in angles_deg:
        for side in (-angle, angle):
            axes.axhline(side, color=_LIMIT, lw=0.8, ls="--")
    axes.set(title=f"{title}, {len(runs)} draws", ylabel="theta_z, deg")
    return axes


def draw_bands(axes: Any, time_s: Array, values: Sequence[Array], label: str) -> Any:
    """Median and range of a quantity over the runs against time."""
    stacked = np.array(values)
    axes.fill_between(time_s, stacked.min(axis=0), stacked.max(axis=0), color=_AFTER, alpha=0.2, lw=0)
    axes.plot(time_s, np.median(stacked, axis=0), color=_AFTER, lw=1.2)
    axes.set_ylabel(label)
    return axes
