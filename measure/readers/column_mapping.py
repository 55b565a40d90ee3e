"""How the loop files of a rig are to be read: given by options, kept in one file per rig."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError

from measure.common.errors import InputError, clipped, found, nearest
from measure.common.inputs import read_toml
from measure.common.output import write_text
from measure.tables.units import turned, unit_of

QUANTITIES = ("time", "elongation", "force")
_WITH_UNIT = (*QUANTITIES, "position", "angle")
_AXIS = re.compile("[+-]?[xyz]")


@dataclass(frozen=True)
class ColumnMapping:
    """How the files of a rig, loops and foreign trajectories, are to be read; whatever is left out is found from the file.

    columns : name or number (from one) of the column, by quantity. units : by quantity, see `units.unit_of`.
    delimiter, decimal : names as in `text.dialect`. header : False for a file without names. sample_period_s : where no time stands.
    name_pattern : conditions that stand in the names of the files, such as "KDN_{pressure_bar}bar". sheet : of a workbook.
    up, across : of a file of markers, the axis that points up (z_m) and the one across the view (x_m): "z", "-y". markers : those on the
    platform, by name; all of them where none is named.

    Raises
    ------
    InputError
        Everything that is wrong with quantities, units, the sample period, axes and markers.
    """

    columns: Mapping[str, str | int] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    delimiter: str | None = None
    decimal: str | None = None
    encoding: str | None = None
    header: bool | None = None
    sample_period_s: float | None = None
    name_pattern: str | None = None
    sheet: str | None = None
    up: str | None = None
    across: str | None = None
    markers: Sequence[str] = ()

    def __post_init__(self) -> None:
        wrong = [*_wrong_columns(self.columns), *_wrong_units(self.units), *_wrong_period(self.sample_period_s)]
        wrong += [*wrong_axis("--up", self.up), *wrong_axis("--across", self.across), *wrong_markers("--markers", self.markers)]
        if wrong:
            raise InputError("\n".join(wrong))


def _wrong_columns(columns: Mapping[str, Any]) -> list[str]:
    return [_no_quantity("--column", quantity, QUANTITIES) for quantity in columns if quantity not in QUANTITIES]


def _wrong_units(units: Mapping[str, str]) -> list[str]:
    return [wrong for quantity, text in units.items() if (wrong := _wrong_unit(quantity, text))]


def _wrong_unit(quantity: str, text: str) -> str:
    if quantity not in _WITH_UNIT:
        return _no_quantity("--unit", quantity, _WITH_UNIT)
    try:
        unit_of(quantity, text)
    except InputError as error:
        return str(error)
    return ""


def _no_quantity(option: str, quantity: str, known: Sequence[str]) -> str:
    return f"{option} {quantity}=...: a loop has no {quantity}; {nearest(quantity, known)}"


def wrong_axis(option: str, axis: str | None) -> list[str]:
    """What is wrong with an axis of a file of markers, in a sentence; `option` is what it was given by."""
    if axis is None or _AXIS.fullmatch(axis):
        return []
    return [f'{option} {clipped(axis)}: give an axis of the file, x, y or z, with a minus where it points the other way: "-y".']


def wrong_markers(option: str, markers: Sequence[str]) -> list[str]:
    """What is wrong with the names of markers, in a sentence."""
    if all(markers) and len(set(markers)) == len(markers):
        return []
    return [f"{option} {clipped(','.join(markers))}: name each marker once, with a comma between two."]


def _wrong_period(period_s: float | None) -> list[str]:
    if period_s is None or (math.isfinite(period_s) and period_s > 0.0):
        return []
    return [f"--sample-period {period_s}: give the seconds between two samples, above zero."]


def _checked(wrong: Callable[[Any], list[str]]) -> Callable[[Any], Any]:
    """A validator that refuses a value with everything that is wrong with it."""

    def check(value: Any) -> Any:
        if found := wrong(value):
            raise ValueError("\n".join(found))
        return value

    return check


def read_mapping(path: Path) -> ColumnMapping:
    """Read a mapping file, TOML.

    Raises
    ------
    InputError
        No such file, not TOML; unknown keys and values that cannot be, all of them at once.
    """
    document = read_toml(path, what="a mapping file (TOML)", advice="Write a new one with --save-mapping.")
    try:
        _MappingFile.model_validate(document)
    except ValidationError as error:
        wrong = [_sentence(dict(one)) for one in error.errors() if one["loc"][-1:] != ("int",)]  # reported for the other type already
        raise InputError(f"{path}: " + "\n".join(wrong)) from None
    return ColumnMapping(**document)


class _MappingFile(BaseModel):
    """The keys of a mapping file and the types of their values; what they may be is checked as for the options."""

    model_config = ConfigDict(extra="forbid", strict=True, use_attribute_docstrings=True)

    columns: Annotated[dict[str, str | int], AfterValidator(_checked(_wrong_columns))] = {}
    """column of time, elongation and force: its name, or its number counted from 1"""
    units: Annotated[dict[str, str], AfterValidator(_checked(_wrong_units))] = {}
    """unit of time, elongation and force, and of position and angle of a trajectory; what is left out must stand in the file"""
    delimiter: str = ""
    """tab, semicolon, comma, bar or space"""
    decimal: str = ""
    """point or comma"""
    encoding: str = ""
    """of the text, as Python names it: "utf-8", "cp1252", "utf-16" and others"""
    header: bool = True
    """false: the first row is data"""
    sample_period_s: Annotated[float, AfterValidator(_checked(_wrong_period))] = 1.0
    """where the files hold no time"""
    name_pattern: str = ""
    """conditions in the names of the files, such as "KDN_{pressure_bar}bar"; they become columns"""
    sheet: str = ""
    """of a workbook with tables in several"""
    up: Annotated[str, AfterValidator(_checked(lambda axis: wrong_axis("up", axis)))] = ""
    """of a file of markers: the axis that points up, x, y or z, or with a minus the other way"""
    across: Annotated[str, AfterValidator(_checked(lambda axis: wrong_axis("across", axis)))] = ""
    """of a file of markers: the axis that becomes x_m; x where it is not given, y where x points up"""
    markers: Annotated[list[str], AfterValidator(_checked(lambda names: wrong_markers("markers", names)))] = []
    """of a file of markers: those on the platform; all where none is named"""


def json_schema() -> dict[str, Any]:
    """The JSON Schema of a mapping file; what has a default here is found from the loop file where it is not given."""
    schema = _MappingFile.model_json_schema()
    found = {key: {name: value for name, value in node.items() if name != "default"} for key, node in schema["properties"].items()}
    return {**schema, "title": "Columns of a bench", "properties": {key: {**node, "default": None} for key, node in found.items()}}


def _sentence(error: dict[str, Any]) -> str:
    """What is wrong at one place of a mapping file, and what was found there."""
    key = ".".join(str(part) for part in error["loc"] if part not in ("str", "int"))
    if error["type"] == "extra_forbidden":
        return f'unknown key "{key}"; {nearest(key, _MappingFile.model_fields)}'
    if error["type"] == "value_error":
        return error["msg"].removeprefix("Value error, ")
    if error["type"] == "dict_type":
        return f"{key} must be a table."
    if isinstance(error["input"], dict):
        return f"{key} must be a single value."
    wanted = error["msg"].removeprefix("Input should be ")
    return f"{key} should be {wanted}, found {found(error['input'])}. Mend the value."


def write_mapping(mapping: ColumnMapping, path: Path) -> None:
    """Write a mapping file that `read_mapping` reads."""
    import tomli_w

    document = {item.name: getattr(mapping, item.name) for item in fields(ColumnMapping)}
    write_text(Path(path), tomli_w.dumps({key: value for key, value in document.items() if value not in (None, {}, (), [])}))


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
