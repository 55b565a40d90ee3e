"""How large forces, lengths, times and masses of a rig are, so that sizes and bounds of effects follow the rig at hand.

A size is declared for the prototype; on another rig it is that size times the ratio of the two rigs' measures, by its unit. A machine that
is ten times as strong has effects that are ten times as strong, and the same answer.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

Exponents = tuple[int, int, int, int]  # of force, length, time, mass

NUMBER: Exponents = (0, 0, 0, 0)
_UNITS: dict[str, Exponents] = {
    "N": (1, 0, 0, 0),
    "m": (0, 1, 0, 0),
    "s": (0, 0, 1, 0),
    "kg": (0, 0, 0, 1),
    "Hz": (0, 0, -1, 0),
    "rad": NUMBER,
}
_TOKEN = re.compile(r"^(N|m|s|kg|Hz|rad)([2-4]?)$")


@dataclass(frozen=True)
class Measures:
    """Ratio of a rig's measures to those of the prototype."""

    force: float = 1.0
    length: float = 1.0
    time: float = 1.0

    @property
    def mass(self) -> float:
        """The mass that such a force moves over such a length in such a time."""
        return self.force * self.time**2 / self.length

    def of(self, exponents: Exponents) -> float:
        """The ratio of sizes of a unit."""
        force, length, time, mass = exponents
        return self.force**force * self.length**length * self.time**time * self.mass**mass


PROTOTYPE = Measures()
_FORCE_N, _LENGTH_M, _TIME_S = 2.8, 0.4, 0.2  # stored force of a leg, its stroke, sqrt(moving mass x stroke / force of six legs)


def measured(force_N: float, length_m: float, time_s: float) -> Measures:
    """The measures of a rig: a leg's stored force, its stroke, and the time of its motion."""
    return Measures(force_N / _FORCE_N, length_m / _LENGTH_M, time_s / _TIME_S)


@cache
def unit_of(name: str) -> Exponents:
    """The unit that a parameter's name ends with, `damping_N_s_per_m`; a number where it ends with none."""
    tokens = name.partition("[")[0].split("_")
    first = len(tokens)
    while first > 0 and (tokens[first - 1] == "per" or _TOKEN.match(tokens[first - 1])):
        first -= 1
    return _exponents(tokens[first:])


def _exponents(tokens: Sequence[str]) -> Exponents:
    found, side = [0, 0, 0, 0], 1
    for token in tokens:
        if token == "per":
            side = -1
        elif match := _TOKEN.match(token):
            power = side * int(match[2] or 1)
            found = [a + power * b for a, b in zip(found, _UNITS[match[1]], strict=True)]
    return found[0], found[1], found[2], found[3]
