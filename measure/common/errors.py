"""The one way to say that an input cannot be used, and to show what was found in it."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

# Control characters but the line end, what turns the direction of writing or has no width, and bytes of names that are not UTF-8.
_UNSEEN = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff\ud800-\udfff]")
_LONGEST_SHOWN = 60
_ENDLESS_WORD, _LONGEST_LINE, _MOST_LINES = 1000, 5000, 500
_ENDLESS = re.compile(rf"\S{{{_ENDLESS_WORD},}}|[^\S\n]{{{_ENDLESS_WORD},}}")


class InputError(ValueError):
    """Unusable input: file, place, what was found and what to do, in one sentence or two.

    Commands print it behind their name on standard error and leave with status 2, with nothing written. A word of a thousand signs, such as
    a key of a damaged file, a line of five thousand and what has more than five hundred lines are shown by their beginnings.
    """

    def __init__(self, text: str = "") -> None:
        super().__init__(_shortened(text) if len(text) >= _ENDLESS_WORD else text)


class OptionsMissing(InputError):
    """What could be read in more than one way, or in none, without some options more; commands show the whole line with them.

    options : as they are typed; a word in capitals in them stands for something that only the user knows.
    """

    def __init__(self, text: str, options: str) -> None:
        super().__init__(text)
        self.options = options


def _shortened(text: str) -> str:
    lines = _ENDLESS.sub(lambda endless: clipped(endless[0]), text).split("\n")
    shown = [line if len(line) <= _LONGEST_LINE else clipped(line, _ENDLESS_WORD) for line in lines[:_MOST_LINES]]
    return "\n".join([*shown, *([f"... and {len(lines) - _MOST_LINES} lines more."] if len(lines) > _MOST_LINES else [])])


def nearest(word: str, known: Iterable[str]) -> str:
    """The hint that goes behind an unknown word: the known one it looks most like, or all of them."""
    names = list(known)
    close = difflib.get_close_matches(word, names, n=1, cutoff=0.5) if len(word) <= _LONGEST_SHOWN else []
    return f'did you mean "{close[0]}"?' if close else "known: " + ", ".join(map(clipped, names)) + "."


def visible(text: str) -> str:
    """The same text with every character escaped that would command a terminal or cannot be written in UTF-8."""
    return _UNSEEN.sub(_escaped, text)


def _escaped(found: re.Match[str]) -> str:
    code = ord(found[0])
    if 0xDC80 <= code <= 0xDCFF:
        return f"\\x{code - 0xDC00:02x}"  # a byte of a name that is not UTF-8
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


def clipped(text: str, most: int = _LONGEST_SHOWN) -> str:
    """The text, or its beginning and its length where it is long."""
    return text if len(text) <= most else f"{text[:most]}... ({len(text)} characters)"


def found(value: object) -> str:
    """A value as it was found, for a sentence; a long one by its beginning."""
    if isinstance(value, int) and not isinstance(value, bool) and value.bit_length() > 200:
        return f"a whole number of some {int(value.bit_length() * 0.30103)} digits"
    if isinstance(value, list | tuple | dict):
        return f"{_KINDS[type(value)]} of {len(value)}"
    return clipped(repr(value))


_KINDS = {list: "a list", tuple: "a list", dict: "a table"}
