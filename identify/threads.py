"""Films looked at side by side, a thread each: kernels let go of the interpreter while they compute."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from numba import get_num_threads

_T = TypeVar("_T")


def side_by_side(task: Callable[[int], _T], count: int) -> list[_T]:
    """What a task makes of 0, 1 ... count - 1, in that order, on as many cores as kernels may use."""
    threads = min(count, get_num_threads())
    if threads < 2:
        return [task(i) for i in range(count)]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(task, range(count)))
