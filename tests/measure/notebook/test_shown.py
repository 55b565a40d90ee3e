"""Tables in a notebook: a short text, rows, and a picture; and bars of progress that hand on what they are given."""

import sys
from types import ModuleType

import numpy as np
import pytest

from measure import Loop, Trajectory, progress_of

T = np.linspace(0.0, 1.0, 50)
LOOP = Loop(T, 0.1 + 0.01 * np.sin(6 * T), 2.8 + 0.1 * np.cos(6 * T), name="<b>odd</b>.csv")
FILM = Trajectory(T, {"x_m": 1e-3 * T, "z_m": T}, {"z_m": np.full(50, 1e-5)}, name="film.csv")


@pytest.mark.parametrize("table", [LOOP, FILM], ids=["loop", "trajectory"])
def test_a_table_shows_itself_with_a_text_rows_and_a_picture(table):
    assert len(repr(table)) < 300
    shown = table._repr_html_()
    assert "<table" in shown
    assert "data:image/png;base64," in shown
    assert "<b>odd" not in shown
    assert len(shown) < 200_000


def test_the_figure_of_a_trajectory_has_its_channels_in_units_of_people():
    labels = [axes.get_ylabel() for axes in FILM.plot().axes]
    assert labels == ["lateral x, mm", "elevation z, mm"]
    (line,) = LOOP.plot().axes[0].lines
    np.testing.assert_allclose(np.asarray(line.get_xdata(), dtype=float), 1e3 * LOOP.elongation_m)


def test_progress_hands_on_what_it_is_given(capsys):
    assert list(progress_of("rows")(range(5))) == list(range(5))
    assert list(progress_of()(iter("abc"), 3)) == ["a", "b", "c"]
    shown = capsys.readouterr()
    assert "rows" in shown.out + shown.err


def test_in_a_notebook_progress_stands_below_the_cell(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "ipykernel", ModuleType("ipykernel"))
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert list(progress_of("rows")(range(5))) == list(range(5))
    assert "rows" in capsys.readouterr().out
