"""The one gate for what is read: regular files no larger than they may be, TOML that ends, and numbers that are plain and finite."""

from __future__ import annotations

import errno
import os
import re
import stat
import tomllib
from argparse import ArgumentTypeError
from collections.abc import Callable
from pathlib import Path
from typing import Any

from measure.common.errors import InputError, clipped, found, nearest

LARGEST_TABLE = 500_000_000  # bytes
LARGEST_TOML = 4_000_000
_DEEPEST = 20
_HEAD = 4096
_WHOLE = 2**63
# Thirty words with points between them: the standard reader of TOML takes the square of their number of steps.
_DOTTED = re.compile(r"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){30}""")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_WHOLE_NUMBER = re.compile(r"[+-]?\d{1,18}", re.ASCII)
_LONGEST_NUMBER = 40


def existing_file(path: Path, *, what: str, most: int | None = None) -> Path:
    """`path` itself, if it is a regular file; else the sentence that says what stands there.

    Parameters
    ----------
    what : was expected, for the sentence.
    most : bytes that such a file may have.

    Raises
    ------
    InputError
        Nothing is there; a folder, a device, a pipe; a link that leads nowhere; too large; not allowed to be read.
    """
    try:
        seen = os.stat(path)
    except (OSError, ValueError) as error:
        raise InputError(_absent(path, what, error)) from None
    kind = stat.S_IFMT(seen.st_mode)
    if kind == stat.S_IFDIR:
        raise InputError(f"{path}: is a folder, and {what} was expected. Name the file in it.")
    if kind != stat.S_IFREG:
        raise InputError(f"{path}: is {_KINDS.get(kind, 'no regular file')}, and {what} was expected. Copy it to a file and name that.")
    if most is not None and seen.st_size > most:
        raise InputError(f"{path}: has {seen.st_size / 1e6:.0f} MB, and {what} has at most {most / 1e6:g} MB. Cut it to what is needed.")
    if not os.access(path, os.R_OK):
        raise InputError(f"{path}: may not be read by you. Ask its owner, or copy it.")
    return path


_KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def _absent(path: Path, what: str, error: OSError | ValueError) -> str:
    code = error.errno if isinstance(error, OSError) else None
    if code == errno.ELOOP:
        return f"{path}: is a link that leads back to itself; {what} was expected. Name the file."
    if code == errno.EACCES:
        return f"{path}: its folder may not be read by you; {what} was expected. Ask its owner, or copy the file."
    if code == errno.ENOENT and path.is_symlink():
        return f"{path}: is a link to {os.readlink(path)}, and nothing is there; {what} was expected. Name the file."
    return f"{path}: no such file; {what} was expected. {_hint(path)}"


def _hint(path: Path) -> str:
    try:
        siblings = sorted(p.name for p in path.parent.iterdir())
    except (OSError, ValueError):
        siblings = []
    hint = nearest(path.name, siblings) if siblings else ""
    return f"D{hint[1:]}" if hint.startswith("did you mean") else "Check the name."


def require_text(path: Path, kind: str) -> None:
    """Refuse a file whose first bytes are no text: it is another kind of file, or empty space on the disk.

    Raises
    ------
    InputError
    """
    with open(path, "rb") as file:
        head = file.read(_HEAD)
    marked = head.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\x00" in head and not marked:
        raise InputError(f"{path}: is not text but {_kind_of(head)}, and {kind} was expected. Export it as comma-separated text.")


def _kind_of(head: bytes) -> str:
    kinds = ((b"\x89PNG", "a picture"), (b"RIFF", "a film or a sound"), (b"\x7fELF", "a program"), (b"\x00" * len(head), "empty space"))
    return next((kind for start, kind in kinds if head.startswith(start)), "a file with zero bytes")


def read_toml(path: Path, *, what: str, advice: str) -> dict[str, Any]:
    """The tables of a TOML file, unchecked but for size, depth and whole numbers beyond 64 bits.

    Parameters
    ----------
    what, advice : what was expected, and what to do where it is not TOML, for the sentences.

    Raises
    ------
    InputError
    """
    raw = existing_file(Path(path), what=what, most=LARGEST_TOML).read_bytes()
    try:
        return parsed_toml(raw.decode("utf-8-sig"))
    except ValueError as error:
        raise InputError(f"{path}: is not TOML: {error}. {advice}") from None


def parsed_toml(text: str) -> dict[str, Any]:
    """The tables of a TOML text.

    Raises
    ------
    ValueError
        With what is wrong, in words that go into a sentence.
    """
    if _DOTTED.search(text):
        raise ValueError("a key has more than thirty parts")
    try:
        tables = tomllib.loads(text.replace("\r\n", "\n"))
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    except tomllib.TOMLDecodeError as error:
        raise ValueError(clipped(str(error), 200)) from None
    except ValueError as error:
        if "digits" not in str(error):
            raise
        raise ValueError("a whole number has thousands of digits") from None
    _require_plain(tables)
    return tables


def _require_plain(tables: dict[str, Any]) -> None:
    layer: list[Any] = [tables]
    for _ in range(_DEEPEST):
        layer = [inner for value in layer for inner in (value.values() if isinstance(value, dict) else value)]
        for value in layer:
            if isinstance(value, int) and abs(value) >= _WHOLE:
                raise ValueError(f"{found(value)} is beyond 64 bits")
        layer = [value for value in layer if isinstance(value, dict | list)]
    if layer:
        raise ValueError("it is nested too deeply")


def number_in(text: str) -> float:
    """The finite number that a text is; `1_0`, digits of other scripts, `nan`, `inf` and 1e999 are none.

    Raises
    ------
    InputError
    """
    shown = text.strip()
    value = float(shown) if len(shown) <= _LONGEST_NUMBER and _NUMBER.fullmatch(shown) else float("inf")
    if abs(value) == float("inf"):
        raise InputError(f'"{clipped(text)}" is not a finite number')
    return value


def number(low: float = float("-inf"), high: float = float("inf"), *, above: float = float("-inf")) -> Callable[[str], float]:
    """The `type` of an option that is a number within bounds; `above` it, not at it."""

    def parse(text: str) -> float:
        try:
            value = number_in(text)
        except InputError as error:
            raise ArgumentTypeError(str(error)) from None
        if not (low <= value <= high and value > above):
            least = f"above {above:g}" if above > low else f"at least {low:g}"
            raise ArgumentTypeError(f"{clipped(text)} cannot be; give a number {least}{_and_at_most(high)}")
        return value

    return parse


def whole(low: int, high: int) -> Callable[[str], int]:
    """The `type` of an option that is a whole number within bounds."""

    def parse(text: str) -> int:
        if not _WHOLE_NUMBER.fullmatch(text.strip()):
            raise ArgumentTypeError(f'"{clipped(text)}" is not a whole number')
        if not low <= int(text) <= high:
            raise ArgumentTypeError(f"{text} cannot be; give a whole number at least {low}{_and_at_most(high)}")
        return int(text)

    return parse


def _and_at_most(high: float) -> str:
    return "" if high == float("inf") else f" and at most {high:g}"
