"""Figures of the platform's motion: axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from measure.film.dispersion import Dispersion
    from measure.tables.trajectory import Trajectory

_LABELS = {
    "x_m": ("lateral x", "mm", 1e3),
    "y_m": ("depth y", "mm", 1e3),
    "z_m": ("elevation z", "mm", 1e3),
    "theta_x_rad": ("theta_x", "deg", 180 / np.pi),
    "theta_y_rad": ("roll theta_y", "deg", 180 / np.pi),
    "theta_z_rad": ("theta_z", "deg", 180 / np.pi),
}


def draw_trajectory(axes: Sequence[Axes], trajectory: Trajectory) -> Sequence[Axes]:
    """Draw every channel against time with a band of two standard deviations.

    Parameters
    ----------
    axes : sequence of Axes
        One for each channel.
    trajectory : Trajectory

    Returns
    -------
    The axes.
    """
    for ax, (channel, values) in zip(axes, trajectory.channels.items(), strict=True):
        name, unit, factor = _LABELS[channel]
        ax.plot(trajectory.time_s, factor * values, lw=1.2, color="C0")
        if channel in trajectory.sigma:
            band = 2 * trajectory.sigma[channel]
            ax.fill_between(trajectory.time_s, factor * (values - band), factor * (values + band), color="C0", alpha=0.3, lw=0)
            sigma = factor * np.nanmedian(trajectory.sigma[channel])
            ax.set_title(f"band: two sigma, median sigma {sigma:.2g} {unit}", fontsize=8, loc="right")
        ax.set_ylabel(f"{name}, {unit}")
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("time, s")
    return axes


def draw_dispersion(axes: Sequence[Axes], trajectory: Trajectory, compared: Sequence[Dispersion]) -> Sequence[Axes]:
    """Draw films over each other, all on the first one's clock, and below each channel their difference.

    Parameters
    ----------
    axes : sequence of Axes
        Two for each channel that another film shares.
    trajectory : Trajectory
        The first film.
    compared : sequence of Dispersion
        The others.

    Returns
    -------
    The axes.
    """
    shared = [channel for channel in trajectory.channels if any(channel in other.channels for other in compared)]
    for k, channel in enumerate(shared):
        name, unit, factor = _LABELS[channel]
        both, gap = axes[2 * k], axes[2 * k + 1]
        both.plot(trajectory.time_s, factor * trajectory.channels[channel], lw=1.2, color="C0", label="this film")
        for n, other in enumerate(o for o in compared if channel in o.channels):
            _draw_other(both, gap, other, channel, factor, f"C{n + 1}")
        both.set_ylabel(f"{name}, {unit}")
        gap.set_ylabel(f"difference, {unit}")
        both.legend(fontsize=7)
    for ax in axes:
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("time, s")
    return axes


def _draw_other(both: Axes, gap: Axes, other: Dispersion, channel: str, factor: float, colour: str) -> None:
    difference, table = other.channels[channel], other.other
    both.plot(table.time_s - other.shift_s, factor * table.channels[channel], "--", lw=1, color=colour, label=other.name)
    gap.plot(difference.time_s, factor * difference.values, lw=1, color=colour)
    band = 2 * factor * difference.sigma
    gap.fill_between(difference.time_s, -band, band, color=colour, alpha=0.2, lw=0)
