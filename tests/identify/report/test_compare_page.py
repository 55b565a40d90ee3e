"""The page of a comparison says the numbers of the comparison, and draws the samples that it compared."""

import csv
import io
import re
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest

from identify.campaign.run import Run
from identify.gap.compare import compare
from identify.gap.comparison import Comparison
from identify.report.compare_page import compare_html
from measure.tables.loop import read_loop
from simulate.files.model_file import read_model

DEMO = Path(__file__).resolve().parents[3] / "datasets" / "demo"


@pytest.fixture(scope="module")
def found() -> Comparison:
    loops = [read_loop(DEMO / "loops" / f"loop-{rate}Hz-80mm.csv") for rate in ("0.2", "3")]
    return compare(read_model(DEMO / "rig.toml"), [Run(loop, name=Path(loop.name).name) for loop in loops])


def test_the_first_figure_is_of_the_run_in_which_the_gap_is_the_largest_part_of_what_was_measured(found):
    page = compare_html(found, ["explain-gap it"], {})
    first = re.search(r"<figcaption><b>([^<]*)</b>", page)
    assert first
    assert first[1] == "One cycle of loop-3Hz-80mm.csv"
    assert "there is a gap" in page
    assert "explain-gap it" in page


def test_the_csv_of_a_figure_holds_the_samples_that_were_compared(found):
    page = compare_html(found, [], {})
    address = re.search(r'download="run-1.csv" href="data:text/csv;charset=utf-8,([^"]*)"', page)
    assert address
    head, *rows = csv.reader(io.StringIO(unquote(address[1].replace("&#39;", "'"))))
    measured = np.array([float(row[head.index("measured: force, N")]) for row in rows])
    curve = next(curve for curve in found.curves if curve.run == "loop-3Hz-80mm.csv")
    assert len(measured) > 300
    assert np.isin(np.round(measured, 6), np.round(curve.measured, 6)).all()
