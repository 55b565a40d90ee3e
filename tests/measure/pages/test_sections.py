"""Bars and tables of pages, and pictures of films for them."""

from __future__ import annotations

import base64
from urllib.parse import unquote

import cv2
import numpy as np
import pytest

from measure.pages.picture import brightest, embedded, reduced, shown
from measure.pages.sections import Bars, Table


def test_the_longest_bar_is_as_wide_as_there_is_room_and_what_is_below_nought_has_another_colour():
    rows = Bars("b", "", "share, %", {"one": 20.0, "two": -40.0, "three": 0.0}).rows
    assert [row["name"] for row in rows] == ["one", "two", "three"]
    assert [row["share"] for row in rows] == pytest.approx([0.5, 1.0, 0.0])
    assert [row["look"] for row in rows] == ["effect", "given", "effect"]
    assert [float(row["text"].replace("\u2212", "-")) for row in rows] == [20.0, -40.0, 0.0]


def test_bars_of_nothing_have_no_width():
    assert [row["share"] for row in Bars("b", "", "n", {"one": 0.0}).rows] == [0.0]
    assert Bars("b", "", "n", {"tiny": 0.25}).rows[0]["share"] == 1.0
    assert Bars("b", "", "n", {}).rows == []


def test_bars_and_tables_can_be_had_as_csv():
    bars = Bars("b", "", "share, %", {"one": 20.0, "two": -40.0}, of="effect")
    assert bars.heads == ["effect", "share, %"]
    assert unquote(bars.csv).partition(",")[2].splitlines()[1:] == ["one,20.0", "two,-40.0"]
    assert Bars("b", "", "n", {}).heads[0] == "name"
    table = Table("t", "", ["a", "b"], [["x", 1.5], ["y", 2.5]])
    assert unquote(table.csv).partition(",")[2].splitlines() == ["a,b", "x,1.5", "y,2.5"]


def test_white_is_what_all_but_a_thousandth_of_the_pixels_are_darker_than():
    picture = np.full((100, 100), 40, np.uint16)
    picture.ravel()[:5] = 4000
    assert brightest(picture) == 40.0
    picture.ravel()[:50] = 200
    assert brightest(picture) == 200.0
    assert brightest(np.zeros((4, 4))) == 1.0
    assert shown(np.array([[0.0, 20.0, 40.0, 4000.0]]), 40.0).tolist() == [[0, 128, 255, 255]]


def test_an_embedded_picture_is_the_picture():
    picture = np.random.default_rng(0).integers(0, 255, (9, 13), dtype=np.uint8)
    kind, _, text = embedded(picture).partition(",")
    assert kind == "data:image/png;base64"
    decoded = cv2.imdecode(np.frombuffer(base64.b64decode(text), np.uint8), cv2.IMREAD_UNCHANGED)
    assert decoded is not None
    assert np.array_equal(decoded, picture)
    assert embedded(picture, 70).startswith("data:image/jpeg;base64,/9j")
    assert len(embedded(picture, 10)) < len(embedded(picture, 95))


@pytest.mark.parametrize(("shape", "largest", "size"), [((40, 100), 50, (20, 50)), ((100, 40), 50, (50, 20)), ((40, 100), 100, (40, 100))])
def test_a_picture_is_reduced_to_its_larger_side_and_never_enlarged(shape, largest, size):
    picture = np.full(shape, 7, np.uint8)
    assert reduced(picture, largest).shape == size
    assert reduced(picture, largest).max() == 7
    assert reduced(picture, 500) is picture
