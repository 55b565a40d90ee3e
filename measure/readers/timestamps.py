"""Date-time stamps as seconds: `2025-01-02 03:04:05.25`, `14.12.2021 9:40:47,25`, `1/2/2025 3:04:05 PM`, `03:04:05.25`."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError

_CLOCK = r"(?P<h>\d{1,2}):(?P<min>\d{2})(?::(?P<s>\d{2}(?:[.,]\d{1,9})?))?(?:\s*(?P<half>[AaPp][Mm]))?(?:\s*(?:Z|[+-]\d{2}:?\d{2}))?"
_YEAR_FIRST = r"(?P<y>\d{4})[-/.年](?P<mon>\d{1,2})[-/.月](?P<d>\d{1,2})日?"
_YEAR_LAST = r"(?P<first>\d{1,2})(?P<sign>[-/.])(?P<second>\d{1,2})[-/.](?P<last>\d{4})"
_STAMPS = tuple(re.compile(text) for text in (rf"{_YEAR_FIRST}[T\s]+{_CLOCK}", rf"{_YEAR_LAST}[T\s]+{_CLOCK}", _CLOCK))
_DAYS = tuple(re.compile(text) for text in (_YEAR_FIRST, _YEAR_LAST))
_DAY_S = 86400.0


def is_stamp(cell: str) -> bool:
    """Whether a cell is a time of day, with or without its date."""
    return any(pattern.fullmatch(cell) for pattern in _STAMPS)


def is_date(cell: str) -> bool:
    """Whether a cell is a date alone."""
    return any(pattern.fullmatch(cell) for pattern in _DAYS)


def seconds_of(cells: Sequence[str], place: str) -> Array:
    """Seconds since the first stamp, (n,), NaN where a cell is none. A time of day without a date may go on over midnight.

    Parameters
    ----------
    place : file and column, for the sentence.

    Raises
    ------
    InputError
        Dates that change and of which it is not sure whether the day or the month stands first.
    """
    pattern = next((p for p in _STAMPS for cell in cells[:1] if p.fullmatch(cell)), _STAMPS[-1])
    parts = [match.groupdict() if (match := pattern.fullmatch(cell)) else None for cell in cells]
    clock = np.array([np.nan if part is None else _clock(part) for part in parts])
    if pattern is _STAMPS[-1]:
        return _since_first(clock + _DAY_S * np.cumsum(np.diff(clock, prepend=clock[:1]) < -_DAY_S / 2))
    return _since_first(_since_first(_days(parts, place)) * _DAY_S + clock)


def _since_first(seconds: Array) -> Array:
    known = seconds[np.isfinite(seconds)]
    return seconds - known[0] if len(known) else seconds


def _clock(part: dict[str, str]) -> float:
    hour = int(part["h"])
    if part["half"]:
        hour = hour % 12 + 12 * (part["half"].lower() == "pm")
    return 3600.0 * hour + 60.0 * int(part["min"]) + float((part["s"] or "0").replace(",", "."))


def _days(parts: Sequence[dict[str, str] | None], place: str) -> Array:
    """Days since the year 1970 of each row; of dates that never change any number does."""
    dates = [None if part is None else _date(part) for part in parts]
    known = list(dict.fromkeys(date for date in dates if date is not None))
    order = _order(known, place) if len(known) > 1 else None
    day = {date: _day("-".join(date[k].zfill(2) for k in order)) if order else 0.0 for date in known}
    return np.array([np.nan if date is None else day[date] for date in dates])


def _date(part: dict[str, str]) -> tuple[str, ...]:
    """Year, month and day; or two numbers of which the order is open, year, and the sign between them."""
    return (part["y"], part["mon"], part["d"]) if "y" in part else (part["first"], part["second"], part["last"], part["sign"])


def _order(dates: Sequence[tuple[str, ...]], place: str) -> tuple[int, int, int]:
    """Places of year, month and day in dates; with points between them the day stands first where the year is last."""
    if len(dates[0]) == 3:
        return 0, 1, 2
    day_first = dates[0][3] == "." or any(int(date[0]) > 12 for date in dates)
    if not day_first and not any(int(date[1]) > 12 for date in dates):
        shown = "/".join(dates[0][:3])
        raise InputError(f"{place}: {shown} may be day/month or month/day. Write the year first, or give --sample-period SECONDS.")
    return (2, 1, 0) if day_first else (2, 0, 1)


def _day(text: str) -> float:
    try:
        return float(np.datetime64(text, "D").astype(int))
    except ValueError:
        return np.nan
