"""The format of a list of runs (TOML): which films, loops and trajectories belong together, and what differed from run to run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from measure.common.errors import InputError, found, nearest
from measure.readers.column_mapping import ColumnMapping, read_mapping
from simulate.files.model_file import read_document

_CONTAINERS = ".avi .mp4 .mov .mkv .wmv .mpg .ts .gif .y4m .h264 .hevc"
_FILMS = frozenset(f"{_CONTAINERS} .mraw .cih .cihx .cine .tif .tiff".split())

_Axis = Annotated[str, Field(pattern="^[+-]?[xyz]$")]
_CLOSED = ConfigDict(extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True)


def is_film(path: Path) -> bool:
    """Whether a name is that of a film or of a folder of pictures."""
    return path.suffix.lower() in _FILMS or path.is_dir()


class ListedRun(BaseModel):
    """One measurement: a film, a trajectory of the platform, or a loop of an actuator. Names of files count from this file."""

    model_config = _CLOSED

    file: str
    """film (file, or folder of pictures), trajectory (CSV, C3D, TRC, table of Tracker), or loop (CSV, text, workbook, MATLAB, LabVIEW)"""
    hold_out: bool = False
    """true: never used for fitting or naming, only for showing the gap"""
    mapping: str | None = None
    """of a loop or a foreign trajectory: the file that says how it is to be read"""
    up: _Axis | None = None
    """of a file of markers (C3D, TRC): the axis that points up, x, y or z, or with a minus the other way"""
    across: _Axis | None = None
    """of a file of markers: the axis that becomes x_m; x where it is not given, y where x points up"""
    markers: list[str] = []
    """of a file of markers: those on the platform; all where none is named"""
    project: str | None = None
    """of a film: the file with its rate, scale and marks"""
    model: dict[str, Any] = {}
    """what differed from the model in this run, as in the model file: platform.mass_kg = 1.0"""

    def is_film(self, folder: Path) -> bool:
        """Whether it must be measured first; `folder` is that of the list."""
        return self.project is not None or is_film(folder / self.file)

    def reading(self, folder: Path, otherwise: ColumnMapping | None = None) -> ColumnMapping:
        """How its file is read: by the mapping file that it names, else as `otherwise`, its own axes and markers put over it.

        Raises
        ------
        InputError
            The mapping file cannot be used, or a marker is named twice.
        """
        base = read_mapping(folder / self.mapping) if self.mapping else otherwise or ColumnMapping()
        own = {"up": self.up, "across": self.across, "markers": tuple(self.markers)}
        try:
            return replace(base, **{key: value for key, value in own.items() if value})
        except InputError as error:
            raise InputError(f"[[run]] {self.file}: {error}") from None


class Campaign(BaseModel):
    """A list of runs."""

    model_config = _CLOSED

    model: str | None = None
    """the model file that unspool run begins with; other commands are given one"""
    run: list[ListedRun] = []
    """The measurements, a table each; at least one must not be held out."""


def json_schema() -> dict[str, Any]:
    """The JSON Schema of a list of runs."""
    return Campaign.model_json_schema()


def read_list(path: Path) -> Campaign:
    """Read a list of runs; the files that it names are not touched.

    Raises
    ------
    InputError
        No such file, not TOML, unknown keys, values that cannot be; everything at once.
    """
    document = read_document(path)
    if "run" not in document:
        other = [key for key in document if key not in Campaign.model_fields]
        unknown = [f'unknown key "{key}"; {nearest(key, Campaign.model_fields)}\n' for key in other]
        raise InputError(f'{path}: {"".join(unknown)}no [[run]] table; give one for each measurement, with file = "...".')
    try:
        return Campaign.model_validate(document)
    except ValidationError as error:
        rows = document["run"] if isinstance(document["run"], list) else []
        raise InputError(f"{path}: " + "\n".join(_sentence(dict(one), rows) for one in error.errors())) from None


_WANTED = {
    "file": 'give the name of a film or a table, such as file = "test1.csv".',
    "mapping": 'give the name of a mapping file, such as mapping = "bench.toml".',
    "up": 'give the axis of the file that points up, such as up = "z".',
    "across": 'give the axis of the file that becomes x_m, such as across = "x".',
    "markers": 'give the names of the markers on the platform, such as markers = ["A", "B", "C"].',
    "project": 'give the name of a project file, such as project = "film.toml".',
    "hold_out": "give true or false.",
    "model": "give a table of values to change, such as model.platform.mass_kg = 1.0.",
    "run": 'give a table [[run]] for each measurement, with file = "...".',
}


def _sentence(error: Mapping[str, Any], rows: list[Any]) -> str:
    """What is wrong at one place of the list, what was found there, and what to do."""
    place, key = error["loc"], str(error["loc"][-1])
    row = rows[place[1]] if len(place) > 1 and isinstance(place[1], int) else None
    name = row.get("file") if isinstance(row, Mapping) else None
    where = "" if row is None else f"[[run]] {name if isinstance(name, str) else f'number {place[1] + 1}'}: "
    if error["type"] == "extra_forbidden":
        return f'{where}unknown key "{key}"; {nearest(key, (ListedRun if row is not None else Campaign).model_fields)}'
    if error["type"] == "missing":
        return f"{where}no {key}; {_WANTED[key]}"
    wanted = next((_WANTED[part] for part in reversed(place) if part in _WANTED), "mend it.")
    what = where.removesuffix(": ") if row is not None and len(place) == 2 else f"{where}{key}"  # the row itself, which is no table
    return f"{what} is {found(error['input'])}; {wanted}"
