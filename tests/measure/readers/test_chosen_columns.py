"""Which column is which, and the sentence where it is not sure, word by word."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from measure.common.errors import InputError, OptionsMissing
from measure.readers.chosen_columns import chosen_columns
from measure.readers.column_mapping import ColumnMapping
from measure.readers.column_names import name_fits
from measure.tables.raw_table import RawTable

GROWING, LENGTH, FORCE = np.arange(5.0), np.array([0.0, 2.0, 1.0, 3.0, 2.0]), np.array([3.0, 1.0, 2.0, 1.0, 0.0])


def table(*header, units=(), columns=None, notes=(), lines=True, line=3, first_row=()):
    values = columns if columns is not None else [GROWING, LENGTH, FORCE, FORCE][: max(len(header), 3)]
    rows = list(range(4, 9)) if lines else ()
    return RawTable(Path("a.csv"), values, header, units, lines=rows, header_line=line, notes=notes, first_row=first_row)


def places(found):
    return {quantity: (place, found.units[quantity].text) for quantity, place in found.columns.items()}


def said(raw, **wanted):
    with pytest.raises(OptionsMissing) as caught:
        chosen_columns(raw, ColumnMapping(**wanted))
    return str(caught.value)


def test_own_names_and_units_in_brackets_need_nothing():
    found = chosen_columns(table("Time (ms)", "elongation [mm]", "force_kN"), ColumnMapping())
    assert places(found) == {"time": (0, "ms"), "elongation": (1, "mm"), "force": (2, "kN")}
    assert found.said == []
    in_a_row = chosen_columns(table("force", "time", "elongation", units=("N", "s", "m")), ColumnMapping())
    assert places(in_a_row) == {"time": (1, "s"), "elongation": (2, "m"), "force": (0, "N")}


def test_usual_names_are_taken_and_said_where_all_three_are_found():
    found = chosen_columns(table("Zeit (s)", "Weg (mm)", "Kraft (N)"), ColumnMapping())
    assert places(found) == {"time": (0, "s"), "elongation": (1, "mm"), "force": (2, "N")}
    assert found.said == [
        'taken by the usual names: column "Zeit (s)" for the time and column "Weg (mm)" for the elongation and column "Kraft (N)" for the '
        "force; --column says otherwise"
    ]
    one = chosen_columns(table("time_s", "elongation_m", "Kraft (N)"), ColumnMapping())
    assert one.said == ['taken by the usual names: column "Kraft (N)" for the force; --column says otherwise']


def test_options_name_columns_by_name_or_number_and_their_units():
    wanted = ColumnMapping(columns={"time": 1, "elongation": "b", "force": "3"}, units={"time": "s", "elongation": "mm*-1", "force": "V*2"})
    found = chosen_columns(table("a", "b", "c"), wanted)
    assert places(found) == {"time": (0, "s"), "elongation": (1, "mm*-1"), "force": (2, "V*2")}
    assert found.units["elongation"].factor == pytest.approx(-1e-3)
    period = chosen_columns(table("elongation_m", "force_N"), ColumnMapping(sample_period_s=0.1))
    assert places(period) == {"elongation": (0, "m"), "force": (1, "N")}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("d", 'no column "d" for the force; '),
        ("0", 'no column "0" for the force; '),
        ("4", 'no column "4" for the force; '),
    ],
)
def test_a_column_that_is_not_there_is_answered(name, words):
    with pytest.raises(InputError, match=words):
        chosen_columns(table("time_s", "elongation_m", "c"), ColumnMapping(columns={"force": name}, units={"force": "N"}))
    with pytest.raises(InputError, match="the file has no header; give a number from 1 to 3"):
        chosen_columns(table(), ColumnMapping(columns={"force": "d"}))
    with pytest.raises(InputError, match='2 columns are named "c"; give --column force=NUMBER, counted from 1'):
        chosen_columns(table("time_s", "c", "c"), ColumnMapping(columns={"force": "c"}))


def test_what_is_missing_is_said_with_all_options_at_once():
    assert said(table("time_s", "gap", "pull")) == (
        'a.csv, line 3: no column for the elongation and none for the force; found "time_s", "gap", "pull".\n'
        "Add --column elongation=NAME --unit elongation=UNIT --column force=NAME --unit force=UNIT, "
        "or rename them to elongation_m, force_N."
    )


def test_likely_columns_are_proposed_by_name_and_units_that_are_not_there_are_to_be_checked():
    assert said(table("clock", "Weg", "Kraft (N)")) == (
        "a.csv, line 3: no column for the time, none for the elongation and none for the force; "
        'found "clock", "Weg", "Kraft (N)".\n'
        'Add --sample-period SECONDS --column elongation=Weg --unit elongation=mm --column force="Kraft (N)" --unit force=N, or rename '
        "them to time_s, elongation_m, force_N. Not all of this stands in the file: check the units."
    )


def test_without_names_the_column_that_grows_is_the_time_and_the_others_follow():
    raw = table(columns=[LENGTH, GROWING, FORCE], first_row=("0.0", "0", "3"))
    assert said(raw) == (
        "a.csv: no header, so no column for the time, none for the elongation and none for the force; its first row reads 0.0, 0, 3.\n"
        "Add --column time=2 --unit time=s --column elongation=1 --unit elongation=mm --column force=3 --unit force=N or "
        "--sample-period SECONDS. Not all of this stands in the file: check the order of the columns and the units."
    )


def test_a_unit_that_is_missing_unknown_or_of_something_else_is_asked_for():
    assert said(table("time_s", "elongation", "force_N")) == (
        'a.csv: which unit is the elongation in, column 2 "elongation"? None stands there; known: '
        + said(table("time_s", "elongation", "force_N")).split("known: ")[1].split(", or V")[0]
        + ", or V*FACTOR.\nAdd --unit elongation=mm. Not all of this stands in the file: check the units."
    )
    assert '"parsec" is none known here' in said(table("time_s", "elongation (parsec)", "force_N"))
    assert "--unit elongation=UNIT" in said(table("time_s", "elongation (parsec)", "force_N"))
    assert 'the elongation is column 2 "elongation (N)", and N is a unit of force: are two channels swapped?' in said(
        table("time_s", "elongation (N)", "force_N")
    )


def test_two_columns_of_one_quantity_are_counted():
    text = said(table("time_s", "elongation_m", "force (N)", "Force [kN]"))
    assert "a.csv, line 3: 2 columns for the force; found" in text
    assert text.endswith(", or rename it to force_N.")


def test_a_binary_file_shows_its_notes_and_no_line():
    text = said(table("a", "b", "c", lines=False, notes=("speed = 3",)))
    assert text.startswith("a.csv: no column for the time, none for the elongation and none for the force; found")
    assert "\nIt also holds speed = 3.\n" in text


def test_a_name_that_is_hard_to_type_is_named_by_its_number():
    for name, typed in (("Kraft oben", '"Kraft oben"'), ("Kraft", "Kraft"), ("Kraft$;", "3"), ("x" * 60 + " kraft", "3"), ("7", "NAME")):
        assert f"--column force={typed} " in said(table("time_s", "elongation_m", name)) + " "


NAMES = [
    ("Load", "force", 3),
    ("load cell 1", "force", 2),
    ("Standardkraftaufnehmer", "force", 1),
    ("pressure", "force", 0),
    ("Load setpoint", "force", 0),
    ("Weg2", "elongation", 2),
]


@pytest.mark.parametrize(("name", "quantity", "fits"), NAMES)
def test_a_name_is_a_word_holds_one_or_is_made_of_one(name, quantity, fits):
    assert name_fits(name, quantity) == fits
