"""Numbers as words of a command line or of a file of notes: one way to read them, finite and plain."""

from __future__ import annotations

import re
from argparse import ArgumentTypeError
from collections.abc import Callable

from measure.common.errors import InputError, clipped

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_WHOLE = re.compile(r"[+-]?\d{1,18}", re.ASCII)
_LONGEST = 40


def number_in(text: str) -> float:
    """The finite number that a text is; `1_0`, digits of other scripts, `nan`, `inf` and 1e999 are none.

    Raises
    ------
    InputError
    """
    shown = text.strip()
    value = float(shown) if len(shown) <= _LONGEST and _NUMBER.fullmatch(shown) else float("inf")
    if abs(value) == float("inf"):
        raise InputError(f'"{clipped(text)}" is not a finite number')
    return value


def number(low: float = float("-inf"), high: float = float("inf"), *, above: float = float("-inf")) -> Callable[[str], float]:
    """The `type` of an option that is a number within bounds; `above` it, not at it."""

    def parse(text: str) -> float:
        try:
            value = number_in(text)
        except InputError as error:
            raise ArgumentTypeError(str(error)) from None
        if not (low <= value <= high and value > above):
            least = f"above {above:g}" if above > low else f"at least {low:g}"
            raise ArgumentTypeError(f"{clipped(text)} cannot be; give a number {least}{_and_at_most(high)}")
        return value

    return parse


def whole(low: int, high: int) -> Callable[[str], int]:
    """The `type` of an option that is a whole number within bounds."""

    def parse(text: str) -> int:
        if not _WHOLE.fullmatch(text.strip()):
            raise ArgumentTypeError(f'"{clipped(text)}" is not a whole number')
        if not low <= int(text) <= high:
            raise ArgumentTypeError(f"{text} cannot be; give a whole number at least {low}{_and_at_most(high)}")
        return int(text)

    return parse


def _and_at_most(high: float) -> str:
    return "" if high == float("inf") else f" and at most {high:g}"
