"""From responses to a regression: coefficients in coded factors, their share of the variability, and the formula."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import reduce
from itertools import combinations
from operator import xor

import numpy as np

from measure.common.arrays import Array
from simulate.sweeps.designs import Design

Values = Callable[[], Iterator[Array]]

CONSTANT = "1"
HIGHEST_ORDER = 3
_MOST_TERMS = 40
_SHARE_OF_FORMULA = 99.9
_ALIKE = 0.01


def walsh_hadamard(values: Array) -> Array:
    """Sums over all runs with the signs of every product of factors, unscaled; the length is a power of two.

    One pass a factor, n log2 n additions in all, instead of n^2.
    """
    result = np.array(values, dtype=float)
    half = 1
    while half < len(result):
        pairs = result.reshape(-1, 2, half)
        result = np.stack([pairs[:, 0] + pairs[:, 1], pairs[:, 0] - pairs[:, 1]], axis=1).reshape(-1)
        half *= 2
    return result


def coefficients_of(design: Design, letters: Sequence[str], values: Values) -> dict[str, float]:
    """Coefficients of the regression in coded factors, by letters, the constant under "1".

    Of a two-level design without a missing response all that it determines, by one Walsh-Hadamard transform; an interaction
    that shares its column with others carries the name of the shortest. Otherwise by least squares, up to as many factors
    in a product as the runs can carry, on the runs that have a response.

    Parameters
    ----------
    values : a function that gives the responses piece by piece, in order, NaN where a run has none; it is called more than once.
    """
    good = sum(int(np.isfinite(piece).sum()) for piece in values())
    if design.basic and good == design.runs:
        whole = np.concatenate(list(values()))
        sums = walsh_hadamard(whole) / len(whole)
        return {name: float((-1) ** column.bit_count() * sums[column]) for column, name in _names(design, letters).items()}
    return _least_squares(design, letters, values, good)


def _names(design: Design, letters: Sequence[str]) -> dict[int, str]:
    """The shortest product of factors in each column, by the column's bit mask."""
    if all(column == 1 << i for i, column in enumerate(design.columns)):
        return {column: _product(letters, column) for column in sorted(range(1 << design.basic), key=_order)}
    names = {0: CONSTANT}
    for order in range(1, HIGHEST_ORDER + 1):
        for chosen in combinations(range(len(letters)), order):
            column = reduce(xor, (design.columns[i] for i in chosen))
            names.setdefault(column, "".join(letters[i] for i in chosen))
    return names


def _order(column: int) -> tuple[int, list[int]]:
    places = [i for i in range(column.bit_length()) if column >> i & 1]
    return len(places), places


def _product(letters: Sequence[str], column: int) -> str:
    return "".join(letter for i, letter in enumerate(letters) if column >> i & 1) or CONSTANT


def _least_squares(design: Design, letters: Sequence[str], values: Values, good: int) -> dict[str, float]:
    terms = _terms(len(letters), good)
    if not terms:
        return {}
    gram, right, first = np.zeros((len(terms), len(terms))), np.zeros(len(terms)), 0
    for piece in values():
        found = np.isfinite(piece)
        rows = monomials(design.piece(first, first + len(piece))[found], terms)
        gram += rows.T @ rows
        right += rows.T @ piece[found]
        first += len(piece)
    solved = np.linalg.lstsq(gram, right, rcond=1e-12)[0]
    return {"".join(letters[i] for i in term) or CONSTANT: float(value) for term, value in zip(terms, solved, strict=True)}


def _terms(factors: int, runs: int) -> list[tuple[int, ...]]:
    """Products of factors, all of an order or none, with a quarter more runs than terms."""
    terms: list[tuple[int, ...]] = []
    for order in range(HIGHEST_ORDER + 1):
        added = list(combinations(range(factors), order))
        if 1.25 * (len(terms) + len(added)) > runs:
            break
        terms += added
    return terms


def monomials(coded: Array, terms: Iterable[Sequence[int]]) -> Array:
    """(runs, terms) products of the coded levels."""
    return np.column_stack([np.prod(coded[:, list(term)], axis=1) for term in terms])


def predicted(coefficients: Mapping[str, float], letters: Sequence[str], coded: Array) -> Array:
    """(runs,) what the regression says."""
    place = {letter: i for i, letter in enumerate(letters)}
    terms = [[place[letter] for letter in name] if name != CONSTANT else [] for name in coefficients]
    total = np.zeros(len(coded))
    for term, value in zip(terms, coefficients.values(), strict=True):
        total += value * np.prod(coded[:, term], axis=1)
    return total


def variability_percent(coefficients: Mapping[str, float]) -> dict[str, float]:
    """Share of each main effect and interaction in the variability that the regression describes, %."""
    squares = {name: value**2 for name, value in coefficients.items() if name != CONSTANT}
    total = math.fsum(squares.values())
    return {name: 100.0 * square / total if total > 0 else 0.0 for name, square in squares.items()}


def formula(coefficients: Mapping[str, float], response: str) -> str:
    """The regression as a person reads it: `theta_z = 86.6 (A - C + E - G + J - L) - 5.86 ACG ...`.

    Terms of one order whose sizes agree within 1 % share a bracket with their mean; what lies beyond 99.9 % of the variability,
    or beyond 40 terms, is dots.
    """
    share = variability_percent(coefficients)
    groups: list[list[str]] = []
    for name in sorted(share, key=lambda name: -share[name])[: 4 * _MOST_TERMS]:
        _join(groups, name, coefficients)
    kept, shown, covered = [], 0, 0.0
    for names in groups:
        if covered >= _SHARE_OF_FORMULA or shown + len(names) > _MOST_TERMS or coefficients[names[0]] == 0.0:
            break
        kept.append(names)
        shown, covered = shown + len(names), covered + sum(share[name] for name in names)
    written = [_group(sorted(names), coefficients) for names in sorted(kept, key=lambda names: len(names[0]))]
    constant = coefficients.get(CONSTANT, 0.0)
    if abs(constant) > 1e-3 * max((abs(value) for value in coefficients.values()), default=0.0):
        written.insert(0, f"{constant:+.3g}")
    text = " ".join(written).replace("+", "+ ").replace("-", "- ") or "0"
    text = text.removeprefix("+ ") + (" + ..." if shown < len(share) else "")
    return f"{response} = {text}"


def _join(groups: list[list[str]], name: str, coefficients: Mapping[str, float]) -> None:
    for names in groups:
        if len(names[0]) == len(name) and abs(abs(coefficients[names[0]]) - abs(coefficients[name])) <= _ALIKE * abs(
            coefficients[names[0]]
        ):
            names.append(name)
            return
    groups.append([name])


def _group(names: Sequence[str], coefficients: Mapping[str, float]) -> str:
    first = math.copysign(1.0, coefficients[names[0]])
    size = first * math.fsum(abs(coefficients[name]) for name in names) / len(names)
    if len(names) == 1:
        return f"{size:+.3g} {names[0]}"
    signs = [("+" if coefficients[name] * first > 0 else "-") + name for name in names]
    return f"{size:+.3g} ({' '.join(signs).removeprefix('+')})"
