"""Stamps of date and time, dialects of text, and what a file says of its test, against Python's own clock and by hand."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.readers.stated_conditions import Claim, claims, conditions, contradictions
from measure.readers.text.dialect import Reading, reading_of
from measure.readers.timestamps import is_date, is_stamp, seconds_of

BEGIN = datetime(2024, 2, 28, 23, 59, 58, 250_000)
AFTER = (0.0, 0.5, 1.75, 3.0, 86_400.0, 200_000.25)
STAMPS = [BEGIN + timedelta(seconds=after) for after in AFTER]


FORMS = [
    "%Y-%m-%d %H:%M:%S.%f",
    "%Y-%m-%dT%H:%M:%S.%fZ",
    "%Y/%m/%d  %H:%M:%S.%f",
    "%d.%m.%Y %H:%M:%S,%f",
    "%d/%m/%Y %H:%M:%S.%f",
    "%m/%d/%Y %I:%M:%S.%f %p",
]


@pytest.mark.parametrize("form", FORMS)
def test_stamps_are_seconds_since_the_first_over_a_leap_day(form):
    cells = [stamp.strftime(form) for stamp in STAMPS]
    assert all(map(is_stamp, cells))
    assert seconds_of(cells, "a.csv") == pytest.approx(AFTER, abs=1e-6)


def test_a_time_of_day_goes_on_over_midnight_and_noon_is_pm():
    assert seconds_of(["23:59:59.5", "0:00:00,5", "00:01:00"], "a.csv") == pytest.approx([0.0, 1.0, 60.5])
    assert seconds_of(["11:59 AM", "12:00 PM", "1:00 pm"], "a.csv") == pytest.approx([0.0, 60.0, 3660.0])
    assert seconds_of(["12:00:00 AM", "12:30:00 am"], "a.csv") == pytest.approx([0.0, 1800.0])
    assert seconds_of(["10:00:05", "10:00:00"], "a.csv") == pytest.approx([0.0, -5.0])


def test_what_is_no_stamp_is_no_number():
    assert seconds_of(["01:00:00", "x", "01:00:02"], "a.csv") == pytest.approx([0.0, np.nan, 2.0], nan_ok=True)
    assert np.isnan(seconds_of(["x", "y"], "a.csv")).all()
    for cell in ("1:2:3", "2024-01-01", "12.5", "1:00:00 XM"):
        assert not is_stamp(cell)
    for cell in ("2024-01-01", "1.2.2024", "2024年1月2日"):
        assert is_date(cell)
    assert not is_date("2024-01-01 01:00")
    assert np.isnan(seconds_of(["2024-02-30 01:00:00", "2024-03-01 01:00:00"], "a.csv")[0])


def test_day_or_month_first_is_known_by_a_number_beyond_twelve_or_by_points():
    assert seconds_of(["1/2/2024 0:00:00", "13/2/2024 0:00:00"], "a.csv") == pytest.approx([0.0, 12 * 86_400])
    assert seconds_of(["1/2/2024 0:00:00", "1/13/2024 0:00:00"], "a.csv") == pytest.approx([0.0, 11 * 86_400])
    assert seconds_of(["1.2.2024 0:00:00", "2.2.2024 0:00:00"], "a.csv") == pytest.approx([0.0, 86_400])
    assert seconds_of(["1/2/2024 0:00:00", "1/2/2024 0:00:09"], "a.csv") == pytest.approx([0.0, 9.0])
    with pytest.raises(InputError, match=r"a\.csv: 1/2/2024 may be day/month or month/day"):
        seconds_of(["1/2/2024 0:00:00", "2/2/2024 0:00:00"], "a.csv")


def body(separator, decimal, rows=6):
    return [separator.join(f"{value:.3f}".replace(".", decimal) for value in (0.1 * k, 1.5 + k, -2.25 * k)) for k in range(rows)]


@pytest.mark.parametrize("delimiter", [("tab", "\t"), ("semicolon", ";"), ("comma", ","), ("bar", "|"), ("space", " ")])
@pytest.mark.parametrize("decimal", [("point", "."), ("comma", ",")])
def test_the_dialect_is_the_one_in_which_every_cell_is_a_number(delimiter, decimal):
    if delimiter[0] == decimal[0]:
        return
    found = reading_of(Path("a.txt"), body(delimiter[1], decimal[1]), None, None)
    assert found == Reading(delimiter[0], decimal[0])
    assert found.is_number("-1" + decimal[1] + "5e-3")
    assert not found.is_number("1" + ("," if decimal[1] == "." else ".") + "5")


def test_a_few_odd_lines_and_words_do_not_hide_the_dialect_and_many_do():
    lines = body(";", ".", 10)
    assert reading_of(Path("a.txt"), [*lines, "end", "of file"], None, None).delimiter == "semicolon"
    with pytest.raises(InputError, match="no table of numbers found"):
        reading_of(Path("a.txt"), [*lines[:4], *["a word here"] * 8], None, None)
    with pytest.raises(InputError, match='the last line begins with "hello"'):
        reading_of(Path("a.txt"), ["hello world"], None, None)
    with pytest.raises(InputError, match="--delimiter nothing: unknown"):
        reading_of(Path("a.txt"), lines, "nothing", None)


def test_a_row_of_samples_has_two_numbers_and_words_in_half_of_its_cells_at_most():
    reading = Reading("comma", "point")
    for cells, is_data in ((["1", "2"], True), (["1"], False), (["1", "2", "x", "y"], True), (["1", "2", "x", "y", "z"], False)):
        assert reading.is_data(cells) == is_data
    assert reading.is_data(["1", "2", "nan", "", "x", "y"])


def test_thousands_are_not_taken_for_decimals():
    with pytest.raises(InputError, match="may be a decimal comma or a thousand"):
        reading_of(Path("a.txt"), ["1,250;2,500", "1,260;2,600"], None, None)
    assert reading_of(Path("a.txt"), ["1,250;2,500", "1,26;2,600"], None, None).decimal == "comma"


PATH = Path("run_0.5Hz_12mm_KDN_2.5bar.csv")


def test_numbers_in_the_notes_and_by_a_pattern_in_the_name_are_conditions():
    notes = ["pressure_bar = 3.5", "Temperature (C): 21", "speed;1e-3 m/s", "no number: here", "a, b, 3"]
    assert conditions(PATH, notes, None) == {"pressure_bar": 3.5, "Temperature (C)": 21.0, "speed": 1e-3}
    assert conditions(PATH, [], "KDN_{pressure_bar}bar") == {"pressure_bar": 2.5}
    with pytest.raises(InputError, match="does not follow"):
        conditions(PATH, [], "ABC_{pressure_bar}bar")
    with pytest.raises(InputError, match="no word in braces"):
        conditions(PATH, [], "KDN")


def test_frequencies_and_amplitudes_are_claims_in_hertz_and_metres():
    found = claims(PATH, ["Frequency (Hz) = 0.6", "amplitude: 5 mm", "freq = -1"], {"amp_mm": np.full(3, 4.0), "u": np.arange(3.0)})
    assert found == [
        Claim("a note in it", "frequency", 0.6),
        Claim("a note in it", "amplitude", pytest.approx(5e-3)),  # type: ignore[arg-type]
        Claim('column "amp_mm"', "amplitude", pytest.approx(4e-3)),  # type: ignore[arg-type]
        Claim("its name", "frequency", 0.5),
        Claim("its name", "travel", pytest.approx(0.012)),  # type: ignore[arg-type]
    ]


@pytest.mark.parametrize(
    ("claim", "denied"),
    [
        (Claim("x", "frequency", 0.514), False), (Claim("x", "frequency", 0.516), True), (Claim("x", "frequency", 0.484), True),
        (Claim("x", "amplitude", 0.0103), False), (Claim("x", "amplitude", 0.0104), True), (Claim("x", "amplitude", 0.02), True),
        (Claim("x", "travel", 0.0103), False), (Claim("x", "travel", 0.0206), False), (Claim("x", "travel", 0.03), True),
    ],
)  # fmt: skip
def test_a_claim_is_denied_that_the_signal_misses_by_three_percent_a_travel_only_as_amplitude_and_stroke(claim, denied):
    assert bool(contradictions("a.csv", [claim], 0.5, 0.01)) == denied
    assert contradictions("a.csv", [claim], np.nan, np.nan) == []


def test_a_denied_claim_is_said_with_both_numbers():
    said = contradictions("a.csv", [Claim("its name", "frequency", 1.0), Claim("a note in it", "amplitude", 0.02)], 0.5, 0.01)
    assert said == [
        "a.csv: its name says 1 Hz, the signal 0.5 Hz; the signal counts",
        "a.csv: a note in it says 20 mm, the signal shows an amplitude of 10 mm; the signal counts",
    ]
