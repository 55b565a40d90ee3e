"""Everything that is wrong with several things, at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from measure.common.errors import InputError

Given = TypeVar("Given")
Made = TypeVar("Made")


def for_each(function: Callable[[Given], Made], items: Iterable[Given]) -> list[Made]:
    """What a function makes of each item.

    Raises
    ------
    InputError
        It refuses some; one error then holds what it says of each of these.
    """
    made, wrong = [], []
    for item in items:
        try:
            made.append(function(item))
        except InputError as error:
            wrong.append(str(error))
    if wrong:
        raise InputError("\n".join(dict.fromkeys(wrong)))
    return made
