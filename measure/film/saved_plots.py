"""Figures of a tracked film as files: contact sheet, quality, trajectory, dispersion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from measure.common.figure_plots import save_figure
from measure.common.output import replacing
from measure.film import mark_plots, motion_plots
from measure.film.status_colours import ENLARGED
from measure.footage.footage import Footage, Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from measure.film.dispersion import Dispersion
    from measure.film.tracked import Tracked
    from measure.tables.trajectory import Trajectory

_PANELS = 10


FIGURES = ("contact_sheet.png", "quality.png")


def write_pictures(footage: Footage, tracked: Tracked, folder: Path) -> list[Path]:
    """Write `contact_sheet.png` and `quality.png`.

    The film is read once more, and only the frames that are shown are kept.

    Parameters
    ----------
    footage : Footage
    tracked : Tracked
    folder : Path
        Made if need be.

    Returns
    -------
    list of Path
        The files.
    """
    shown = frames_to_show(tracked)
    kept = {number: picture for number, picture in footage.pictures() if number in shown}
    figures = (_sheet(kept, tracked), _quality(tracked))
    return [_write(figure, folder / name) for name, figure in zip(FIGURES, figures, strict=True)]


def frames_to_show(tracked: Tracked) -> set[int]:
    """Frames spread over the film, and those from which on a mark is not observed; ten or so."""
    lost = ~tracked.marks.observed
    turning = np.flatnonzero((lost[1:] & ~lost[:-1]).any(axis=1)) + 1
    return {0, *np.linspace(0, len(lost) - 1, _PANELS - min(len(turning), 4)).astype(int).tolist(), *turning[:4].tolist()}


def write_trajectory_figure(tracked: Tracked, path: Path) -> Path:
    """Write the trajectory, one channel below the other; it needs a scale. Returns `path`."""
    assert tracked.trajectory is not None
    figure, axes = _column(len(tracked.trajectory.channels), 1.7)
    motion_plots.draw_trajectory(axes, tracked.trajectory)
    return _write(figure, path)


def write_dispersion_figure(trajectory: Trajectory, compared: Sequence[Dispersion], path: Path) -> Path:
    """Write films of the same deployment over each other. Returns `path`."""
    shared = sum(any(channel in other.channels for other in compared) for channel in trajectory.channels)
    figure, axes = _column(2 * shared, 1.4)
    motion_plots.draw_dispersion(axes, trajectory, compared)
    return _write(figure, path)


def _pyplot() -> Any:
    """Without a screen, and imported late: it takes a second."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot


def _column(count: int, height: float) -> tuple[Figure, list[Any]]:
    """A figure of axes below each other, each of a height in inches."""
    size = (7, 1 + height * count)
    figure, axes = _pyplot().subplots(count, 1, sharex=True, figsize=size, layout="constrained", squeeze=False)
    figure.align_ylabels()
    return figure, list(axes[:, 0])


def _sheet(kept: dict[int, Picture], tracked: Tracked) -> Figure:
    rows, columns = next(iter(kept.values())).shape
    across = len(kept) if rows > 1.5 * columns else -(-len(kept) // 2)
    down = -(-len(kept) // across)
    width = 14.0
    size = (width, down * (width / across * rows / columns + 0.3) + 0.3)
    figure, axes = _pyplot().subplots(down, across, figsize=size, layout="constrained", squeeze=False)
    for ax in axes.flat[len(kept) :]:
        ax.set_axis_off()
    figure.suptitle(f"yellow: residual of the rigid body, enlarged {ENLARGED:g} times; its rms beside the number of the frame", fontsize=8)
    for ax, (number, picture) in zip(axes.flat, sorted(kept.items()), strict=False):
        mark_plots.draw_frame(ax, picture, tracked.marks, number, tracked.project.marks.subset_px, fit=tracked.fit)
    return figure


def _quality(tracked: Tracked) -> Figure:
    figure, axes = _column(4, 2.0)
    mark_plots.draw_quality(axes, tracked.marks, tracked.fit)
    return figure


def _write(figure: Figure, path: Path) -> Path:
    with replacing(path) as temporary:
        save_figure(figure, temporary, "png")
    _pyplot().close(figure)
    return path
