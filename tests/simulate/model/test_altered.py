"""A model with other values is the one that `dataclasses.replace` makes, and keeps nothing that was worked out from the old ones."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import pytest

from simulate.model.rig import altered


@dataclass(frozen=True)
class Square:
    side: float

    @cached_property
    def area(self) -> float:
        return self.side**2


@dataclass(frozen=True)
class Tile:
    square: Square
    name: str = ""


def test_it_is_what_replace_makes():
    tile = Tile(Square(2.0), "grey")
    assert altered(tile, square=altered(tile.square, side=3.0)) == replace(tile, square=Square(3.0))
    assert tile.square.side == 2.0


def test_what_was_worked_out_from_the_old_values_is_forgotten():
    square = Square(2.0)
    assert square.area == 4.0
    assert altered(square, side=3.0).area == 9.0


def test_it_is_as_frozen_as_before():
    with pytest.raises(AttributeError):
        altered(Tile(Square(2.0)), name="white").name = "again"  # type: ignore[misc]
