"""A figure of a page: panels one below the other over one axis, drawn as inline SVG, with the numbers behind it as CSV.

The drawing is stretched to the width that there is and its words are not: they stand around it as HTML.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from measure.pages.csv_address import csv_address
from measure.pages.ticks import Tick, ticks_between

SIZE = 10_000  # of a drawing, either way, whatever it shows
_MARGIN = 0.05
_MOST_HEIGHT_TICKS = 5


@dataclass(frozen=True)
class Line:
    """A curve. x, y : (n,); where one is not finite the curve is interrupted.

    look : of the stylesheet, "measured", "given", "refitted", "effect", or "one" to "six". dots : points instead of a line. when : the
    state of the page's switches in which it is shown, such as "10"; always where empty.
    """

    name: str
    x: Array
    y: Array
    look: str = "one"
    dots: bool = False
    when: str = ""


@dataclass(frozen=True)
class Band:
    """What lies between two curves over x, (n,) each."""

    name: str
    x: Array
    low: Array
    high: Array
    look: str = "noise"


@dataclass(frozen=True)
class Panel:
    """One pair of axes. label : of the vertical axis, with its unit. level : a horizontal line. limits : of the vertical axis."""

    label: str
    lines: Sequence[Line]
    bands: Sequence[Band] = ()
    height_px: int = 200
    level: float | None = None
    limits: tuple[float, float] | None = None


@dataclass(frozen=True)
class Drawn:
    """A curve or a band as the template draws it: its path, and the columns of the CSV that hold it."""

    name: str
    look: str
    path: str
    dots: bool
    filled: bool
    when: str
    columns: tuple[int, int]


@dataclass(frozen=True)
class DrawnPanel:
    """A panel as the template draws it; heights are 0 to 1 from the bottom."""

    label: str
    height_px: int
    domain: tuple[float, float]
    ticks: list[Tick]
    drawn: tuple[Drawn, ...]
    level: int | None


@dataclass(frozen=True)
class Figure:
    """A figure.

    name : of its CSV, without an ending, another in each figure of a page. title, caption : what it is, and what is seen in it.
    x_label : with its unit. link : figures of the same word share their cursor and their zoom. large : keeps its height in print.
    """

    name: str
    title: str
    x_label: str
    panels: Sequence[Panel]
    caption: str = ""
    link: str = ""
    x_limits: tuple[float, float] | None = None
    large: bool = False

    @cached_property
    def domain(self) -> tuple[float, float]:
        """Ends of the horizontal axis."""
        return self.x_limits or _ends([one.x for panel in self.panels for one in (*panel.lines, *panel.bands)])

    @property
    def ticks(self) -> list[Tick]:
        """Of the horizontal axis."""
        return ticks_between(*self.domain)

    @property
    def drawn(self) -> tuple[DrawnPanel, ...]:
        """The panels as the template draws them."""
        return self._made[0]

    @property
    def csv(self) -> str:
        """The numbers behind the figure, as an address that holds them."""
        return csv_address(self._made[1])

    @property
    def legend(self) -> list[Drawn]:
        """One entry for each name."""
        return list({one.name: one for panel in reversed(self.drawn) for one in reversed(panel.drawn)}.values())[::-1]

    @property
    def spoken(self) -> str:
        """What the drawing shows, for those who do not see it."""
        shown = "; ".join(f"{panel.label}: {', '.join(one.name for one in panel.drawn)}" for panel in self.drawn)
        return f"{self.title}. Over {self.x_label}, {self.domain[0]:.4g} to {self.domain[1]:.4g}. {shown}."

    @cached_property
    def _made(self) -> tuple[tuple[DrawnPanel, ...], dict[str, Array]]:
        table: dict[str, Array] = {}
        return tuple(self._panel(panel, table) for panel in self.panels), table

    def _panel(self, panel: Panel, table: dict[str, Array]) -> DrawnPanel:
        ends = panel.limits or _ends(_heights(panel), _MARGIN)
        drawn = (
            *(self._band(one, ends, table, panel) for one in panel.bands),
            *(self._line(one, ends, table, panel) for one in panel.lines),
        )
        level = (
            None
            if panel.level is None or not ends[0] <= panel.level <= ends[1]
            else int(_turned(_scaled(np.array([panel.level]), ends))[0])
        )
        return DrawnPanel(panel.label, panel.height_px, ends, ticks_between(*ends, _MOST_HEIGHT_TICKS), drawn, level)

    def _line(self, line: Line, ends: tuple[float, float], table: dict[str, Array], panel: Panel) -> Drawn:
        path = _path(_scaled(line.x, self.domain), _turned(_scaled(line.y, ends)), dots=line.dots)
        at = _added(table, self.x_label, line.x), _added(table, f"{line.name}: {panel.label}", line.y)
        return Drawn(line.name, line.look, path, line.dots, False, line.when, at)

    def _band(self, band: Band, ends: tuple[float, float], table: dict[str, Array], panel: Panel) -> Drawn:
        around = np.concatenate([band.x, band.x[::-1]]), np.concatenate([band.high, band.low[::-1]])
        path = _path(_scaled(around[0], self.domain), _turned(_scaled(around[1], ends))) + "Z"
        at = _added(table, self.x_label, band.x), _added(table, f"{band.name}, low: {panel.label}", band.low)
        _added(table, f"{band.name}, high: {panel.label}", band.high)
        return Drawn(band.name, band.look, path, False, True, "", at)


def _heights(panel: Panel) -> list[Array]:
    levels = [] if panel.level is None else [np.array([panel.level])]
    return [*(line.y for line in panel.lines), *(end for band in panel.bands for end in (band.low, band.high)), *levels]


def _ends(parts: Sequence[Array], margin: float = 0.0) -> tuple[float, float]:
    """Least and largest finite value, with a margin; of nothing 0 and 1."""
    values = np.concatenate([np.asarray(part, dtype=float) for part in parts]) if parts else np.empty(0)
    values = values[np.isfinite(values)]
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    room = margin * (high - low) or (0.0 if high > low else max(abs(low), 1.0) * 0.5)
    return low - room, high + room


def _scaled(values: Array, ends: tuple[float, float]) -> Array:
    return SIZE * (np.asarray(values, dtype=float) - ends[0]) / (ends[1] - ends[0])


def _turned(heights: Array) -> Array:
    """As a picture counts, from above."""
    return SIZE - heights


def _path(x: Array, y: Array, *, dots: bool = False) -> str:
    """SVG path; each step is written as a move from the last point, which is short. Dots are lines of no length with round ends."""
    good = np.isfinite(x) & np.isfinite(y)
    xs, ys = _whole(x[good]), _whole(y[good])
    if not len(xs):
        return ""
    if dots:
        first = [f"M{xs[0]} {ys[0]}h0"]
        return "".join(first + [f"m{dx} {dy}h0" for dx, dy in zip(np.diff(xs), np.diff(ys), strict=True)])
    begins = np.flatnonzero(good) != np.concatenate([[-1], np.flatnonzero(good)[:-1] + 1])
    steps = zip(np.diff(xs), np.diff(ys), begins[1:], strict=True)
    return f"M{xs[0]} {ys[0]}" + "".join(f"{'m' if begin else 'l'}{dx} {dy}" for dx, dy, begin in steps)


def _whole(values: Array) -> NDArray[np.int_]:
    return np.rint(np.clip(values, -SIZE, 2 * SIZE)).astype(int)


def _added(table: dict[str, Array], name: str, values: Array) -> int:
    """Place of a column in the table, where it is put unless one of the same beginning and the same values is there."""
    values = np.asarray(values, dtype=float)
    for place, (known, column) in enumerate(table.items()):
        if known.startswith(name) and np.array_equal(column, values, equal_nan=True):
            return place
    same = sum(known == name or known.startswith(f"{name} (") for known in table)
    table[name if not same else f"{name} ({same + 1})"] = values
    return len(table) - 1
