"""How the numbers of a text table are written: delimiter and decimal sign. Found, never guessed where two readings are possible."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from measure.common.errors import InputError, clipped, nearest
from measure.tables.number_columns import Dialect

_DELIMITERS = {"tab": "\t", "semicolon": ";", "comma": ",", "bar": "|", "space": " "}
_DECIMALS = {"point": ".", "comma": ","}
# Possessive: else a cell of a hundred thousand digits and a letter takes minutes.
_NUMBER = {sign: re.compile(rf"[+-]?(\d++[{mark}]?+\d*+|[{mark}]\d++)([eE][+-]?\d++)?") for sign, mark in (("point", "."), ("comma", ","))}
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")
_WORDS_FOR_NOTHING = ("nan", "NaN", "NAN", "inf", "-inf", "Inf", "-Inf", "")
MOST_SNIFFED = 200  # lines at the end of the file from which the dialect is found


@dataclass(frozen=True)
class Reading:
    """One way to read the lines of a table: names of the delimiter and the decimal sign, as the options have them."""

    delimiter: str
    decimal: str

    @property
    def dialect(self) -> Dialect:
        """The same for the reader of numbers."""
        return Dialect(None if self.delimiter == "space" else _DELIMITERS[self.delimiter], self.decimal == "comma")

    def is_number(self, cell: str) -> bool:
        """Whether a cell holds a number written with this decimal sign."""
        return _NUMBER[self.decimal].fullmatch(cell) is not None

    def is_data(self, cells: Sequence[str]) -> bool:
        """Whether a row is one of samples: two numbers at least, and text in no more than half of its cells."""
        numbers = sum(map(self.is_number, cells))
        return numbers >= 2 and numbers + sum(cell in _WORDS_FOR_NOTHING for cell in cells) >= len(cells) / 2


def reading_of(path: Path, body: Sequence[str], delimiter: str | None, decimal: str | None) -> Reading:
    """The one reading that makes every cell of a table's last lines a number.

    Parameters
    ----------
    body : the last lines. delimiter, decimal : names or signs that were given; found where not.

    Raises
    ------
    InputError
        No reading makes a table of numbers; two give different numbers; an unknown name.
    """
    delimiters = [_known(delimiter, _DELIMITERS, "--delimiter")] if delimiter else list(_DELIMITERS)
    decimals = [_known(decimal, _DECIMALS, "--decimal")] if decimal else list(_DECIMALS)
    scores = {reading: _score(body, reading) for reading in (Reading(a, b) for a in delimiters for b in decimals)}
    best = max(scores.values())
    if best <= 0.0:
        raise InputError(
            f'{path}: no table of numbers found; the last line begins with "{_first_cell(body[-1])}". '
            "Give --delimiter and --decimal, or export it as comma-separated text."
        )
    readings = _without_equals(body, [reading for reading, score in scores.items() if score == best])
    if len(readings) > 1:
        listed = " or ".join(f"--delimiter {reading.delimiter} --decimal {reading.decimal}" for reading in readings)
        raise InputError(f'{path}: can be read in {len(readings)} ways, "{clipped(body[-1])}". Give {listed}.')
    if readings[0].decimal == "comma" and decimal is None:
        _require_no_thousands(path, body, readings[0])
    return readings[0]


def _first_cell(line: str) -> str:
    """What stands before the first sign between cells: of a file that is no table, no more is shown."""
    return clipped(re.split(r"[\t;,|: ]", line, maxsplit=1)[0], 20)


def _known(word: str, table: dict[str, str], option: str) -> str:
    sign = next((name for name, sign in table.items() if word in (name, sign)), None)
    if sign is None:
        raise InputError(f"{option} {word}: unknown; {nearest(word, table)}")
    return sign


def _score(body: Sequence[str], reading: Reading) -> float:
    """Share of the cells that are numbers, zero where the rows do not agree in length or hold fewer than two numbers."""
    rows = reading.dialect.rows(body)
    size, often = Counter(len(row) for row in rows).most_common(1)[0]
    regular = [[cell.strip() for cell in row] for row in rows if len(row) == size]
    if size < 2 or often < 0.8 * len(rows):
        return 0.0
    numbers = [sum(map(reading.is_number, row)) for row in regular]
    filled = sum(1 for row in regular for cell in row if cell)
    return sum(numbers) / filled if filled and min(numbers) >= 2 else 0.0


def _without_equals(body: Sequence[str], readings: Sequence[Reading]) -> list[Reading]:
    """Readings that give other numbers than those before them."""
    kept: list[Reading] = []
    earlier: list[list[list[float | str]]] = []
    for reading in readings:
        values = [[_value(cell, reading) for cell in reading.dialect.split(line) if cell] for line in body]
        if values not in earlier:
            earlier.append(values)
            kept.append(reading)
    return kept


def _value(cell: str, reading: Reading) -> float | str:
    if not reading.is_number(cell):
        return cell
    return float(cell.replace(",", ".") if reading.decimal == "comma" else cell)


def _require_no_thousands(path: Path, body: Sequence[str], reading: Reading) -> None:
    with_comma = [cell for line in body for cell in reading.dialect.split(line) if "," in cell]
    if with_comma and all(_THOUSANDS.fullmatch(cell) for cell in with_comma):
        raise InputError(f'{path}: "{with_comma[0]}" may be a decimal comma or a thousand. Give --decimal comma, or --decimal point.')
