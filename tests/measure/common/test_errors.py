"""Unusable input is answered in a sentence that helps."""

from __future__ import annotations

import pytest

from measure.common.errors import InputError, clipped, found, nearest, visible


@pytest.mark.parametrize(("word", "meant"), [("elongaton_m", "elongation_m"), ("force_n", "force_N"), ("time", "time_s")])
def test_a_word_with_a_slip_is_answered_with_the_word_that_was_meant(word, meant):
    assert nearest(word, ["time_s", "elongation_m", "force_N"]) == f'did you mean "{meant}"?'


def test_a_word_like_no_other_is_answered_with_all_that_are_known():
    assert nearest("banana", ["time_s", "force_N"]) == "known: time_s, force_N."


def test_known_words_may_come_from_an_iterator():
    assert nearest("banana", iter(["time_s", "force_N"])) == "known: time_s, force_N."


def test_callers_who_catch_value_errors_catch_unusable_input():
    with pytest.raises(ValueError, match="line 3"):
        raise InputError("loop.csv, line 3: 2 cells and 3 columns.")


@pytest.mark.parametrize("key", ["k" * 100_000, "k " * 50_000, "k" + " " * 100_000 + "k", "力" * 100_000])
def test_a_sentence_shows_what_is_endless_by_its_beginning(key):
    """Whatever reader says it: a damaged file is not poured over the screen."""
    said = str(InputError(f'rig.toml: unknown key "{key}"; known: schema.\nno [actuator]; give one.'))
    assert len(said) < 1200
    assert said.startswith('rig.toml: unknown key "k') or "力" in said
    assert said.endswith("\nno [actuator]; give one.")
    assert str(InputError("\n" * 100_000)).count("\n") == 500
    name = "/".join(["folder-of-a-laboratory"] * 40)
    assert name in str(InputError(f"{name}: no such file; a table (CSV) was expected."))


@pytest.mark.parametrize("byte", [0x80, 0x81, 0xBF, 0xC3, 0xFF])
def test_a_byte_of_a_name_that_is_not_utf_8_is_shown_as_python_shows_it(byte):
    name = b"rig" + bytes([byte])
    assert visible(name.decode("utf-8", "surrogateescape")) == name.decode("utf-8", "backslashreplace")


def test_what_commands_a_terminal_is_escaped_and_all_else_is_left():
    assert visible("\x1b[2J\x07") == "\\x1b[2J\\x07"
    assert visible("Prüfkraft 力 µ") == "Prüfkraft 力 µ"


def test_a_value_is_shown_as_it_was_found_and_an_endless_one_by_its_kind():
    assert [found(value) for value in (True, 3, "a", None)] == ["True", "3", "'a'", "None"]
    assert [found(value) for value in ([1, 2], (1,), {"a": 1})] == ["a list of 2", "a list of 1", "a table of 1"]
    assert found(10**99) == "a whole number of some 99 digits"
    assert clipped("x" * 300, 10) == "xxxxxxxxxx... (300 characters)"
    assert clipped("x" * 10, 10) == "x" * 10
