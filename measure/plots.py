"""Figures of the film side: axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .footage import Picture
    from .marks import Marks
    from .platform import Fit
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


_STATUS_COLOURS = {"ok": "#1b9e77", "occluded": "#d95f02", "lost": "#e7298a", "ambiguous": "#7570b3", "out-of-frame": "#666666"}


def draw_frame(ax: Axes, picture: Picture, marks: Marks, frame: int, subset: int, *, names: bool = False) -> Axes:
    """One frame with the subsets that were found, and in words what became of the others."""
    ax.imshow(picture, cmap="gray", vmin=0, vmax=max(float(np.percentile(picture, 99.9)), 1.0), interpolation="nearest")
    for i, name in enumerate(marks.names):
        if marks.seen[frame, i]:
            x, y = marks.x_px[frame, i], marks.y_px[frame, i]
            half = subset / 2
            ax.plot(
                [x - half, x + half, x + half, x - half, x - half],
                [y - half, y - half, y + half, y + half, y - half],
                lw=0.9,
                color="#1b9e77",
            )
            if names:
                ax.annotate(name, (x, y - half), color="#1b9e77", ha="center", va="bottom", fontsize=8)
    words = [f"{name} {marks.status[frame, i]}" for i, name in enumerate(marks.names) if not marks.seen[frame, i]]
    ax.set_title(f"frame {frame}", fontsize=8)
    ax.set_xlabel("\n".join(words[:3]), fontsize=7, color="#d95f02")
    ax.set_xticks([])
    ax.set_yticks([])
    return ax


def draw_quality(axes: Sequence[Axes], marks: Marks, fit: Fit | None) -> Sequence[Axes]:
    """Per mark against the frame: correlation, sigma, distance from the rigid body, and what it was not seen for."""
    frames = np.arange(len(marks.time_s))
    for i, name in enumerate(marks.names):
        axes[0].plot(frames, marks.zncc[:, i], lw=1, label=name)
        axes[1].semilogy(frames, marks.sigma_px[:, i], lw=1)
        if fit is not None:
            axes[2].plot(frames, np.hypot(*fit.residual_px[:, i].T), lw=1)
        for status, colour in _STATUS_COLOURS.items():
            at = frames[marks.status[:, i] == status]
            axes[3].plot(at, np.full(len(at), i), ".", ms=3, color=colour)
    for status, colour in _STATUS_COLOURS.items():
        if (marks.status == status).any():
            axes[3].plot([], [], ".", color=colour, label=status)
    axes[3].set_yticks(range(len(marks.names)), labels=list(marks.names))
    axes[3].legend(fontsize=7, loc="lower right")
    axes[0].legend(fontsize=7, ncols=6, loc="lower left")
    for ax, label in zip(axes, ("ZNCC", "sigma, px", "off the rigid body, px", "status"), strict=True):
        ax.set_ylabel(label)
        ax.grid(alpha=0.3)
    axes[3].set_xlabel("frame")
    return axes
