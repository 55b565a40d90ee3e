"""Pictures of a tracked film for the eye: the marks on the first frame, a contact sheet, and how good each mark was."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from measure.common.output import replacing
from measure.film import motion_plots as plots
from measure.footage.footage import Footage, Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from measure.film.dispersion import Dispersion
    from measure.film.track import Tracked
    from measure.tables.trajectory import Trajectory


_PANELS = 10


def write_pictures(footage: Footage, tracked: Tracked, folder: Path) -> list[Path]:
    """Write `first_frame.png`, `contact_sheet.png` and `quality.png` into a folder, which is made if need be.

    The film is read once more, and only the frames that are shown are kept.
    """
    folder.mkdir(parents=True, exist_ok=True)
    shown = frames_to_show(tracked)
    kept = {number: picture for number, picture in footage.pictures() if number in shown}
    figures = {
        "first_frame.png": _first(kept[min(kept)], tracked),
        "contact_sheet.png": _sheet(kept, tracked),
        "quality.png": _quality(tracked),
    }
    return [_write(figure, folder / name) for name, figure in figures.items()]


def frames_to_show(tracked: Tracked) -> set[int]:
    """Frames spread over the film, and those in which a mark is first not seen."""
    lost = ~tracked.marks.seen
    turning = np.flatnonzero((lost[1:] & ~lost[:-1]).any(axis=1)) + 1
    return {0, *np.linspace(0, len(lost) - 1, _PANELS - min(len(turning), 4)).astype(int).tolist(), *turning[:4].tolist()}


def write_trajectory_figure(tracked: Tracked, path: Path) -> Path:
    """The trajectory, one channel below the other."""
    assert tracked.trajectory is not None
    count = len(tracked.trajectory.channels)
    figure, axes = _pyplot().subplots(count, 1, sharex=True, figsize=(7, 1 + 1.7 * count), layout="constrained", squeeze=False)
    plots.draw_trajectory(list(axes[:, 0]), tracked.trajectory)
    figure.align_ylabels()
    return _write(figure, path)


def write_dispersion_figure(trajectory: Trajectory, found: Sequence[Dispersion], path: Path) -> Path:
    """Films of the same deployment over each other."""
    count = 2 * sum(any(c in other.channels for other in found) for c in trajectory.channels)
    figure, axes = _pyplot().subplots(count, 1, sharex=True, figsize=(7, 1 + 1.4 * count), layout="constrained", squeeze=False)
    plots.draw_dispersion(list(axes[:, 0]), trajectory, found)
    figure.align_ylabels()
    return _write(figure, path)


def _pyplot() -> Any:
    """Without a screen, and imported late: it takes a second."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot


def _first(picture: Picture, tracked: Tracked) -> Figure:
    rows, columns = picture.shape
    figure, ax = _pyplot().subplots(figsize=(8 * min(1.0, columns / rows) + 0.5, 8 * min(1.0, rows / columns) + 0.5), layout="constrained")
    plots.draw_frame(ax, picture, tracked.marks, 0, tracked.project.marks.subset_px, names=True)
    return figure


def _sheet(kept: dict[int, Picture], tracked: Tracked) -> Figure:
    rows, columns = next(iter(kept.values())).shape
    across = len(kept) if rows > 1.5 * columns else -(-len(kept) // 2)
    down = -(-len(kept) // across)
    width = 14.0
    figure, axes = _pyplot().subplots(
        down, across, figsize=(width, down * (width / across * rows / columns + 0.3)), layout="constrained", squeeze=False
    )
    for ax in axes.flat[len(kept) :]:
        ax.set_axis_off()
    figure.suptitle(f"yellow: distance from the rigid body, {plots.ENLARGED:g} times enlarged; its rms beside the frame", fontsize=8)
    for ax, (number, picture) in zip(axes.flat, sorted(kept.items()), strict=False):
        plots.draw_frame(ax, picture, tracked.marks, number, tracked.project.marks.subset_px, fit=tracked.fit)
    return figure


def _quality(tracked: Tracked) -> Figure:
    figure, axes = _pyplot().subplots(4, 1, sharex=True, figsize=(8, 9), layout="constrained")
    plots.draw_quality(list(axes), tracked.marks, tracked.fit)
    figure.align_ylabels()
    return figure


def _write(figure: Figure, path: Path) -> Path:
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=110)
    _pyplot().close(figure)
    return path
