"""One table in every shape that programs write JSON in, and vectors of a binary file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.readers.formats.json_table import looks_like_json, read_json
from measure.readers.formats.vectors import LARGEST_UNPACKED, Vectors, numbers_of, require_unpacked, table_of
from measure.tables.number_columns import OddCell

T, U, F = [0.0, 0.5, 1.0], [1.0, 2.0, 1.5], [3.0, 2.5, None]
ROWS = [list(row) for row in zip(T, U, F, strict=True)]
RECORDS = [{"t": t, "u": u, "f": f} for t, u, f in ROWS]

SHAPES = {
    "columns": {"t": T, "u": U, "f": F},
    "records": RECORDS,
    "records within": {"test": "a", "samples": RECORDS},
    "names and rows": {"columns": ["t", "u", "f"], "data": ROWS},
    "names as objects": {"fields": [{"name": "t"}, {"label": "u"}, {"name": "f"}], "rows": ROWS},
    "names and columns": {"header": ["t", "u"], "values": [T, U]},
    "as pandas writes a frame": {k: dict(enumerate(v)) for k, v in (("t", T), ("u", U), ("f", F))},
    "objects of channels": [{"name": "t", "data": T}, {"name": "u", "data": U}, {"name": "f", "data": F}],
}


def read(tmp_path, document, name="a.json"):
    (tmp_path / name).write_text(document if isinstance(document, str) else json.dumps(document))
    found = read_json(tmp_path / name)
    assert found is not None
    return found


@pytest.mark.parametrize("shape", SHAPES)
def test_the_same_columns_come_out_of_every_shape(tmp_path, shape):
    found = read(tmp_path, SHAPES[shape])
    names = [name.rpartition(".")[2] for name in found.header]
    assert names == (["t", "u"] if shape == "names and columns" else ["t", "u", "f"])
    for column, expected in zip(found.columns, (T, U, [3.0, 2.5, np.nan]), strict=False):
        assert np.array_equal(column, expected, equal_nan=True)
    assert found.written == "JSON"
    if len(names) == 3:
        assert found.odd[2] == {"nan": OddCell(2, "nan")}


def test_records_may_stand_one_in_each_line(tmp_path):
    found = read(tmp_path, "\n".join(map(json.dumps, RECORDS)) + "\n", "a.jsonl")
    assert found.header == ("t", "u", "f")
    assert found.columns[1].tolist() == U


def test_rows_without_names_are_numbered_from_one(tmp_path):
    assert read(tmp_path, ROWS).header == ("data[1]", "data[2]", "data[3]")
    assert read(tmp_path, {"run": ROWS}).header == ("run[1]", "run[2]", "run[3]")
    assert read(tmp_path, {"columns": ["t", "u"], "data": ROWS}).header == ("data[1]", "data[2]", "data[3]")


def test_units_stand_beside_the_data_or_behind_the_names(tmp_path):
    channels = {"force": {"unit": "kN", "data": F}, "elongation": {"units": "mm", "values": U}, "rate": 500, "operator": "Mo"}
    found = read(tmp_path, channels)
    assert dict(zip(found.header, found.units, strict=True)) == {"force": "kN", "elongation": "mm"}
    assert set(found.notes) == {"rate = 500", "operator = Mo"}
    named = read(tmp_path, {"fields": [{"name": "t", "unit": "s"}, {"name": "u", "units": "mm"}, {"name": "f"}], "rows": ROWS})
    assert named.header == ("t [s]", "u [mm]", "f")


def test_inner_tables_have_dotted_names_down_to_the_sixth_level(tmp_path):
    document = {"t": T, "u": U}
    for level in range(5, 0, -1):
        document = {f"l{level}": document}
    assert read(tmp_path, document).header == ("l1.l2.l3.l4.l5.t", "l1.l2.l3.l4.l5.u")
    with pytest.raises(InputError, match="holds no vector of numbers"):
        read(tmp_path, {"l0": document})


def test_a_key_that_some_records_lack_is_a_gap(tmp_path):
    found = read(tmp_path, [{"t": 0.0, "u": 1.0}, {"t": 1.0}, {"t": 2.0, "u": 3.0, "v": 4.0}])
    assert found.header == ("t", "u", "v")
    assert np.array_equal(found.columns, [[0.0, 1.0, 2.0], [1.0, np.nan, 3.0], [np.nan, np.nan, 4.0]], equal_nan=True)


def test_stamps_are_seconds_and_words_and_truths_are_no_columns(tmp_path):
    stamps = ["2024-01-01T00:00:00", "2024-01-01T00:00:01.5", "2024-01-01T00:00:03"]
    found = read(tmp_path, {"when": stamps, "u": U, "who": ["a", "b", "c"], "on": [True, False, True], "huge": [1, 2, 10**400]})
    assert found.header == ("when", "u")
    assert found.columns[0] == pytest.approx([0.0, 1.5, 3.0])
    assert found.units == ("s", "")


def test_rows_of_different_lengths_are_no_table(tmp_path):
    with pytest.raises(InputError, match="holds no vector of numbers"):
        read(tmp_path, [[1.0, 2.0], [3.0]])


HEADS = [(b'{"a": [1]}', True), (b"[1, 2]", True), (b"\xef\xbb\xbf \n[[1]]", True), (b"[-1]", True)]
NO_HEADS = [(b"{a: 1}", False), (b"[Header]", False), (b"1, 2", False), (b"", False)]


@pytest.mark.parametrize(("head", "is_json"), HEADS + NO_HEADS)
def test_a_text_may_be_json_by_its_bracket_and_what_stands_behind_it(head, is_json):
    assert looks_like_json(head) == is_json


def test_a_text_that_is_no_json_is_refused_where_its_name_says_so(tmp_path):
    (tmp_path / "a.txt").write_text("[1, 2")
    assert read_json(tmp_path / "a.txt") is None
    with pytest.raises(InputError, match="is not JSON"):
        read(tmp_path, "[1, 2")


def test_vectors_of_the_most_common_length_are_columns_and_single_numbers_notes():
    found = Vectors()
    found.add("a", np.arange(4.0), "N")
    found.add("m", np.arange(8.0).reshape(4, 2))
    found.add("row", np.arange(3.0)[None])
    found.add("rate", np.array([[250.0]]))
    found.add("cube", np.zeros((2, 2, 2)))
    made = table_of(Path("a.mat"), "MATLAB", found)
    assert made.header == ("a", "m[1]", "m[2]")
    assert made.columns[2].tolist() == [1.0, 3.0, 5.0, 7.0]
    assert (made.units, made.notes, made.written) == (("N", "", ""), ("rate = 250",), "MATLAB")
    wide = Vectors()
    wide.add("w", np.zeros((3, 60)))
    assert len(wide.values) == 50
    with pytest.raises(InputError, match=r"no two vectors of one length; found a \(4\), b \(3\)"):
        table_of(Path("a.mat"), "MATLAB", Vectors({"a": np.zeros(4), "b": np.zeros(3)}))
    with pytest.raises(InputError, match="no two vectors of one length"):
        table_of(Path("a.mat"), "MATLAB", Vectors({"a": np.zeros(1), "b": np.zeros(1)}))
    assert len(table_of(Path("a.mat"), "MATLAB", Vectors({"a": np.zeros(2), "b": np.zeros(2)}))) == 2


def test_vectors_survive_the_disk(tmp_path):
    found = Vectors({"a b": np.arange(3.0), "c": np.array([1.0, np.nan])}, {"a b": "N", "c": ""}, ["note = 1"])
    found.save(tmp_path / "v.npz")
    again = Vectors.load(tmp_path / "v.npz")
    assert (again.units, again.notes, list(again.values)) == (found.units, found.notes, ["a b", "c"])
    assert all(np.array_equal(again.values[name], found.values[name], equal_nan=True) for name in found.values)


def test_numbers_are_numbers_and_instants_seconds_since_the_first():
    stamps = np.array(["2024-01-01T00:00:00", "2024-01-01T00:00:01.25"], "M8[ms]")
    seconds = numbers_of(stamps)
    assert seconds is not None
    assert seconds == pytest.approx([0.0, 1.25])
    for kind in ("i2", "u1", "f4", "?"):
        assert numbers_of(np.ones(2, kind)) is not None
    assert numbers_of(np.array(["a", "b"])) is None
    assert numbers_of(np.array([], "M8[s]")) is None


def test_more_numbers_than_a_loop_has_are_refused_unread():
    require_unpacked(Path("a.mat"), LARGEST_UNPACKED)
    with pytest.raises(InputError, match="50000000 are the most for a loop"):
        require_unpacked(Path("a.mat"), LARGEST_UNPACKED + 1)
