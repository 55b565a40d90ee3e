"""Compiled code kept for as long as anything may call it, whichever thread asked for it first."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from threading import RLock
from typing import Any, ParamSpec, TypeVar

_P = ParamSpec("_P")
_R = TypeVar("_R")
_LOCK = RLock()


def once(make: Callable[_P, _R]) -> Callable[_P, _R]:
    """Makes each thing once. Two threads that made it side by side would keep one and use the address of the other."""
    kept: Any = cache(make)

    @wraps(make)
    def asked(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        with _LOCK:
            return kept(*args, **kwargs)

    return asked
