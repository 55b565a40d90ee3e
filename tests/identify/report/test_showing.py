"""What a notebook shows of fits, comparisons and explanations."""

from pathlib import Path

import pytest

from identify import compare, fit_actuator, prepare
from identify.campaign.run import Run
from measure import read_loop
from simulate import read_model

DEMO = Path(__file__).resolve().parents[3] / "datasets" / "demo"


def _looks_right(result):
    assert len(repr(result)) < 300
    shown = result._repr_html_()
    assert "<table" in shown
    assert "data:image/png;base64," in shown
    assert result.plot().axes


def test_an_explanation_shows_its_finding_with_its_interval(shaken):
    _looks_right(shaken)
    assert "more moving mass" in repr(shaken) or "that the model leaves out" in repr(shaken)
    frame = shaken.to_frame()
    assert frame.attrs["units"]["value"] == "as in the column unit"
    (row,) = frame.to_dict("records")
    assert row["unit"] == "kg"
    assert row["ci95_low"] < row["value"] < row["ci95_high"]


def test_a_comparison_shows_a_row_for_each_channel():
    loop = read_loop(DEMO / "loops" / "loop-3Hz-80mm.csv")
    found = compare(read_model(DEMO / "rig.toml"), [Run(loop, name="loop.csv")])
    _looks_right(found)
    assert "1 runs: the gap is" in repr(found)
    (row,) = found.to_frame().to_dict("records")
    assert row["rmse"] == pytest.approx(found.curves[0].numbers["rmse"])


def test_a_fit_of_loops_shows_its_slowest_and_its_fastest_loop():
    loops = [prepare(read_loop(DEMO / "loops" / f"loop-{rate}Hz-20mm.csv")) for rate in ("3", "0.2")]
    fit = fit_actuator(loops, suggest=False)
    _looks_right(fit)
    titles = [axes.get_title() for axes in fit.plot().axes]
    assert [title.split(", ")[1] for title in titles] == ["0.2 Hz", "3 Hz"]
