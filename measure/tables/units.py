"""Units that laboratories write, and the factors that make SI of them."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from measure.common.errors import InputError, nearest

FACTORS = {
    "time": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0},
    "elongation": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "in": 0.0254},
    "force": {
        "N": 1.0,
        "kN": 1e3,
        "mN": 1e-3,
        "uN": 1e-6,
        "µN": 1e-6,
        "daN": 10.0,
        "cN": 1e-2,
        "kgf": 9.80665,  # exact: a kilogram under standard gravity
        "gf": 9.80665e-3,
        "ozf": 0.45359237 * 9.80665 / 16.0,
        "lbf": 4.4482216152605,
        "kip": 4448.2216152605,
    },
}
# Other ways to write the same units, as the software of test machines has them; in small letters.
_SPELLINGS = {
    "time": {
        "s": ("sec", "secs", "second", "seconds", "sek", "sekunden", "secondes", "秒"),
        "ms": ("msec", "millisecond", "milliseconds", "毫秒"),
        "us": ("\u03bcs", "usec", "微秒"),  # with the Greek letter instead of the sign
        "min": ("mins", "minute", "minutes", "minuten", "分"),
    },
    "elongation": {
        "m": ("metre", "metres", "meter", "meters", "米"),
        "cm": ("厘米",),
        "mm": ("mm", "millimetre", "millimetres", "millimeter", "millimeters", "毫米"),
        "um": ("\u03bcm", "micron", "microns", "微米"),
        "in": ("inch", "inches"),
    },
    "force": {
        "N": ("newton", "newtons", "牛", "牛顿"),
        "kN": ("kn", "kilonewton", "千牛"),
        "uN": ("\u03bcn",),
        "kgf": ("kgf", "kg-force", "kgforce", "kp", "kilopond", "公斤力", "千克力"),
        "gf": ("g-force", "gram-force", "克力"),
        "ozf": ("oz-force", "ounce-force"),
        "lbf": ("lbf", "lb-force", "pound-force", "lbsf"),
        "kip": ("kips",),
    },
}
_WRITTEN = {q: {word: unit for unit, words in table.items() for word in words} for q, table in _SPELLINGS.items()}
SI = {"time": "s", "elongation": "m", "force": "N"}
# What trajectories of others are in; apart, for no column of a loop is an angle.
_OF_TRAJECTORIES = {"position": FACTORS["elongation"], "angle": {"rad": 1.0, "deg": math.pi / 180.0, "°": math.pi / 180.0}}
_SI_OF_TRAJECTORIES = {"position": "m", "angle": "rad"}
_LONGEST_HEADER = 1000
_BRACKETED = re.compile(r"^(?P<name>.*?)\s*[\[(（]\s*(?P<unit>[^\[\]()（）]*?)\s*[\])）]$")


@dataclass(frozen=True)
class Unit:
    """A unit as it was given, and what one of it is in SI; a negative factor turns the sign round."""

    text: str
    factor: float


def unit_of(quantity: str, text: str) -> Unit:
    """Read `kN`, `mm`, `V*0.05` (0.05 metres, or newtons, per volt), `mm*-1`.

    Raises
    ------
    InputError
        Unknown unit; volts without a factor; a factor that is no number.
    """
    symbol, star, factor_text = (part.strip() for part in text.partition("*"))
    factor = _factor(quantity, text, factor_text) if star else 1.0
    if symbol == "V":
        if not star:
            si = {**SI, **_SI_OF_TRAJECTORIES}[quantity]
            raise InputError(f"--unit {quantity}=V: volts need a factor; give {quantity}=V*FACTOR with FACTOR in {si} per volt.")
        return Unit(text, factor)
    table = _factors(quantity)
    known = known_unit(quantity, symbol)
    if not known:
        raise InputError(f'--unit {quantity}={text}: "{symbol}" is no unit of {quantity} known here; {nearest(symbol, [*table, "V"])}')
    return Unit(text, table[known] * factor)


def known_unit(quantity: str, text: str) -> str:
    """The unit of a quantity as `FACTORS` has it, for whatever way it is written in: `Sec`, `Newton`, `毫米`; or nothing."""
    written = _WRITTEN.get("elongation" if quantity == "position" else quantity, {})
    return text if text in _factors(quantity) else written.get(text.strip().lower(), "")


def _factors(quantity: str) -> dict[str, float]:
    return FACTORS.get(quantity) or _OF_TRAJECTORIES[quantity]


def turned(text: str) -> str:
    """The same unit with the sign turned round: `mm` becomes `mm*-1`, `V*0.05` becomes `V*-0.05`."""
    symbol, _, factor = (part.strip() for part in text.partition("*"))
    return f"{symbol}*{-float(factor or 1.0):.17g}"


def _factor(quantity: str, text: str, factor_text: str) -> float:
    try:
        factor = float(factor_text)
    except ValueError:
        factor = math.nan
    if not math.isfinite(factor) or factor == 0.0:
        raise InputError(f'--unit {quantity}={text}: "{factor_text}" is no factor; give a number other than zero.')
    return factor


def split_unit(header: str) -> tuple[str, str]:
    """Name and unit of a column's header: `Load (kN)`, `Load [kN]`, `load_kN`; the unit is empty where none stands there."""
    found = _BRACKETED.match(header) if len(header) <= _LONGEST_HEADER else None  # the expression takes the square of the blanks in it
    if found and not found["unit"].isdecimal():  # x[3] is a third column, not one in the unit 3
        return found["name"], found["unit"]
    name, underscore, unit = header.rpartition("_")
    return (name, unit) if underscore and quantity_of(unit) else (header, "")


def quantity_of(unit: str) -> str:
    """Which quantity a unit measures, or nothing."""
    return next((quantity for quantity in FACTORS if known_unit(quantity, unit)), "")
