"""Films, starts and tests looked at side by side, a thread each: kernels let go of the interpreter while they compute."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

from numba import get_num_threads

_T = TypeVar("_T")
_here = threading.local()


def side_by_side(task: Callable[[int], _T], count: int) -> list[_T]:
    """What a task makes of 0, 1 ... count - 1, in that order, on as many cores as kernels may use.

    Asked from within a task it is done by that task's own thread, for the other cores are busy already.
    """
    if others_busy() or min(count, get_num_threads()) < 2:
        return [task(i) for i in range(count)]
    return list(_pool(get_num_threads()).map(task, range(count)))


def others_busy() -> bool:
    """Whether this is one of the threads that keep all cores busy."""
    return getattr(_here, "is_one_of_many", False)


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, initializer=_mark)


def _mark() -> None:
    _here.is_one_of_many = True
