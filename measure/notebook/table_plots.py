"""Figures of the two tables, as a notebook shows them."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING

from measure.common.figure_plots import save_figure
from measure.film.motion_plots import draw_trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from measure.tables.loop import Loop
    from measure.tables.trajectory import Trajectory


_DPI = 72


def picture_of(figure: Figure) -> str:
    """A figure as the HTML of a picture that is in it."""
    buffer = io.BytesIO()
    save_figure(figure, buffer, "png", dpi=_DPI)
    data = base64.b64encode(buffer.getvalue()).decode()
    return f'<img alt="the same as a figure" style="max-width: 100%" src="data:image/png;base64,{data}">'


class ShowingLoop:
    """How a loop shows itself."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop

    def figure(self) -> Figure:
        """Force against elongation."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(5.0, 3.0), layout="constrained")
        axes = figure.subplots()
        axes.plot(1e3 * self.loop.elongation_m, self.loop.force_N, lw=0.8)
        axes.set(xlabel="elongation, mm", ylabel="force, N", title=self.loop.name)
        axes.grid(alpha=0.3)
        return figure


class ShowingTrajectory:
    """How a trajectory shows itself."""

    def __init__(self, trajectory: Trajectory) -> None:
        self.trajectory = trajectory

    def figure(self) -> Figure:
        """Every channel against time, with its band."""
        from matplotlib.figure import Figure

        count = len(self.trajectory.channels)
        figure = Figure(figsize=(5.0, 1.4 * count + 0.6), layout="constrained")
        draw_trajectory(list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]), self.trajectory)
        return figure
