"""A file of samples as a table, whatever format it is in; what format shows in its first bytes, its name only where they leave it open."""

from __future__ import annotations

import zipfile
from pathlib import Path

from measure.common.errors import InputError
from measure.readers.column_mapping import ColumnMapping
from measure.readers.formats.guarded import read_hdf5, read_matlab, read_uff, read_workbook
from measure.readers.formats.json_table import looks_like_json, read_json
from measure.readers.formats.labview import read_lvm, read_tdms
from measure.readers.text.table import read_text_table
from measure.tables.raw_table import RawTable

_HDF5 = b"\x89HDF\r\n\x1a\n"
_OLD_WORKBOOK = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_FOREIGN = (
    (b"%PDF", "a PDF document", "Export the numbers as text from the program that made it."),
    (b"\x1f\x8b", "packed with gzip", "Unpack it and name what is in it."),
    (b"7z\xbc\xaf", "a packed archive", "Unpack it and name what is in it."),
    (b"Rar!", "a packed archive", "Unpack it and name what is in it."),
    (b"<!doctype html", "a web page", "Open it with a spreadsheet and save it as CSV UTF-8."),
    (b"<html", "a web page", "Open it with a spreadsheet and save it as CSV UTF-8."),
    (b"<?xml", "an XML document", "Open it with the program that made it and save it as CSV UTF-8 or .xlsx."),
)


def read_raw_table(path: Path, wanted: ColumnMapping) -> RawTable:
    """The columns of a file under the names that they have there.

    Raises
    ------
    InputError
        A format that is not read, a file that is none of what it begins as, an extra that is not installed.
    """
    with open(path, "rb") as file:
        head = file.read(520)
    if head.startswith(b"MATLAB 7.3") or _HDF5 in (head[:8], head[512:]):
        return read_hdf5(path)
    if head.startswith(b"MATLAB 5.0 MAT-file") or path.suffix.lower() == ".mat":
        return read_matlab(path)
    if head.startswith(b"TDSm"):
        return read_tdms(path)
    if head.startswith(_OLD_WORKBOOK) or head.startswith(b"PK\x03\x04"):
        _require_workbook(path, head)
        return read_workbook(path, wanted.sheet)
    return _of_text(path, wanted, head)


def _of_text(path: Path, wanted: ColumnMapping, head: bytes) -> RawTable:
    shown = head.removeprefix(b"\xef\xbb\xbf")
    if shown.startswith(b"LabVIEW Measurement"):
        return read_lvm(path, wanted.encoding)
    if [line.strip() for line in shown.splitlines()[:1]] == [b"-1"] and shown.splitlines()[1:2]:
        return read_uff(path)
    for start, what, advice in _FOREIGN:
        if shown.lstrip().lower().startswith(start.lower()):
            raise InputError(f"{path}: is {what}, and a table of force and elongation was expected. {advice}")
    if looks_like_json(head) and (table := read_json(path, wanted.encoding)) is not None:
        return table
    return read_text_table(path, wanted.delimiter, wanted.decimal, wanted.encoding, wanted.header)


def _require_workbook(path: Path, head: bytes) -> None:
    """Refuse an archive that is no workbook."""
    if head.startswith(_OLD_WORKBOOK):
        return
    try:
        with zipfile.ZipFile(path) as packed:
            names = packed.namelist()
    except (zipfile.BadZipFile, OSError, NotImplementedError, ValueError):
        raise InputError(f"{path}: is a workbook or archive that is cut or damaged. Save it again, or export the sheet as CSV.") from None
    if not any(name.startswith("xl/") or name == "content.xml" for name in names):
        raise InputError(f"{path}: is a zip archive of {len(names)} files, not a workbook. Unpack it and name the file in it.")
