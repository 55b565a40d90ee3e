"""What a file says about its test besides its samples: in lines above the table, in its name, in columns that never change.

Conditions (pressure, temperature, voltage ...) become columns of one value, so that they can be covariates. Frequency and
amplitude are claims: they are compared with the signal and never used.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.tables.units import FACTORS

_NUMBER = r"[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_SIGN = r"(?:\s*+[=:;,]|[^\S\t]*+\t)"  # between a name and its number; in two parts, lest many tabs take the square of their number
_NOTE = re.compile(rf"^\W*([A-Za-z][\w .()/%-]{{0,40}}?){_SIGN}\s*+({_NUMBER})\s*+([^\d\s]*+)\s*+$")
_FREQUENCY = re.compile(r"f(?:req(?:uency)?)?(?:[ _(\[]*Hz[)\]]?)?", re.IGNORECASE)
_AMPLITUDE = re.compile(r"a(?:mpl?(?:itude)?)?(?:[ _(\[]*([mcu]?m|in)[)\]]?)?", re.IGNORECASE)
_WITHIN = 0.03  # relative difference of a claim from the signal that is none
_NAMED_FREQUENCY = re.compile(r"(?<![\d.])(\d+(?:\.\d+)?)\s*_?Hz", re.IGNORECASE)
_NAMED_LENGTH = re.compile(r"(?<![\d.])(\d+(?:\.\d+)?)\s*_?mm(?![a-z])", re.IGNORECASE)


@dataclass(frozen=True)
class Claim:
    """A number that a file speaks of: "frequency" in Hz, "amplitude" in m, or "travel" in m, which may be amplitude or stroke."""

    where: str
    quantity: str
    value: float


def conditions(path: Path, notes: Iterable[str], pattern: str | None) -> dict[str, float]:
    """Numbers by name out of the lines above the table and, by a pattern, out of the file's name.

    Parameters
    ----------
    pattern : such as "KDN_{pressure_bar}bar"; each word in braces stands for a number.

    Raises
    ------
    InputError
        The name does not follow the pattern; the pattern has no word in braces.
    """
    found = {match[1].strip(): float(match[2]) for note in notes if (match := _NOTE.match(note))}
    return {**found, **(_from_name(path, pattern) if pattern else {})}


def _from_name(path: Path, pattern: str) -> dict[str, float]:
    parts = re.split(r"\{(\w+)\}", pattern)
    if len(parts) < 3:
        raise InputError(f'--name-pattern {pattern}: no word in braces; give it as "KDN_{{pressure_bar}}bar".')
    words = "".join(re.escape(part) if k % 2 == 0 else f"(?P<{part}>{_NUMBER})" for k, part in enumerate(parts))
    match = re.search(words, path.name)
    if not match:
        raise InputError(f"{path}: its name does not follow --name-pattern {pattern}. Rename the file, or leave the pattern out.")
    return {name: float(value) for name, value in match.groupdict().items()}


def claims(path: Path, notes: Iterable[str], other: Mapping[str, Array]) -> list[Claim]:
    """Frequencies and amplitudes that the lines above the table, columns of one value and the file's name speak of."""
    found = [c for note in notes if (m := _NOTE.match(note)) and (c := _claim("a note in it", m[1], float(m[2]), m[3]))]
    for name, values in other.items():
        constant = len(values) and np.ptp(values) == 0.0
        claim = _claim(f'column "{name}"', name, float(values[0]), "") if constant else None
        found += [claim] if claim else []
    stem = path.stem
    found += [Claim("its name", "frequency", float(m[1])) for m in _NAMED_FREQUENCY.finditer(stem)][:1]
    return found + [Claim("its name", "travel", float(m[1]) * 1e-3) for m in _NAMED_LENGTH.finditer(stem)][:1]


def _claim(where: str, name: str, value: float, unit: str) -> Claim | None:
    if _FREQUENCY.fullmatch(name.strip()) and value > 0.0:
        return Claim(where, "frequency", value)
    amplitude = _AMPLITUDE.fullmatch(name.strip())
    length = FACTORS["elongation"].get(unit or (amplitude[1] or "" if amplitude else ""))
    return Claim(where, "amplitude", value * length) if amplitude and length and value > 0.0 else None


def contradictions(file: str, claimed: Iterable[Claim], frequency_Hz: float, amplitude_m: float) -> list[str]:
    """The sentences on claims that the signal denies."""
    said = []
    for claim in claimed:
        seen = [frequency_Hz] if claim.quantity == "frequency" else [amplitude_m] if claim.quantity == "amplitude" else []
        seen = seen or [amplitude_m, 2.0 * amplitude_m]
        if not np.isfinite(seen[0]) or any(abs(claim.value - value) <= _WITHIN * value for value in seen):
            continue
        if claim.quantity == "frequency":
            said.append(f"{file}: {claim.where} says {claim.value:g} Hz, the signal {frequency_Hz:.4g} Hz; the signal counts")
        else:
            moved = f"an amplitude of {1e3 * amplitude_m:.4g} mm"
            said.append(f"{file}: {claim.where} says {1e3 * claim.value:g} mm, the signal shows {moved}; the signal counts")
    return said
