"""Numbers in the units that people use: grams, millinewtons, degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence

from measure.tables.frames import unit_in_name

_SMALLER = {"kg": ("g", 1e3), "N": ("mN", 1e3), "m": ("mm", 1e3), "s": ("ms", 1e3), "N m": ("mN m", 1e3)}
_ALWAYS = {"rad": ("deg", 180.0 / math.pi), "m": ("mm", 1e3)}
_SHARES = ("fraction",)
_OF_CHANNELS = {"_m": (1e3, "mm"), "_rad": (180.0 / math.pi, "deg"), "_N": (1.0, "N")}
_CHANNELS = {"x": "lateral x", "y": "lateral y", "z": "elevation z", "theta_x": "rotation about x", "theta_y": "rotation about y"}


def unit_in_use(name: str, values: Sequence[float]) -> tuple[str, float]:
    """The unit that serves for values of a column or parameter, and how many of it make one SI unit.

    Parameters
    ----------
    name : with the unit at its end, `mass_kg`, `force_N[2]`.
    values : in SI; those below one are given in the smaller unit.
    """
    plain = name.split("[")[0]
    unit = unit_in_name(plain)
    if not unit and plain.endswith(_SHARES):
        return "%", 100.0
    if unit in _ALWAYS:
        return _ALWAYS[unit]
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    return _SMALLER[unit] if unit in _SMALLER and largest < 1.0 else (unit, 1.0)


def in_use(name: str, value: float, ends: Sequence[float] = ()) -> str:
    """A value with its unit, and its interval where there is one: `10.0 g (9.99 to 10.02 g)`. As many digits as the interval carries."""
    unit, factor = unit_in_use(name, [value])
    behind = f" {unit}" if unit else ""
    if not math.isfinite(value):
        return "–"
    known = [factor * end for end in ends if math.isfinite(end)]
    if len(known) < 2 or known[0] >= known[1]:
        return f"{_rounded(factor * value, 3)}{behind}"
    digits = min(max(_digits_of(known[1] - known[0]), 0), 6)
    low, high = (f"{end:.{digits}f}" for end in known)
    shown = f"{factor * value:.{digits}f}"
    return f"{shown}{behind} ({low} to {high}{behind})"


def _digits_of(width: float) -> int:
    """Decimals with which an interval of a width shows two digits of it."""
    return 1 - math.floor(math.log10(width))


def _rounded(value: float, digits: int) -> str:
    """So many significant digits, without a power of ten where few noughts do."""
    if value == 0.0 or not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits}g}"
    return f"{value:.{max(digits - 1 - math.floor(math.log10(abs(value))), 0)}f}"


def percent(share: float) -> str:
    """A probability in percent; what is very near to one or nought is said to be."""
    if share > 1.0 - 5e-4:
        return "over 99.9 %"
    return f"{100 * share:.3g} %" if share >= 1e-3 else "below 0.1 %"


def shown_as(channel: str) -> tuple[float, str, str]:
    """Factor, unit and name of a measured channel as people read it."""
    for ending, (factor, unit) in _OF_CHANNELS.items():
        if channel.endswith(ending):
            plain = channel.removesuffix(ending)
            return factor, unit, _CHANNELS.get(plain, plain.replace("_", " "))
    return 1.0, "", channel
