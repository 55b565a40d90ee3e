"""Ticks of an axis: round numbers, a few of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_STEPS = (1.0, 2.0, 5.0, 10.0)
_SLACK = 1e-9


@dataclass(frozen=True)
class Tick:
    """A tick: where it stands, 0 to 1 along the axis, and its words."""

    share: float
    text: str


def ticks_between(low: float, high: float, most: int = 7) -> list[Tick]:
    """Round numbers from `low` to `high`, at most so many; the script of the pages goes the same way when it zooms."""
    step = _step((high - low) / most)
    first, last = int(np.ceil(low / step - _SLACK)), int(np.floor(high / step + _SLACK))
    digits = max(0, -int(np.floor(np.log10(step) + _SLACK)))
    return [Tick((k * step - low) / (high - low), f"{k * step:.{digits}f}") for k in range(first, last + 1)]


def _step(least: float) -> float:
    power = 10.0 ** np.floor(np.log10(least))
    return next(float(power * factor) for factor in _STEPS if power * factor >= least * (1.0 - _SLACK))
