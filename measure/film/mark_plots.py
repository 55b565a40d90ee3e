"""Figures of the marks: axes in, axes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from measure.correlation.marks import OK
from measure.film.status_colours import ENLARGED, RESIDUAL_COLOUR, STATUS_COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from measure.correlation.marks import Marks
    from measure.footage.footage import Picture
    from measure.geometry.rigid_body import Fit

_MOST_NAMED = 3
_ABOVE: dict[str, Any] = {
    "fontsize": 7,
    "ncols": 12,
    "loc": "lower right",
    "bbox_to_anchor": (1.0, 1.0),
    "frameon": False,
    "borderaxespad": 0,
}
"""Where a legend covers no data."""


def draw_frame(ax: Axes, picture: Picture, marks: Marks, frame: int, subset: int, *, fit: Fit | None = None) -> Axes:
    """Draw one frame with the subsets that were found and their residuals, and name the status of the other marks.

    Parameters
    ----------
    ax : Axes
    picture : (height, width) array
    marks : Marks
    frame : int
    subset : int
        Side of the subset, px.
    fit : Fit, optional
        Residuals are drawn from it, enlarged.

    Returns
    -------
    The axes.
    """
    ax.imshow(picture, cmap="gray", vmin=0, vmax=max(float(np.percentile(picture, 99.9)), 1.0), interpolation="nearest")
    ax.autoscale(False)
    for i in range(len(marks.names)):
        if marks.observed[frame, i]:
            _draw_mark(ax, marks, frame, i, subset / 2, fit)
    others = [f"{name} {marks.status[frame, i]}" for i, name in enumerate(marks.names) if not marks.observed[frame, i]]
    ax.set_title(f"frame {marks.first + frame}{_residual(fit, frame)}", fontsize=8)
    ax.set_xlabel("\n".join(others[:_MOST_NAMED]), fontsize=7, color=STATUS_COLOURS["occluded"])
    ax.set_xticks([])
    ax.set_yticks([])
    return ax


def _draw_mark(ax: Axes, marks: Marks, frame: int, i: int, half: float, fit: Fit | None) -> None:
    x, y = marks.x_px[frame, i], marks.y_px[frame, i]
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * half
    ax.plot(x + corners[:, 0], y + corners[:, 1], lw=0.9, color=STATUS_COLOURS[OK])
    if fit is not None and fit.used[frame, i]:
        dx, dy = np.clip(ENLARGED * fit.residual_px[frame, i], -4 * half, 4 * half)
        ax.plot([x, x + dx], [y, y + dy], lw=0.9, color=RESIDUAL_COLOUR)


def _residual(fit: Fit | None, frame: int) -> str:
    if fit is None or not fit.used[frame].any():
        return ""
    return f": {np.sqrt(np.nanmean(fit.residual_px[frame][fit.used[frame]] ** 2)):.4f} px"


def draw_quality(axes: Sequence[Axes], marks: Marks, fit: Fit | None) -> Sequence[Axes]:
    """Draw for each mark against the frame: correlation, standard deviation, residual of the rigid body, status.

    Parameters
    ----------
    axes : sequence of four Axes
    marks : Marks
    fit : Fit or None

    Returns
    -------
    The axes.
    """
    frames = marks.first + np.arange(len(marks.time_s))
    for i, name in enumerate(marks.names):
        axes[0].plot(frames, marks.zncc[:, i], lw=1, label=name)
        axes[1].semilogy(frames, marks.sigma_px[:, i], lw=1)
        if fit is not None:
            axes[2].plot(frames, np.hypot(*fit.residual_px[:, i].T), lw=1)
    _draw_status(axes[3], marks, frames)
    axes[0].legend(**_ABOVE)
    for ax, label in zip(axes, ("ZNCC", "sigma, px", "residual of the rigid body, px", "status"), strict=True):
        ax.set_ylabel(label)
        ax.grid(alpha=0.3)
    axes[3].set_xlabel("frame")
    return axes


def _draw_status(ax: Axes, marks: Marks, frames: np.ndarray) -> None:
    for status, colour in STATUS_COLOURS.items():
        found, which = np.nonzero(marks.status == status)
        if len(found):
            ax.plot(frames[found], which, ".", ms=3, color=colour, label=status)
    ax.set_yticks(range(len(marks.names)), labels=list(marks.names))
    ax.legend(**_ABOVE)
