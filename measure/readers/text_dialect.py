"""How a text table is written: encoding, delimiter, decimal sign, header. Found, never guessed where two readings are possible."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from measure.common.errors import InputError, nearest

DELIMITERS = {"tab": "\t", "semicolon": ";", "comma": ",", "bar": "|", "space": " "}
DECIMALS = {"point": ".", "comma": ","}
LARGEST_FILE = 500_000_000  # bytes
_BOMS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_NUMBER = {"point": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"), "comma": re.compile(r"[+-]?(\d+,?\d*|,\d+)([eE][+-]?\d+)?")}
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")
_WORDS_FOR_NOTHING = ("nan", "NaN", "NAN", "inf", "-inf", "Inf", "-Inf", "")


@dataclass(frozen=True)
class TextTable:
    """A table as text: how it was read, the lines above it, and its cells.

    header : names of the columns, or empty. units : what stands under each name, or empty. preamble : lines above the header.
    rows : cells with a decimal point. first_line : number of the first row in the file, counted from one.
    """

    encoding: str
    delimiter: str
    decimal: str
    preamble: tuple[str, ...]
    header: tuple[str, ...]
    units: tuple[str, ...]
    rows: list[list[str]]
    first_line: int

    def at(self, row: int) -> str:
        """Where a row stands in the file, for people."""
        return f"sample {row + 1}" if self.delimiter == "none" else f"line {self.first_line + row}"


def read_text_table(
    path: Path, delimiter: str | None = None, decimal: str | None = None, encoding: str | None = None, header: bool | None = None
) -> TextTable:
    """Read a table of numbers from a text file.

    Parameters
    ----------
    delimiter, decimal : words of `DELIMITERS` and `DECIMALS`; found from the file where not given.
    encoding : found from the file where not given: its byte order mark, else UTF-8, else Windows-1252.
    header : False takes every row for numbers.

    Raises
    ------
    InputError
        Not text, no table, two possible readings, a row with another number of cells.
    """
    text, used_encoding = decoded(path, encoding)
    lines = text.splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    if not lines:
        raise InputError(f"{path}: is empty. Export the loop again.")
    found_delimiter, found_decimal = _dialect(path, lines, delimiter, decimal)
    return _table(path, lines, found_delimiter, found_decimal, used_encoding, header)


def decoded(path: Path, encoding: str | None) -> tuple[str, str]:
    """The text of a file, and the encoding it was read with.

    Raises
    ------
    InputError
        Too large, not text, an unknown or a wrong encoding.
    """
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(f"{path}: is larger than {LARGEST_FILE // 1_000_000} MB; that is no table of a loop. Cut it to the test.")
    raw = path.read_bytes()
    marked = next((name for mark, name in _BOMS if raw.startswith(mark)), None)
    candidates = [encoding] if encoding else [marked] if marked else ["utf-8", "cp1252"]
    if not marked and not encoding and b"\x00" in raw:
        raise InputError(f"{path}: is not text (it holds zero bytes). Export the loop as text, or give --encoding.")
    for name in candidates:
        try:
            return raw.decode(name), name
        except LookupError as error:
            raise InputError(f'--encoding {name}: no such encoding; try "utf-8", "utf-16" or "cp1252".') from error
        except UnicodeDecodeError:
            continue
    raise InputError(f"{path}: cannot be read as {candidates[-1]} text. Give --encoding, or export it as UTF-8.")


def _dialect(path: Path, lines: Sequence[str], delimiter: str | None, decimal: str | None) -> tuple[str, str]:
    """The one reading that makes every cell of the table's body a number."""
    delimiters = [_known(delimiter, DELIMITERS, "--delimiter")] if delimiter else list(DELIMITERS)
    decimals = [_known(decimal, DECIMALS, "--decimal")] if decimal else list(DECIMALS)
    body = lines[-max(20, min(200, len(lines) * 2 // 3)) :]
    scores = {(a, b): _score(body, a, b) for a in delimiters for b in decimals}
    best = max(scores.values())
    if best <= 0.0:
        raise InputError(
            f'{path}: no table of numbers found; the last line is "{lines[-1][:60]}". '
            "Give --delimiter and --decimal, or export it as comma-separated text."
        )
    readings = [reading for reading, score in scores.items() if score == best]
    readings = _without_equals(body, readings)
    if len(readings) > 1:
        listed = " or ".join(f"--delimiter {a} --decimal {b}" for a, b in readings)
        raise InputError(f'{path}: can be read in {len(readings)} ways, "{body[-1][:60]}". Give {listed}.')
    if readings[0][1] == "comma" and decimal is None:
        _require_no_thousands(path, body, readings[0][0])
    return readings[0]


def _known(word: str, table: dict[str, str], option: str) -> str:
    sign = next((name for name, sign in table.items() if word in (name, sign)), None)
    if sign is None:
        raise InputError(f"{option} {word}: unknown; {nearest(word, table)}")
    return sign


def _score(body: Sequence[str], delimiter: str, decimal: str) -> float:
    """Share of the cells that are numbers, zero where the rows do not agree in length or hold fewer than two numbers."""
    rows = [cells(line, delimiter) for line in body]
    size, often = Counter(len(row) for row in rows).most_common(1)[0]
    regular = [row for row in rows if len(row) == size]
    if size < 2 or often < 0.8 * len(rows):
        return 0.0
    numbers = [sum(is_number(cell, decimal) for cell in row) for row in regular]
    filled = sum(1 for row in regular for cell in row if cell)
    return sum(numbers) / filled if filled and min(numbers) >= 2 else 0.0


def _without_equals(body: Sequence[str], readings: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """Readings that give other numbers than those before them."""
    kept: list[tuple[str, str]] = []
    seen: list[list[list[float | str]]] = []
    for delimiter, decimal in readings:
        values = [[_value(cell, decimal) for cell in cells(line, delimiter) if cell] for line in body]
        if values not in seen:
            seen.append(values)
            kept.append((delimiter, decimal))
    return kept


def _value(cell: str, decimal: str) -> float | str:
    return float(with_point(cell, decimal)) if is_number(cell, decimal) else cell


def _require_no_thousands(path: Path, body: Sequence[str], delimiter: str) -> None:
    with_comma = [cell for line in body for cell in cells(line, delimiter) if "," in cell]
    if with_comma and all(_THOUSANDS.fullmatch(cell) for cell in with_comma):
        raise InputError(f'{path}: "{with_comma[0]}" may be a decimal comma or a thousand. Give --decimal comma, or --decimal point.')


def cells(line: str, delimiter: str) -> list[str]:
    """The cells of a line, without blanks around them; quoted cells may hold the delimiter."""
    if delimiter == "space":
        return line.split()
    row = next(csv.reader([line], delimiter=DELIMITERS[delimiter]), [])
    return [cell.strip() for cell in row]


def is_number(cell: str, decimal: str) -> bool:
    """Whether a cell holds a number written with this decimal sign."""
    return _NUMBER[decimal].fullmatch(cell) is not None


def with_point(cell: str, decimal: str) -> str:
    """The cell with a decimal point."""
    return cell.replace(",", ".") if decimal == "comma" else cell


def _table(path: Path, lines: Sequence[str], delimiter: str, decimal: str, encoding: str, header: bool | None) -> TextTable:
    split = [cells(line, delimiter) for line in lines]
    size = Counter(len(row) for row in split if row).most_common(1)[0][0]
    start = 0 if header is False else next((i for i, row in enumerate(split) if len(row) == size and _is_data(row, decimal)), 0)
    above = [i for i in range(start) if len(split[i]) == size]
    names, units, top = _header(split, above, start)
    rows = _rows(path, split, start, size)
    if start and not names and any(split[start - 1]):
        raise InputError(
            f"{path}, line {start}: {len(split[start - 1])} names stand above {size} columns, so which is which is not sure. "
            "Mend the header, or remove it and give the columns by number."
        )
    keep = [k for k in range(size) if any(row[k] for row in rows)]
    return TextTable(
        encoding=encoding,
        delimiter=delimiter,
        decimal=decimal,
        preamble=tuple(lines[:top]),
        header=tuple(names[k] for k in keep) if names else (),
        units=tuple(units[k] for k in keep) if units else (),
        rows=[[with_point(row[k], decimal) for k in keep] for row in rows],
        first_line=start + 1,
    )


def _is_data(row: Sequence[str], decimal: str) -> bool:
    numbers = sum(is_number(cell, decimal) for cell in row)
    return numbers >= 2 and numbers + sum(cell in _WORDS_FOR_NOTHING for cell in row) >= len(row) / 2


def _header(split: Sequence[list[str]], above: Sequence[int], start: int) -> tuple[list[str], list[str], int]:
    """Names, units and the number of lines above; the header is the block of full rows that ends at the first number."""
    block = [i for i in above if all(k in above for k in range(i, start))]
    if not block:
        return [], [], start
    units = split[block[1]] if len(block) > 1 else []
    return split[block[0]], [cell.strip("[]() ") for cell in units], block[0]


def _rows(path: Path, split: Sequence[list[str]], start: int, size: int) -> list[list[str]]:
    rows = []
    for number, row in enumerate(split[start:], start=start + 1):
        if len(row) != size:
            raise InputError(
                f"{path}, line {number}: {len(row)} cells where the other rows have {size}; the file is cut or a cell is missing. "
                "Remove the line or export the file again."
            )
        rows.append(row)
    return rows
