"""Figures of pages: what is drawn stands where the numbers say, and the numbers can be had."""

import csv
import io
import re
from urllib.parse import unquote

import numpy as np
import pytest

from measure.pages.csv_address import csv_address
from measure.pages.figure import SIZE, Band, Figure, Line, Panel
from measure.pages.ticks import ticks_between

T = np.linspace(0.0, 0.5, 6)


def _rows(address: str) -> list[list[str]]:
    kind, _, text = address.partition(",")
    assert kind == "data:text/csv;charset=utf-8"
    return list(csv.reader(io.StringIO(unquote(text))))


def _points(path: str) -> list[tuple[int, int]]:
    """Where a path goes, from its moves."""
    places: list[tuple[int, int]] = []
    for letter, x, y in re.findall(r"([Mml])(-?\d+) (-?\d+)", path):
        last = places[-1] if places and letter != "M" else (0, 0)
        places.append((last[0] + int(x), last[1] + int(y)))
    return places


def _figure(y: np.ndarray, **panel: object) -> Figure:
    lines = [Line("measured", T, y, "measured", dots=True), Line("modelled", T, y + 1.0)]
    return Figure("f", "Elevation", "time, s", [Panel("elevation, mm", lines, **panel)])  # type: ignore[arg-type]


def test_a_curve_is_drawn_in_its_axes_from_the_left_to_the_right_and_upwards():
    figure = _figure(T, limits=(0.0, 1.0))
    dots = _points(figure.drawn[0].drawn[0].path)
    assert dots[0] == (0, SIZE)
    assert dots[-1] == (SIZE, SIZE // 2)
    assert figure.drawn[0].drawn[0].path.count("h0") == len(T)


def test_a_curve_is_interrupted_where_nothing_was_seen():
    y = np.array([0.0, 1.0, np.nan, 3.0, 4.0, 5.0])
    path = Figure("f", "t", "x", [Panel("y", [Line("a", T, y)])]).drawn[0].drawn[0].path
    assert path.count("m") == 1
    assert len(_points(path)) == 5


def test_the_csv_holds_every_curve_and_each_axis_once():
    figure = Figure("f", "t", "time, s", [*_figure(T).panels, Panel("gap, mm", [], [Band("noise", T, T - 2, T + 2)])])
    head, *rows = _rows(figure.csv)
    assert head == ["time, s", "measured: elevation, mm", "modelled: elevation, mm", "noise, low: gap, mm", "noise, high: gap, mm"]
    np.testing.assert_allclose([float(row[2]) for row in rows], T + 1.0)
    assert [one.columns for one in figure.drawn[0].drawn] == [(0, 1), (0, 2)]


def test_curves_over_other_places_have_an_axis_of_their_own_in_the_csv():
    lines = [Line("a", T, T), Line("b", T[:3], T[:3])]
    head, *rows = _rows(Figure("f", "t", "x", [Panel("y", lines)]).csv)
    assert head == ["x", "a: y", "x (2)", "b: y"]
    assert rows[-1][2:] == ["", ""]


def test_a_cell_that_begins_a_formula_is_disarmed():
    assert _rows(csv_address({"=1+1": ["=2"]})) == [["'=1+1"], ["'=2"]]


@pytest.mark.parametrize("values", [np.full(6, np.nan), np.zeros(6), np.full(6, 1e9)], ids=["nothing", "flat", "flat far off"])
def test_what_has_no_height_has_axes_nevertheless(values):
    (panel,) = Figure("f", "t", "x", [Panel("y", [Line("a", T, values)])]).drawn
    assert panel.domain[1] > panel.domain[0]


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-3.3e-5, 7.1e-5), (252.0, 651.0), (-1e4, 3e5)])
def test_ticks_are_few_round_numbers_within_the_axis(low, high):
    ticks = ticks_between(low, high)
    assert 3 <= len(ticks) <= 8
    assert all(-1e-6 <= tick.share <= 1 + 1e-6 for tick in ticks)
    values = np.array([float(tick.text) for tick in ticks])
    np.testing.assert_allclose((values - low) / (high - low), [tick.share for tick in ticks], atol=1e-6)
    assert len(set(np.round(np.diff(values) / np.diff(values)[0], 6))) == 1
