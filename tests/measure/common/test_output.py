"""What is written is whole or absent, is the same for the same input, and says what made it."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from measure.common import output
from measure.common.errors import InputError

scalars = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text())
values = st.recursive(scalars, lambda inner: st.one_of(st.lists(inner), st.dictionaries(st.text(), inner), st.tuples(inner)), max_leaves=12)


def refuse_constants(word):
    raise AssertionError(f"{word} is not JSON")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def crash(path):
    """Break down in the middle of writing."""
    with output.replacing(path) as temporary:
        temporary.write_text("half of")
        raise ZeroDivisionError


@settings(max_examples=40)
@given(st.dictionaries(st.text(), values))
def test_json_holds_no_nan_and_no_infinity_however_deep(result):
    json.loads(output.json_text(result), parse_constant=refuse_constants)


def test_a_value_that_could_not_be_computed_is_null():
    result = {"rms": np.float64("nan"), "row": np.array([1.0, np.inf]), "verdict": "ok", "n": np.int64(3), "usable": np.bool_(True)}
    assert json.loads(output.json_text(result)) == {"rms": None, "row": [1.0, None], "verdict": "ok", "n": 3, "usable": True}


def test_numbers_in_json_keep_their_last_digit():
    value = 0.1 + 0.2
    assert json.loads(output.json_text({"a": np.array([value]), "b": value})) == {"a": [value], "b": value}


def test_paths_and_letters_of_formulas_are_written_as_they_are():
    assert output.json_text({"file": Path("a") / "b.csv", "of": "β"}) == '{\n  "file": "a/b.csv",\n  "of": "β"\n}\n'


@pytest.mark.parametrize("name", ["caf\udce9.csv", Path("caf\udce9.csv")])
def test_a_name_that_is_not_utf8_is_written_escaped(tmp_path, name):
    output.write_json(tmp_path / "r.json", {"file": name, str(name): [name]})
    assert json.loads((tmp_path / "r.json").read_bytes()) == {"file": "caf\\udce9.csv", "caf\\udce9.csv": ["caf\\udce9.csv"]}


def test_the_same_result_gives_the_same_bytes(tmp_path):
    for name in ("first.json", "second.json"):
        output.write_json(tmp_path / name, {"a": np.arange(3.0), "b": {"c": float("nan")}})
    assert (tmp_path / "first.json").read_bytes() == (tmp_path / "second.json").read_bytes()


def test_a_crash_while_writing_leaves_the_old_file_whole(tmp_path):
    path = tmp_path / "result.json"
    output.write_text(path, "old")
    with pytest.raises(ZeroDivisionError):
        crash(path)
    assert path.read_text() == "old"
    assert names(tmp_path) == ["result.json"]


def test_a_crash_while_writing_leaves_nothing_where_nothing_was(tmp_path):
    with pytest.raises(ZeroDivisionError):
        crash(tmp_path / "result.json")
    assert names(tmp_path) == []


def test_a_file_in_the_making_does_not_show_under_its_name(tmp_path):
    path = tmp_path / "result.json"
    with output.replacing(path) as temporary:
        temporary.write_text("whole")
        assert not path.exists()
    assert path.read_text() == "whole"
    assert names(tmp_path) == ["result.json"]


def test_a_folder_that_does_not_exist_is_refused_and_not_made(tmp_path):
    with pytest.raises(InputError, match=r"cannot be written \(No such file or directory\)\. Name a folder that exists"):
        output.write_text(tmp_path / "no" / "result.json", "text")
    assert names(tmp_path) == []


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="nothing is forbidden to the superuser")
def test_a_folder_that_forbids_writing_is_refused_and_keeps_what_it_had(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="cannot be written"):
        output.write_text(tmp_path / "result.json", "text")
    tmp_path.chmod(0o700)
    assert names(tmp_path) == []


def test_a_file_is_not_written_over_a_folder(tmp_path):
    (tmp_path / "sweep").mkdir()
    with pytest.raises(InputError, match="is a folder, and a file is to be written"):
        output.write_text(tmp_path / "sweep", "text")
    assert names(tmp_path) == ["sweep"]


def test_a_pipe_or_a_device_is_never_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/null"), Path("/dev/stdout")):
        with pytest.raises(InputError, match="is a device or a pipe"):
            output.write_text(path, "text")
    assert Path("/dev/null").is_char_device()
    assert (tmp_path / "pipe").is_fifo()


def test_a_link_stays_a_link_and_the_file_behind_it_is_replaced(tmp_path):
    (tmp_path / "real.json").write_text("old")
    (tmp_path / "latest.json").symlink_to("real.json")
    output.write_text(tmp_path / "latest.json", "new")
    assert (tmp_path / "latest.json").is_symlink()
    assert (tmp_path / "real.json").read_text() == "new"


def test_others_may_read_what_was_written_as_far_as_the_user_allows(tmp_path):
    before = os.umask(0o027)
    try:
        output.write_text(tmp_path / "result.json", "text")
        assert os.umask(0o027) == 0o027
    finally:
        os.umask(before)
    assert (tmp_path / "result.json").stat().st_mode & 0o777 == 0o640


def test_lines_end_alike_on_every_system(tmp_path):
    output.write_text(tmp_path / "a.txt", "one\ntwo\n")
    assert (tmp_path / "a.txt").read_bytes() == b"one\ntwo\n"


def test_provenance_names_inputs_by_content_and_holds_no_time(tmp_path, monkeypatch):
    loop = tmp_path / "loop.csv"
    loop.write_text("abc")
    first = output.provenance([loop], seed=3, command=["somewhere/bin/fit-actuator", "loop.csv"])
    monkeypatch.setattr("time.time", lambda: 4e9)
    os.utime(loop, (1.0, 1.0))
    assert output.provenance([loop], seed=3, command=["elsewhere/fit-actuator", "loop.csv"]) == first
    assert set(first) == {"command", "inputs", "versions", "seed"}
    assert first["command"] == "fit-actuator loop.csv"
    # SHA-256 of "abc" as FIPS 180-2, appendix B.1, prints it
    assert first["inputs"][0]["sha256"] == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert {"python", "unspool", "numpy", "numba", "lmfit"} <= set(first["versions"])


def test_without_chance_there_is_no_seed():
    assert "seed" not in output.provenance(command=["track-video"])


def test_the_command_is_by_default_that_of_the_process(monkeypatch):
    monkeypatch.setattr("sys.argv", ["/some/where/track-video", "film.avi"])
    assert output.provenance()["command"] == "track-video film.avi"


def test_a_folder_is_known_by_its_files_and_their_names(tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    for folder in (first, second):
        (folder / "inner").mkdir(parents=True)
        (folder / "inner" / "0001.tif").write_text("picture")
        (folder / "0002.tif").write_text("another")
    assert output.sha256(first) == output.sha256(second)
    (second / "0002.tif").rename(second / "0003.tif")
    assert output.sha256(first) != output.sha256(second)


def test_the_note_stands_beside_the_table(tmp_path):
    beside = output.write_provenance(tmp_path / "drift.csv", {"seed": 1})
    assert beside == tmp_path / "drift.csv.provenance.json"
    assert json.loads(beside.read_text()) == {"seed": 1}
