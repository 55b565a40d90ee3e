"""Figures of the film side: axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from measure.film.overlay import COLOURS, ENLARGED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from measure.correlation.marks import Marks
    from measure.film.dispersion import Dispersion
    from measure.footage.footage import Picture
    from measure.geometry.rigid_body import Fit
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


def draw_frame(ax: Axes, picture: Picture, marks: Marks, frame: int, subset: int, *, fit: Fit | None = None, names: bool = False) -> Axes:
    """One frame with the subsets that were found, their distance from the rigid body, and in words what became of the others."""
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
            if fit is not None and fit.used[frame, i]:
                dx, dy = np.clip(ENLARGED * fit.residual_px[frame, i], -4 * half, 4 * half)
                ax.plot([x, x + dx], [y, y + dy], lw=0.9, color="#e6ab02")
            if names:
                ax.annotate(name, (x, y - half), color="#1b9e77", ha="center", va="bottom", fontsize=8)
    words = [f"{name} {marks.status[frame, i]}" for i, name in enumerate(marks.names) if not marks.seen[frame, i]]
    ax.set_title(f"frame {frame}{_residual(fit, frame)}", fontsize=8)
    ax.set_xlabel("\n".join(words[:3]), fontsize=7, color="#d95f02")
    ax.set_xticks([])
    ax.set_yticks([])
    return ax


def _residual(fit: Fit | None, frame: int) -> str:
    if fit is None or not fit.used[frame].any():
        return ""
    return f": {np.sqrt(np.nanmean(fit.residual_px[frame][fit.used[frame]] ** 2)):.4f} px"


def draw_dispersion(axes: Sequence[Axes], trajectory: Trajectory, found: Sequence[Dispersion]) -> Sequence[Axes]:
    """Films over each other, the others on the first one's clock, and below each channel what they differ by; two axes a channel."""
    for k, channel in enumerate(c for c in trajectory.channels if any(c in other.channels for other in found)):
        name, unit, factor = _LABELS[channel]
        both, gap = axes[2 * k], axes[2 * k + 1]
        both.plot(trajectory.time_s, factor * trajectory.channels[channel], lw=1.2, color="C0", label="this film")
        for n, other in enumerate(o for o in found if channel in o.channels):
            difference, table, colour = other.channels[channel], other.other, f"C{n + 1}"
            both.plot(table.time_s - other.shift_s, factor * table.channels[channel], "--", lw=1, color=colour, label=other.name)
            gap.plot(difference.time_s, factor * difference.values, lw=1, color=colour)
            band = 2 * factor * difference.sigma
            gap.fill_between(difference.time_s, -band, band, color=colour, alpha=0.2, lw=0)
        both.set_ylabel(f"{name}, {unit}")
        gap.set_ylabel(f"difference, {unit}")
        both.legend(fontsize=7)
    for ax in axes:
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("time, s")
    return axes


def draw_quality(axes: Sequence[Axes], marks: Marks, fit: Fit | None) -> Sequence[Axes]:
    """Per mark against the frame: correlation, sigma, distance from the rigid body, and what it was not seen for."""
    frames = np.arange(len(marks.time_s))
    for i, name in enumerate(marks.names):
        axes[0].plot(frames, marks.zncc[:, i], lw=1, label=name)
        axes[1].semilogy(frames, marks.sigma_px[:, i], lw=1)
        if fit is not None:
            axes[2].plot(frames, np.hypot(*fit.residual_px[:, i].T), lw=1)
        for status, colour in COLOURS.items():
            at = frames[marks.status[:, i] == status]
            axes[3].plot(at, np.full(len(at), i), ".", ms=3, color=colour)
    for status, colour in COLOURS.items():
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
