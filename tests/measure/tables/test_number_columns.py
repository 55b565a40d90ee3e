"""Cells to numbers, lines of a text, and what a table refuses, on a few cells each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.tables.checks import (
    listed,
    no_time,
    require_equal_lengths,
    require_finite,
    require_increasing,
    require_no_infinity,
    require_physical,
)
from measure.tables.number_columns import Dialect, NumberColumns, OddCell, RaggedRow
from measure.tables.raw_table import RawTable, odd_numbers
from measure.tables.text_lines import TextLines


@pytest.mark.parametrize("plain", [True, False])
def test_columns_are_filled_block_by_block(plain):
    """A word in the first block has it read cell by cell; the numbers are the same."""
    table = NumberColumns(3, 4)
    table.add_lines(["1,2.5,-3e2", "4,5,6"] if plain else ["1,2.5,-3e2", "4,5,x"])
    table.add_lines(["7,8,9", "10,11,12"])
    expected = np.array([[1, 4, 7, 10], [2.5, 5, 8, 11], [-300, 6 if plain else np.nan, 9, 12]])
    assert np.array_equal(table.values, expected, equal_nan=True)
    assert table.odd == ([{}, {}, {}] if plain else [{}, {}, {"word": OddCell(1, "x")}])
    assert table.filled == [True, True, True]


def test_what_is_no_finite_number_is_known_by_its_kind_and_first_row():
    table = NumberColumns(2, 6)
    table.add_lines(["1,", "2,"])
    table.add_lines(["3,nan", "4,inf", "5,word", "6,-NaN"])
    assert table.odd[1] == {"empty": OddCell(0, ""), "nan": OddCell(2, "nan"), "infinite": OddCell(3, "inf"), "word": OddCell(4, "word")}
    assert table.filled == [True, True]
    empty = NumberColumns(2, 2)
    empty.add_lines(["1,", "2, "])
    assert empty.filled == [True, False]


@pytest.mark.parametrize("cell", ["1_000", "٣", "1,5", "0x10", "1.2.3"])
def test_what_python_reads_and_a_table_does_not_is_a_word(cell):
    table = NumberColumns(1, 1, Dialect(";"))
    table.add_lines([cell])
    assert table.odd[0] == {"word": OddCell(0, cell)}


def test_decimals_follow_a_comma_where_the_dialect_says_so():
    table = NumberColumns(2, 3, Dialect(";", comma=True))
    table.add_lines(["1,5;-2,25", "3;4,0"])
    table.add_lines(["5.5;6"])
    assert np.array_equal(table.values, [[1.5, 3.0, np.nan], [-2.25, 4.0, 6.0]], equal_nan=True)
    assert table.odd[0] == {"word": OddCell(2, "5.5")}


def test_a_row_of_another_length_is_named_by_its_place_in_the_table():
    table = NumberColumns(2, 5)
    table.add_lines(["1,2", "3,4"])
    with pytest.raises(RaggedRow) as caught:
        table.add_lines(["5,6", "7,8,9", "1"])
    assert (caught.value.row, caught.value.found) == (3, 3)


def test_columns_of_words_are_kept_as_they_stand():
    table = NumberColumns(2, 2, words={1: []})
    table.add_lines(["1, ok", "2,lost "])
    assert table.words == {1: ["ok", "lost"]}
    assert table.values[0].tolist() == [1.0, 2.0]


def test_lines_have_as_many_cells_as_a_dialect_makes_of_them():
    lines = ["1,2,3", "", "4,5", "6,7"]
    assert Dialect(",").sizes(lines) == {3: 1, 2: 2}
    assert Dialect(None).sizes(["1 2  3", "", "4"]) == {3: 1, 1: 1}
    assert Dialect(",").sizes(['"1,2",3', "4,5"]) == {2: 2}
    assert Dialect(",").split('"a,b", c ') == ["a,b", "c"]
    assert Dialect(None).split(" 1   2 ") == ["1", "2"]
    assert Dialect(",").rows(['"open,1', "2,3"]) == [["open,1"], ["2", "3"]]


LINES = ["first", "", *(f"{k},{k * k}" for k in range(60_000))]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("tail", ["", "\n", "\n\n  \n"])
def test_lines_are_those_of_the_text_without_blank_ones_at_its_end(end, tail):
    lines = TextLines(end.join(LINES) + tail.replace("\n", end))
    assert len(lines) == len(LINES)
    assert lines.first() == "first"
    assert lines.last(3) == LINES[-3:]
    assert lines.last(10**6) == LINES
    blocks = list(lines.blocks())
    assert len(blocks) > 1
    assert [line for block in blocks for line in block] == LINES
    assert [line for block in lines.blocks(skipped=2) for line in block] == LINES[2:]
    assert list(lines.blocks(skipped=len(LINES))) == []


def test_a_text_of_blanks_has_no_lines():
    for text in ("", "\n\n", "  \n"):
        lines = TextLines(text)
        assert (len(lines), lines.first(), lines.last(2), list(lines.blocks())) == (0, "", [], [])
    assert (len(TextLines("one")), TextLines("one").first(), TextLines("one").last(2)) == (1, "one", ["one"])


NUMBERS = np.array([1.0, 2.0, np.nan, np.inf])


def test_what_a_table_refuses_is_named_by_its_line():
    """The header is line 1."""
    with pytest.raises(InputError, match=r"a.csv, line 4: force_N is empty or not a number \(2 of 4 rows\)"):
        require_finite(NUMBERS, "force_N", "a.csv")
    with pytest.raises(InputError, match=r"line 3: force_N is inf \(1 of 2 rows\)"):
        require_finite(NUMBERS[[0, 3]], "force_N", "a.csv")
    with pytest.raises(InputError, match="line 5: x_m is infinite"):
        require_no_infinity(NUMBERS, "x_m", "a.csv")
    require_no_infinity(NUMBERS[:3], "x_m", "a.csv")
    with pytest.raises(InputError, match="line 4: time_s goes from 2 to 2; it must increase"):
        require_increasing(np.array([1.0, 2.0, 2.0, 3.0]), "a.csv")
    with pytest.raises(InputError, match="1 rows of data; at least two"):
        require_increasing(np.array([1.0]), "a.csv")
    require_increasing(np.array([1.0, 2.0]), "a.csv")
    with pytest.raises(InputError, match=r"x \(2,\), y \(3,\)"):
        require_equal_lengths("a.csv", {"x": np.zeros(2), "y": np.zeros(3)})
    with pytest.raises(InputError, match="differ in length"):
        require_equal_lengths("a.csv", {"x": np.zeros((2, 2)), "y": np.zeros((2, 2))})
    require_equal_lengths("a.csv", {"x": np.zeros(2), "y": np.zeros(2)})


@pytest.mark.parametrize(("column", "most"), [("time_s", 1e12), ("elongation_m", 1e4), ("force_N", 1e9), ("theta_z_rad", 1e6)])
def test_a_number_that_its_quantity_never_has_is_refused(column, most):
    require_physical(np.array([0.0, -most, most]), column, "a.csv")
    for sign in (1.0, -1.0):
        with pytest.raises(InputError, match=f"line 3: {column} is .* never beyond {most:g}".replace("+", "[+]")):
            require_physical(np.array([0.0, sign * 1.01 * most]), column, "a.csv")


def test_twenty_names_are_listed_and_the_others_counted():
    assert listed(["a", "b"]) == '"a", "b"'
    assert listed(["x"] * 20) == ", ".join(['"x"'] * 20)
    assert listed(["x"] * 22).endswith('"x" and 2 more')
    assert no_time("a.csv", ["t"]) == 'a.csv: no column time_s; found "t". Rename the column of the time, in seconds, to time_s.'


def test_a_row_of_a_text_has_its_line_and_one_of_a_binary_file_its_sample():
    values = [np.array([1.0, np.nan, np.inf, np.nan])]
    text = RawTable(Path("a.csv"), values, lines=[3, 4, 6, 7], odd=[odd_numbers(values[0])])
    assert text.where(2) == "a.csv, line 6"
    assert RawTable(Path("a.mat"), values).where(2) == "a.mat, sample 3"
    assert text.first_odd(0) == OddCell(1, "nan")
    assert text.first_odd(0, ("infinite",)) == OddCell(2, "inf")
    assert text.first_odd(0, ("word",)) is None
    assert len(text) == 4
    assert len(RawTable(Path("a.csv"), [])) == 0
