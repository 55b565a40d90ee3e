"""The one way to say that an input cannot be used."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class InputError(ValueError):
    """Unusable input: file, place, what was found and what to do, in one sentence or two.

    Commands print it behind their name on standard error and leave with status 2, with nothing written.
    """


def nearest(word: str, known: Iterable[str]) -> str:
    """The hint that goes behind an unknown word: the known one it looks most like, or all of them."""
    names = list(known)
    close = difflib.get_close_matches(word, names, n=1, cutoff=0.5)
    return f'did you mean "{close[0]}"?' if close else "known: " + ", ".join(names) + "."
