"""How long the work ahead will take: from a short timed sample of it, said in round figures before it begins."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from measure.common.errors import InputError

T = TypeVar("T")

LONGEST_S = 14 * 86400.0
_SAMPLE_S = 1.0  # of work, before the rest is foretold
_WORTH_S = 5.0  # what takes less is not spoken of
_UNITS = (("s", 1.0, 90.0), ("min", 60.0, 90 * 60.0), ("h", 3600.0, 36 * 3600.0), ("days", 86400.0, float("inf")))


def in_words(seconds: float) -> str:
    """A duration in one significant digit, two from ten on: "about 3 min"."""
    unit, size, _ = next(row for row in _UNITS if seconds < row[2])
    return f"about {float(f'{max(seconds / size, 1.0):.{1 if seconds / size < 10 else 2}g}'):g} {unit}"


def timed(work: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """How long a sample of the work takes, s; done twice, because the first time is also that of loading and compiling."""
    work()
    begun = clock()
    work()
    return clock() - begun


def require_endable(seconds: float, change: str) -> float:
    """The same seconds, if anybody may wait for them.

    Raises
    ------
    InputError
        More than a fortnight; `change` says what to give instead.
    """
    if not seconds <= LONGEST_S:
        raise InputError(f"this would take {in_words(seconds) if seconds < 1e12 else 'for ever'}. {change}")
    return seconds


def foretold(items: Iterable[T], total: int, say: Callable[[float], object], clock: Callable[[], float] = time.perf_counter) -> Iterator[T]:
    """The same items; as soon as enough of them are worked through, `say` is called once with how many seconds the rest will take.

    The first item is not counted: it takes the loading and compiling along. Nothing is said of what is nearly done.
    """
    first, said = 0.0, False
    for done, item in enumerate(items):
        yield item
        now = clock()
        if done == 0:
            first = now
        elif not said and now - first >= _SAMPLE_S:
            said = True
            rest = (total - done - 1) * (now - first) / done
            if rest >= _WORTH_S:
                say(rest)
