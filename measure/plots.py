"""Figures of the film side: axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .tables import Trajectory

_LABELS = {
    "x_m": ("lateral x", "mm", 1e3),
    "y_m": ("depth y", "mm", 1e3),
    "z_m": ("elevation z", "mm", 1e3),
    "theta_x_rad": ("theta_x", "deg", 180 / np.pi),
    "theta_y_rad": ("roll theta_y", "deg", 180 / np.pi),
    "theta_z_rad": ("theta_z", "deg", 180 / np.pi),
}


def draw_trajectory(axes: Sequence[Axes], trajectory: Trajectory) -> Sequence[Axes]:
    """Every channel against time with a band of two standard deviations, one channel an axes."""
    for ax, (channel, values) in zip(axes, trajectory.channels.items(), strict=True):
        name, unit, factor = _LABELS[channel]
        ax.plot(trajectory.time_s, factor * values, lw=1.2, color="C0")
        if channel in trajectory.sigma:
            band = 2 * trajectory.sigma[channel]
            ax.fill_between(trajectory.time_s, factor * (values - band), factor * (values + band), color="C0", alpha=0.3, lw=0)
            ax.set_title(
                f"band: two sigma, median sigma {factor * np.nanmedian(trajectory.sigma[channel]):.2g} {unit}", fontsize=8, loc="right"
            )
        ax.set_ylabel(f"{name}, {unit}")
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("time, s")
    return axes
