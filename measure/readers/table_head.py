"""What stands above the first row of numbers of a table: notes, names and units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Head:
    """The rows above the first row of numbers: how many there are, how many of them stand above the names, names and units."""

    rows: int
    above: int
    names: list[str]
    units: list[str]


NO_HEAD = Head(0, 0, [], [])


def head_of(rows: Sequence[Sequence[str]], full: Callable[[Sequence[str]], bool], is_number: Callable[[str], bool]) -> Head:
    """Names and units out of the rows above the numbers.

    The names are the first row without a number in the block of full rows that ends at the first row of numbers, the units the second.
    """
    first = len(rows)
    while first and full(rows[first - 1]):
        first -= 1
    while first < len(rows) - 1 and any(map(is_number, rows[first])):
        first += 1
    names, units = [*(list(row) for row in rows[first:]), [], []][:2]
    return Head(len(rows), first, names, [cell.strip("[]()（） ") for cell in units])
