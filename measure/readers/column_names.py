"""How the software of test machines names time, elongation and force, in English, German, French, Chinese and some others."""

from __future__ import annotations

import re
from collections.abc import Sequence

from measure.tables.raw_table import RawTable
from measure.tables.units import quantity_of, split_unit

WORDS = {
    "time": (
        *("time", "timestamp", "t", "tout", "zeit", "prüfzeit", "laufzeit", "messzeit", "zeitstempel", "temps", "durée", "tiempo", "tempo"),
        *("时间", "時間", "时刻", "日期时间", "秒数"),
    ),
    "elongation": (
        *(
            "elongation",
            "extension",
            "displacement",
            "position",
            "stroke",
            "deflection",
            "crosshead",
            "travel",
            "disp",
            "dist",
            "pos",
            "ext",
        ),
        *("weg", "verschiebung", "verlängerung", "auslenkung", "standardweg", "traversenweg", "kolbenweg", "hub", "laser", "lvdt", "dist"),
        *("déplacement", "deplacement", "course", "allongement", "élongation", "desplazamiento", "spostamento"),
        *("位移", "伸长", "行程", "变形", "位置", "変位", "伸び", "ストローク", "u", "x", "s"),
    ),
    "force": (
        *("force", "forc", "load", "kraft", "standardkraft", "prüfkraft", "last", "effort", "charge", "fuerza", "forza", "loadcell"),
        *("力", "力值", "载荷", "荷载", "负荷", "试验力", "荷重", "試験力", "f"),
    ),
}
_DEMANDED = re.compile(r"command|demand|setpoint|set point|target|soll|consigne|rate|speed|设定|指令|目標|geschwindigkeit", re.IGNORECASE)
_SHORT = 4  # letters from which on a word counts inside a longer one, as in "Standardkraft"


def name_fits(name: str, quantity: str) -> int:
    """How well a column's name fits a quantity: 3 it is a word for it, 2 holds such a word, 1 such a word is part of one, 0 does not."""
    shown = re.sub(r"[_\-.:#/]+", " ", name.strip().lower())
    if _DEMANDED.search(shown):
        return 0
    parts = [part.rstrip("0123456789") for part in shown.split()]
    words = WORDS[quantity]
    if shown in words:
        return 3
    if any(part in words and len(part) > 1 for part in parts):
        return 2
    return int(any(word in shown for word in words if len(word) >= _SHORT or not word.isascii()))


def candidates(table: RawTable, quantity: str) -> list[int]:
    """Places of the columns that may be a quantity by name and unit, the likeliest first; one in a unit of something else is none."""
    found = []
    for place in range(len(table.header)):
        name, unit = split_unit(table.header[place])[0], written_unit(table, place)
        fits = name_fits(name, quantity)
        if fits and quantity_of(unit) in ("", quantity):
            found.append((-2 * (quantity_of(unit) == quantity) - fits, place))
    return [place for _, place in sorted(found)]


def in_its_unit(table: RawTable, quantity: str) -> list[int]:
    """Places of the columns whose unit is one of the quantity, whatever they are called, but for those of demanded values."""
    units = (quantity_of(written_unit(table, place)) for place in range(len(table.header)))
    return [place for place, found in enumerate(units) if found == quantity and not _DEMANDED.search(table.header[place])]


def written_unit(table: RawTable, place: int) -> str:
    """The unit that stands in the file for a column, in a row of units or behind its name; or nothing."""
    return (table.units[place] if table.units else "") or (split_unit(table.header[place])[1] if table.header else "")


def taken_for(table: RawTable, quantity: str) -> int | None:
    """The place of the one column that can only be this quantity, by a usual word and its unit; None where none is, or several."""
    found = [place for place in candidates(table, quantity) if quantity_of(written_unit(table, place)) == quantity]
    return found[0] if len(found) == 1 and in_its_unit(table, quantity) == found else None


def proposed(table: RawTable, quantity: str, taken: Sequence[int]) -> int | None:
    """The place of the column that is most likely a quantity, for a sentence; None where nothing speaks for any."""
    ranked = [*candidates(table, quantity), *in_its_unit(table, quantity)]
    return next((place for place in ranked if place not in taken), None)
