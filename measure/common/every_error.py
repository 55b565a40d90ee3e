"""Everything that is wrong with several things, at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from measure.common.errors import InputError, OptionsMissing

Given = TypeVar("Given")
Made = TypeVar("Made")


def for_each(function: Callable[[Given], Made], items: Iterable[Given]) -> list[Made]:
    """What a function makes of each item.

    Raises
    ------
    InputError
        It refuses some; one error then holds what it says of each of these, once where it says the same of several.
    """
    made: list[Made] = []
    wrong: dict[str, list[str]] = {}
    errors: list[InputError] = []
    for item in items:
        try:
            made.append(function(item))
        except InputError as error:
            errors.append(error)
            wrong.setdefault(str(error).replace(str(item), "\0"), []).append(str(item))
    if errors:
        raise _joined(errors, "\n".join(_sentence(said, names) for said, names in wrong.items()))
    return made


def _sentence(said: str, names: Sequence[str]) -> str:
    others = list(dict.fromkeys(names[1:]))
    return said.replace("\0", names[0]) + (f"\nThe same with {', '.join(others)}." if others and "\0" in said else "")


def _joined(errors: Sequence[InputError], text: str) -> InputError:
    """One error for several; where the same options settle all of them, one that carries these."""
    options = {error.options if isinstance(error, OptionsMissing) else "" for error in errors}
    only = options.pop() if len(options) == 1 else ""
    return OptionsMissing(text, only) if only else InputError(text)
