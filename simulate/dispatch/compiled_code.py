"""Compiled code kept for as long as anything may call it, whichever thread asked for it first."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from threading import RLock
from typing import Any, ParamSpec, TypeVar

_P = ParamSpec("_P")
_R = TypeVar("_R")
_LOCK = RLock()


def compiled_once(make: Callable[_P, _R]) -> Callable[_P, _R]:
    """Decorator: each thing is compiled once. Two threads that compiled it side by side would keep one and use the address of the other."""
    cached: Any = cache(make)

    @wraps(make)
    def wrapped(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        with _LOCK:
            return cached(*args, **kwargs)

    return wrapped
