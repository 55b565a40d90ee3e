"""What a file holds, by its content: a result takes the place of an older file only where that is of the same kind."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Collection
from pathlib import Path

from measure.common.inputs import LARGEST_TOML, parsed_toml

JSON, PAGE, XML, TEXT, PYTHON, ARCHIVE = "JSON", "a page (HTML)", "XML", "text", "Python", "an archive or a workbook"
TABLE, FITTED = "a table of results", "a model that a command has written"
FIGURE, FILM, HDF5, NETCDF = "a figure (PNG, PDF, SVG)", "a film", "data (HDF5)", "data (netCDF)"
RUNS, PROJECT, MAPPING, MODEL = "a list of runs", "a film project", "the columns of a bench", "a model that no command has written"
LOOP, MEASUREMENT, PICTURE, TOML, DATA = "a measured loop", "a measurement", "a picture", "TOML", "binary data"

_ENDINGS = {".json": JSON, ".csv": TABLE, ".toml": FITTED, ".py": PYTHON, ".h5": HDF5, ".nc": NETCDF, ".mjcf": XML}
_ENDINGS |= {".png": FIGURE, ".pdf": FIGURE, ".svg": FIGURE, ".html": PAGE, ".htm": PAGE, ".avi": FILM}
_OPTIONS = {"--json": JSON, "--page": PAGE, "--report": PAGE, "--choose": PAGE, "--figure": FIGURE, "--overlay": FILM, "--mjcf": XML}
_OPTIONS |= {"--marks": TABLE, "--legs": TABLE, "--energy": TABLE, "--curve": TABLE, "--save-mapping": MAPPING}
_FIRST_BYTES = (
    *((b"\x89PNG", FIGURE), (b"%PDF", FIGURE), (b"\x89HDF", HDF5), (b"CDF\x01", NETCDF), (b"CDF\x02", NETCDF), (b"PK\x03\x04", ARCHIVE)),
    *((b"\xff\xd8\xff", PICTURE), (b"II*\x00", PICTURE), (b"MM\x00*", PICTURE), (b"GIF8", PICTURE)),
    *((b"RIFF", FILM), (b"\x1aE\xdf\xa3", FILM)),
)
_FILM_TABLES = {"film", "marks", "scale", "camera"}
_MAPPING_KEYS = {"columns", "units", "up", "across", "markers"}
_MODEL_TABLES = {"platform", "actuator", "geometry", "end_stop", "gravity", "release", "simulation", "nuisance", "effect"}
_IN_OUR_TABLES = {"time_s", "diverged_at_s", "variability_percent", "vertical_force_N"}  # every table of ours has one of them
_HEAD = 1 << 16
_BETWEEN_CELLS = re.compile(r"[,;\t |]+")
_LEAST_ROWS = 3


def kind_written(label: str, path: Path) -> str | None:
    """What an option writes, or else what a file of such an ending holds; None where neither is known."""
    return _OPTIONS.get(label) or _ENDINGS.get(path.suffix.lower())


def kind_of(path: Path) -> str | None:
    """What a file holds; None where it holds nothing, cannot be read, or holds words that are nothing that is known here."""
    try:
        with open(path, "rb") as file:
            head = file.read(_HEAD)
        if b"\x00" in head and not head.startswith((b"\xff\xfe", b"\xfe\xff")):
            return _by_first_bytes(head) or DATA
        return _by_first_bytes(head) or _kind_of_text(path, head)
    except OSError:
        return None


def kind_of_toml(keys: Collection[str]) -> str:
    """What a TOML file holds, by the names of its tables."""
    if "run" in keys:
        return RUNS
    if _FILM_TABLES & set(keys):
        return PROJECT
    if _MODEL_TABLES & set(keys):
        return FITTED if "provenance" in keys else MODEL
    return MAPPING if _MAPPING_KEYS & set(keys) else TOML


def _by_first_bytes(head: bytes) -> str | None:
    if head[4:8] == b"ftyp":
        return FILM
    return next((kind for start, kind in _FIRST_BYTES if head.startswith(start)), None)


def _kind_of_text(path: Path, head: bytes) -> str | None:
    marked = head.startswith((b"\xff\xfe", b"\xfe\xff"))
    shown = head.decode("utf-16" if marked else "utf-8-sig", "replace").lstrip()
    if shown.startswith(("<", "{")):
        return JSON if shown[0] == "{" else _kind_of_markup(shown.lower())
    tables = _tables_of(path)
    if tables:
        return kind_of_toml(tables)
    if shown.startswith("["):
        return JSON
    return _kind_of_table(shown) or (PYTHON if shown and path.suffix.lower() == ".py" else None)


def _kind_of_markup(shown: str) -> str:
    if shown.startswith(("<!doctype html", "<html")):
        return PAGE
    return FIGURE if "<svg" in shown else XML


def _tables_of(path: Path) -> Collection[str]:
    if os.path.getsize(path) > LARGEST_TOML:
        return ()
    try:
        return parsed_toml(path.read_text(encoding="utf-8-sig")).keys()
    except ValueError:
        return ()


def _kind_of_table(shown: str) -> str | None:
    """One of this project's own tables, which are commas below one row of names, or rows of numbers of somebody else."""
    lines = shown.splitlines()
    names = set(next(csv.reader(lines[:1]), [])) if len(shown) else set()
    if {"elongation_m", "force_N"} <= names and "fitted_N" not in names:
        return LOOP
    if names & _IN_OUR_TABLES:
        return TABLE
    return MEASUREMENT if sum(map(_is_row, lines)) >= _LEAST_ROWS else None


def _is_row(line: str) -> bool:
    """Whether a line is two numbers or more, the first of which may be a time of day."""
    cells = [cell for cell in _BETWEEN_CELLS.split(line.strip()) if cell]
    return len(cells) >= 2 and all(cell[-1].isdigit() and (cell[0].isdigit() or cell[0] in "+-.") for cell in cells)
