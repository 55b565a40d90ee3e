"""Only regular files of a sane size are read, TOML ends, numbers are plain; what is shown of a foreign file cannot command a terminal."""

from __future__ import annotations

import math
import os
import random
import socket
import string
import time
from argparse import ArgumentTypeError

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from measure.common.errors import InputError, clipped, found, visible
from measure.common.inputs import LARGEST_TABLE, existing_file, number, number_in, parsed_toml, read_toml, whole
from measure.readers.text.encoding import decoded
from measure.tables.csv_cells import read_columns


def refusal(function, *given, **named):
    with pytest.raises(InputError) as refused:
        function(*given, **named)
    return str(refused.value)


def test_what_is_no_regular_file_is_refused_with_the_true_reason(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind("socket")
    (tmp_path / "round").symlink_to("round")
    (tmp_path / "lost").symlink_to("nowhere")
    (tmp_path / "zero").symlink_to("/dev/zero")
    (tmp_path / "folder").mkdir()
    reasons = {
        "pipe": "is a pipe",
        "socket": "is a socket",
        "round": "leads back to itself",
        "lost": "link to nowhere",
        "zero": "is a device",
    }
    reasons |= {"folder": "is a folder", "none": "no such file", "x" * 300: "no such file", "a\0b": "no such file"}
    for name, words in reasons.items():
        assert words in refusal(existing_file, tmp_path / name, what="a loop"), name


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="nothing is forbidden to the superuser")
def test_a_file_that_may_not_be_read_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("")
    (tmp_path / "a.csv").chmod(0)
    assert "may not be read" in refusal(existing_file, tmp_path / "a.csv", what="a loop")


def test_a_file_that_only_others_may_read_is_said_to_be(tmp_path, monkeypatch):
    (tmp_path / "a.csv").write_text("")
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.R_OK)  # the superuser may read everything
    assert "may not be read" in refusal(existing_file, tmp_path / "a.csv", what="a loop")


@pytest.mark.parametrize("read", [read_columns, lambda path: decoded(path, None), lambda path: read_toml(path, what="a model", advice="")])
@pytest.mark.parametrize("size", [LARGEST_TABLE + 1, 10**12])
def test_a_sparse_file_of_a_terabyte_is_refused_before_it_is_read(tmp_path, read, size):
    with open(tmp_path / "sparse", "wb") as file:
        file.truncate(size)
    begun = time.process_time()
    assert "MB, and " in refusal(read, tmp_path / "sparse")
    assert time.process_time() - begun < 0.5


@pytest.mark.parametrize("head", [bytes(5000), b"\x89PNG\r\n\x1a\n\0\0", b"RIFF\0\0\0\0AVI ", b"\x7fELF\x02\0"])
def test_a_file_of_another_kind_is_known_by_its_first_bytes(tmp_path, head):
    (tmp_path / "table.csv").write_bytes(head + b"1,2\n" * 100)
    for read in (read_columns, lambda path: decoded(path, None)):
        assert "is not text but" in refusal(read, tmp_path / "table.csv")


@pytest.mark.parametrize("name", ["idna", "punycode", "unicode_escape", "undefined", "rot13", "hex", "utf-7", "no-such", "\0"])
def test_an_encoding_that_no_table_is_written_in_is_refused(tmp_path, name):
    (tmp_path / "table.csv").write_text("a,b\n1,2\n")
    assert "no such encoding" in refusal(decoded, tmp_path / "table.csv", name)


def toml_refusal(text):
    with pytest.raises(ValueError) as refused:  # noqa: PT011
        parsed_toml(text)
    return str(refused.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = " + "[" * 50 + "]" * 50, "nested"),
        ("x = " + "[" * 20000 + "]" * 20000, "nested"),
        ("x = " + "{a = " * 900 + "1" + "}" * 900, "nested"),
        ("x = " + "9" * 5000, "thousands of digits"),
        ("x = " + "9" * 4000, "beyond 64 bits"),
        ("x = 0x" + "f" * 100000, "beyond 64 bits"),
        ("x = [1, 99999999999999999999]", "beyond 64 bits"),
        (".".join("a" * 100000) + " = 1", "parts"),
        ('"a"  .  ' * 100000 + "b = 1", "parts"),
        ("[" + ".".join("b" * 40) + "]", "parts"),
        ('x = "\x1b[2J', "Illegal"),
    ],
)
def test_toml_that_would_not_end_or_breaks_the_reader_is_a_sentence(text, words):
    begun = time.process_time()
    assert words in toml_refusal(text)
    assert time.process_time() - begun < 2.0


def test_toml_of_a_real_model_and_a_long_command_is_read(tmp_path):
    command = "fit-actuator " + " ".join(f"loops/run_{k}.5Hz.csv" for k in range(500))
    text = f'schema = 1\n[provenance]\ncommand = "{command}"\n[a.b.c]\nrow = [{", ".join(["0.5"] * 5000)}]\n'
    assert parsed_toml(text)["provenance"]["command"] == command
    (tmp_path / "m.toml").write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert read_toml(tmp_path / "m.toml", what="a model", advice="")["schema"] == 1


@pytest.mark.parametrize(
    "text", ["1_0", "nan", "inf", "-inf", "1e999", "1e9999999999", "0x10", "٣", "", " ", "1,5", "true", "1" * 50, "--1", "1e", "."]
)
def test_what_is_no_plain_finite_number_is_none(text):
    with pytest.raises(InputError, match="is not a finite number"):
        number_in(text)
    with pytest.raises(ArgumentTypeError, match="is not a finite number"):
        number()(text)
    with pytest.raises(ArgumentTypeError, match="is not a whole number"):
        whole(0, 10)(text)


@given(st.floats(allow_nan=False, allow_infinity=False))
@example(-0.0)
def test_every_finite_number_is_read_as_python_writes_it(value):
    assert math.copysign(1.0, number_in(repr(value))) == math.copysign(1.0, value)
    assert number_in(repr(value)) == value


def test_a_number_beyond_its_bounds_is_refused_with_them():
    with pytest.raises(ArgumentTypeError, match="at least 1 and at most 9"):
        whole(1, 9)("10")
    with pytest.raises(ArgumentTypeError, match="above 0"):
        number(above=0.0)("0")


@given(st.text())
def test_what_is_shown_cannot_command_a_terminal_and_can_be_written(text):
    shown = visible(text)
    shown.encode("utf-8")
    assert not any((ord(letter) < 32 and letter != "\n") or 127 <= ord(letter) < 160 for letter in shown)
    assert not set(shown) & set("\u202a\u202b\u202d\u202e\u2066\u2067\u2068\u2069\u200e\u200f\ufeff")


def test_letters_of_formulas_and_of_people_stay_as_they_are():
    assert visible("β = 400 1/m, Müller, 測定\n") == "β = 400 1/m, Müller, 測定\n"
    assert visible("a\x1b[2Jb\udcff") == r"a\x1b[2Jb\xff"


@pytest.mark.parametrize("seed", range(20))
def test_of_a_foreign_file_no_more_than_a_cell_is_shown(tmp_path, seed):
    chance = random.Random(seed)
    secret = "".join(chance.choices(string.ascii_letters, k=200))
    line = chance.choice([f"{secret}", f"user:{secret}:x", f"a {secret} b", f"1,{secret}", f"key={secret}"])
    (tmp_path / "secret").write_text((line + "\n") * 30)
    from measure.readers.measurement import read_measurement

    assert secret[:80] not in refusal(read_measurement, tmp_path / "secret")


def test_what_was_found_is_shown_in_short():
    assert [found(value) for value in ([1] * 9, {"a": 1}, "é", True)] == ["a list of 9", "a table of 1", "'é'", "True"]
    assert found("x" * 1000) == "'" + "x" * 59 + "... (1002 characters)"
    assert found(10**5000) == "a whole number of some 5000 digits"


def test_a_long_text_is_shown_by_its_beginning():
    assert clipped("x" * 1000) == "x" * 60 + "... (1000 characters)"
