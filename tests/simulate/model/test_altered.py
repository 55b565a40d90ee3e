"""A model with other values is the one that `dataclasses.replace` makes, and keeps nothing that was worked out from the old ones."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import pytest

from simulate.model.altered import altered


@dataclass(frozen=True)
class Square:
    side: float

    @cached_property
    def area(self) -> float:
        return self.side**2


def test_it_is_what_replace_makes(prototype):
    heavier = altered(prototype, platform=altered(prototype.platform, mass_kg=0.9))
    assert heavier == replace(prototype, platform=replace(prototype.platform, mass_kg=0.9))
    assert prototype.platform.mass_kg != 0.9


def test_what_was_worked_out_from_the_old_values_is_forgotten():
    square = Square(2.0)
    assert square.area == 4.0
    assert altered(square, side=3.0).area == 9.0


def test_it_is_as_frozen_as_before(prototype):
    with pytest.raises(AttributeError):
        altered(prototype, name="other").name = "again"
