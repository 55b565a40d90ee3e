"""The text of a file, whatever its encoding."""

from __future__ import annotations

from pathlib import Path

from measure.common.errors import InputError

LARGEST_FILE = 500_000_000  # bytes
_BOMS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))


def decoded(path: Path, encoding: str | None) -> tuple[str, str]:
    """The text of a file, and the encoding it was read with.

    Raises
    ------
    InputError
        Too large, not text, an unknown or a wrong encoding.
    """
    if path.stat().st_size > LARGEST_FILE:
        raise InputError(f"{path}: is larger than {LARGEST_FILE // 1_000_000} MB; that is no table of a loop. Cut it to the test.")
    raw = path.read_bytes()
    marked = next((name for mark, name in _BOMS if raw.startswith(mark)), None)
    candidates = [encoding] if encoding else [marked] if marked else ["utf-8", "cp1252"]
    if not marked and not encoding and b"\x00" in raw:
        raise InputError(f"{path}: is not text (it holds zero bytes). Export the loop as text, or give --encoding.")
    for name in candidates:
        try:
            return raw.decode(name), name
        except LookupError as error:
            raise InputError(f'--encoding {name}: no such encoding; try "utf-8", "utf-16" or "cp1252".') from error
        except UnicodeDecodeError:
            continue
    raise InputError(f"{path}: cannot be read as {candidates[-1]} text. Give --encoding, or export it as UTF-8.")
