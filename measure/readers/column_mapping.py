"""How the loop files of a rig are to be read: given by options, kept in one file per rig."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

from measure.common.command_line import existing_file
from measure.common.errors import InputError, nearest
from measure.common.output import write_text
from measure.tables.units import turned, unit_of

QUANTITIES = ("time", "elongation", "force")


@dataclass(frozen=True)
class ColumnMapping:
    """How the files of a rig are to be read; whatever is left out is found from the file.

    columns : name or number (from one) of the column, by quantity. units : by quantity, see `units.unit_of`.
    delimiter, decimal : words of `dialect`. header : False for a file without names. sample_period_s : where no time stands.
    name_pattern : conditions that stand in the names of the files, such as "KDN_{pressure_bar}bar".
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    delimiter: str | None = None
    decimal: str | None = None
    encoding: str | None = None
    header: bool | None = None
    sample_period_s: float | None = None
    name_pattern: str | None = None

    def __post_init__(self) -> None:
        for option, given in (("--column", self.columns), ("--unit", self.units)):
            for quantity in given:
                if quantity not in QUANTITIES:
                    raise InputError(f"{option} {quantity}=...: a loop has no {quantity}; {nearest(quantity, QUANTITIES)}")
        for quantity, text in self.units.items():
            unit_of(quantity, str(text))
        if self.sample_period_s is not None and not (math.isfinite(self.sample_period_s) and self.sample_period_s > 0.0):
            raise InputError(f"--sample-period {self.sample_period_s}: give the seconds between two samples, above zero.")


def read_mapping(path: Path) -> ColumnMapping:
    """Read a mapping file, TOML.

    Raises
    ------
    InputError
        No such file, not TOML, an unknown key.
    """
    existing_file(Path(path), what="a mapping file (TOML)")
    try:
        document = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not TOML: {error}. Write a new one with --save-mapping.") from error
    known = [item.name for item in fields(ColumnMapping)]
    for key, value in document.items():
        if key not in known:
            raise InputError(f'{path}: unknown key "{key}"; {nearest(key, known)}')
        if isinstance(value, dict) != (key in ("columns", "units")):
            raise InputError(f"{path}: {key} must be {'a table' if key in ('columns', 'units') else 'a single value'}.")
    return ColumnMapping(**document)


def write_mapping(mapping: ColumnMapping, path: Path) -> None:
    """Write a mapping file that `read_mapping` reads."""
    import tomli_w

    document = {item.name: getattr(mapping, item.name) for item in fields(ColumnMapping)}
    write_text(Path(path), tomli_w.dumps({key: value for key, value in document.items() if value not in (None, {})}))


def with_sign_turned(mapping: ColumnMapping, quantity: str, units: Collection[str]) -> ColumnMapping:
    """The same mapping with one quantity counted the other way round.

    Parameters
    ----------
    units : in which the files of the rig were found to be, as they were given or as they stand there.

    Raises
    ------
    InputError
        The files are in different units, so that one mapping cannot turn them all.
    """
    if len(units) > 1:
        listed = ", ".join(sorted(units))
        raise InputError(
            f"--save-mapping: the sign of the {quantity} must be turned, and the files are in different units ({listed}). "
            f"Save one mapping for those of one unit, or give --unit {quantity}=UNIT*-1 yourself."
        )
    return replace(mapping, units={**mapping.units, quantity: turned(next(iter(units)))})


def pairs(option: str, given: Sequence[str]) -> dict[str, str]:
    """`quantity=value` words of a command line as a table.

    Raises
    ------
    InputError
        A word without an equals sign, or the same quantity twice.
    """
    made: dict[str, str] = {}
    for word in given:
        quantity, equals, value = word.partition("=")
        if not equals or not value:
            raise InputError(f"{option} {word}: give it as {option} force=...")
        if quantity in made:
            raise InputError(f"{option} {quantity} is given twice; keep one.")
        made[quantity] = value
    return made
