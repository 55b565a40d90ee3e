"""Units that laboratories write, and the factors that make SI of them."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from measure.common.errors import InputError, nearest

FACTORS = {
    "time": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0},
    "elongation": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "in": 0.0254},
    "force": {"N": 1.0, "kN": 1e3, "mN": 1e-3, "uN": 1e-6, "µN": 1e-6, "lbf": 4.4482216152605, "kip": 4448.2216152605},
}
SI = {"time": "s", "elongation": "m", "force": "N"}
_BRACKETED = re.compile(r"^(?P<name>.*?)\s*[\[(]\s*(?P<unit>[^\[\]()]*?)\s*[\])]$")


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
            raise InputError(f"--unit {quantity}=V: volts need a factor; give {quantity}=V*FACTOR with FACTOR in {SI[quantity]} per volt.")
        return Unit(text, factor)
    table = FACTORS[quantity]
    if symbol not in table:
        raise InputError(f'--unit {quantity}={text}: "{symbol}" is no unit of {quantity} known here; {nearest(symbol, [*table, "V"])}')
    return Unit(text, table[symbol] * factor)


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
    found = _BRACKETED.match(header)
    if found:
        return found["name"], found["unit"]
    name, underscore, unit = header.rpartition("_")
    return (name, unit) if underscore and quantity_of(unit) else (header, "")


def quantity_of(unit: str) -> str:
    """Which quantity a unit measures, or nothing."""
    return next((quantity for quantity, table in FACTORS.items() if unit in table), "")
