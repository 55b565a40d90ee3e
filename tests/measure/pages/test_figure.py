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


def _one_panel(*lines, **panel):
    return Figure("f", "t", "x", [Panel("y", list(lines), **panel)])


def test_axes_reach_a_twentieth_beyond_the_values_upwards_and_not_sideways():
    figure = _one_panel(Line("a", T, 10.0 * T), level=-1.0)
    assert figure.domain == (0.0, 0.5)
    assert figure.drawn[0].domain == pytest.approx((-1.3, 5.3))
    banded = Figure("f", "t", "x", [Panel("y", [], [Band("b", T, T - 2.0, T + 3.0)])])
    assert banded.drawn[0].domain == pytest.approx((-2.275, 3.775))
    assert _one_panel(Line("a", T, np.full(6, 4.0))).drawn[0].domain == pytest.approx((2.0, 6.0))
    assert _one_panel(Line("a", T, np.full(6, 0.2))).drawn[0].domain == pytest.approx((-0.3, 0.7))
    assert _one_panel(Line("a", T, np.full(6, np.nan))).drawn[0].domain == (0.0, 1.0)
    assert Figure("f", "t", "x", [], x_limits=(2.0, 3.0)).domain == (2.0, 3.0)
    assert Figure("f", "t", "x", []).domain == (0.0, 1.0)


@pytest.mark.parametrize(("level", "at"), [(0.25, 7500), (0.0, SIZE), (1.0, 0), (1.01, None), (-0.01, None), (None, None)])
def test_a_level_is_counted_from_above_and_left_out_beyond_the_axis(level, at):
    assert _one_panel(Line("a", T, T), level=level, limits=(0.0, 1.0)).drawn[0].level == at


def test_a_curve_far_beyond_its_axis_is_cut_a_width_beyond_the_drawing():
    path = _one_panel(Line("a", np.array([-9.0, 0.25, 9.0]), np.array([50.0, 0.5, -50.0])), limits=(0.0, 1.0))
    zoomed = Figure("f", "t", "x", path.panels, x_limits=(0.0, 0.5))
    assert _points(zoomed.drawn[0].drawn[0].path) == [(-SIZE, -SIZE), (SIZE // 2, SIZE // 2), (2 * SIZE, 2 * SIZE)]


def test_after_a_gap_a_curve_begins_anew_where_it_is_seen_again():
    y = np.array([np.nan, 0.0, 1.0, np.nan, np.nan, 0.5])
    path = _one_panel(Line("a", T, y), limits=(0.0, 1.0)).drawn[0].drawn[0].path
    assert path == "M2000 10000l2000 -10000m6000 5000"
    assert _one_panel(Line("a", T, np.full(6, np.nan))).drawn[0].drawn[0].path == ""
    assert _one_panel(Line("a", T[:2], T[:2], dots=True), limits=(0.0, 1.0)).drawn[0].drawn[0].path == "M0 10000h0m10000 -1000h0"


def test_a_band_goes_along_its_upper_end_and_back_along_the_lower_one():
    band = Band("b", np.array([0.0, 1.0]), np.array([0.0, 0.2]), np.array([0.5, 1.0]))
    (drawn,) = Figure("f", "t", "x", [Panel("y", [], [band], limits=(0.0, 1.0))]).drawn[0].drawn
    assert drawn.path == "M0 5000l10000 -5000l0 8000l-10000 2000Z"
    assert (drawn.filled, drawn.dots, drawn.look, drawn.columns) == (True, False, "noise", (0, 1))


def test_the_legend_has_each_name_once_in_the_order_of_the_panels_and_the_words_for_the_blind_all():
    panels = [Panel("y", [Line("a", T, T), Line("b", T, T)]), Panel("z", [Line("b", T, T, "two"), Line("c", T, T)])]
    figure = Figure("f", "Title", "x", panels)
    assert [one.name for one in figure.legend] == ["a", "b", "c"]
    assert figure.legend[1].look == "one"
    assert figure.spoken == "Title. Over x, 0 to 0.5. y: a, b; z: b, c."


def test_curves_of_one_name_and_other_values_have_a_number_in_the_csv():
    lines = [
        Line("a", T, T),
        Line("a", T, 2 * T),
        Line("a", T, 3 * T),
        Line("b", T, np.where(T > 0.1, T, np.nan)),
        Line("b", T, np.where(T > 0.1, T, np.nan)),
    ]
    head, *rows = _rows(_one_panel(*lines).csv)
    assert head == ["x", "a: y", "a: y (2)", "a: y (3)", "b: y"]
    assert [float(cell) for cell in rows[-1]] == pytest.approx([0.5, 0.5, 1.0, 1.5, 0.5])


@pytest.mark.parametrize(
    ("low", "high", "most", "words"),
    [
        (0.0, 1.0, 5, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
        (0.0, 0.5, 7, ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5"]),
        (-3.0, 41.0, 5, ["0", "10", "20", "30", "40"]),
        (0.0, 7e-3, 7, ["0.000", "0.001", "0.002", "0.003", "0.004", "0.005", "0.006", "0.007"]),
        (100.0, 400.0, 5, ["100", "200", "300", "400"]),
    ],
)
def test_ticks_stand_at_ones_twos_and_fives(low, high, most, words):
    assert [tick.text for tick in ticks_between(low, high, most)] == words
