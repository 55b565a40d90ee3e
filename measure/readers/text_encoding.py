"""The text of a file, whatever its encoding."""

from __future__ import annotations

import codecs
from pathlib import Path

from measure.common.errors import InputError, clipped
from measure.common.inputs import LARGEST_TABLE, existing_file, require_text

LARGEST_FILE = LARGEST_TABLE
# Of host names and programs, not of tables: some take the square of the size of a file, or read what is written as something else.
_NOT_OF_TABLES = ("idna", "punycode", "unicode-escape", "raw-unicode-escape", "undefined", "utf-7")
_BOMS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))


def decoded(path: Path, encoding: str | None) -> tuple[str, str]:
    """The text of a file, and the encoding it was read with.

    Raises
    ------
    InputError
        Too large, not text, an unknown or a wrong encoding.
    """
    existing_file(path, what="a table of force and elongation", most=LARGEST_FILE)
    if encoding is None:
        require_text(path, "a table of force and elongation")
    elif not _is_known(encoding):
        raise InputError(f'--encoding {clipped(encoding)}: no such encoding; try "utf-8", "utf-16" or "cp1252".')
    raw = path.read_bytes()
    marked = next((name for mark, name in _BOMS if raw.startswith(mark)), None)
    candidates = [encoding] if encoding else [marked] if marked else ["utf-8", "cp1252"]
    if not marked and not encoding and b"\x00" in raw:
        raise InputError(f"{path}: is not text (it holds zero bytes). Export the loop as text, or give --encoding.")
    for name in candidates:
        try:
            return raw.decode(name), name
        except UnicodeError:
            continue
    raise InputError(f"{path}: cannot be read as {candidates[-1]} text. Give --encoding, or export it as UTF-8.")


def _is_known(encoding: str) -> bool:
    """Whether Python knows it as an encoding of text, and tables are written in it."""
    try:
        found = codecs.lookup(encoding)
    except (LookupError, ValueError):
        return False
    return getattr(found, "_is_text_encoding", True) and found.name.replace("_", "-") not in _NOT_OF_TABLES
