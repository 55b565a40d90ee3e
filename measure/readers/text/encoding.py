"""The text of a file, whatever its encoding."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from pathlib import Path

from measure.common.errors import InputError, clipped
from measure.common.inputs import LARGEST_TABLE, existing_file, require_text

LARGEST_FILE = LARGEST_TABLE
# Of host names and programs, not of tables: some take the square of the size of a file, or read what is written as something else.
_NOT_OF_TABLES = ("idna", "punycode", "unicode-escape", "raw-unicode-escape", "undefined", "utf-7")
_BOMS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_HEAD = 4096
_LOOKED_AT = 1 << 20
# Words of test machines by which an encoding of two bytes a letter is recognised: other bytes hardly ever spell them.
_WORDS = {
    "gb18030": re.compile("时间|時間|位移|载荷|荷载|负荷|试验|伸长|行程|变形|毫米|牛顿|千牛|力|秒|通道|采样|日期"),
    "cp932": re.compile("時間|変位|荷重|試験|伸び|ストローク|力|秒|日付|チャンネル|データ"),
}


def decoded(path: Path, encoding: str | None) -> tuple[str, str]:
    """The text of a file, and the encoding it was read with.

    Raises
    ------
    InputError
        Too large, not text, an unknown or a wrong encoding.
    """
    existing_file(path, what="a table of force and elongation", most=LARGEST_FILE)
    if encoding is not None and not _is_known(encoding):
        raise InputError(f'--encoding {clipped(encoding)}: no such encoding; try "utf-8", "utf-16", "gb18030" or "cp1252".')
    marked = encoding or _marked(path)
    raw = path.read_bytes()
    if not marked and b"\x00" in raw:
        raise InputError(f"{path}: is not text (it holds zero bytes). Export the loop as text, or give --encoding.")
    name = "utf-8"
    for name in [marked] if marked else _likely(raw):
        try:
            return raw.decode(name), name
        except UnicodeError:
            continue
    raise InputError(f"{path}: cannot be read as {name} text. Give --encoding, or export it as UTF-8.")


def _marked(path: Path) -> str:
    """The encoding that the first bytes give away: a byte order mark, or a zero at every second place; else nothing."""
    with open(path, "rb") as file:
        head = file.read(_HEAD)
    name = next((name for mark, name in _BOMS if head.startswith(mark)), "") or _without_mark(head)
    if not name:
        require_text(path, "a table of force and elongation")
    return name


def _likely(raw: bytes) -> Iterator[str]:
    """Encodings in the order in which they are tried."""
    yield "utf-8"
    yield from _of_two_bytes(raw)
    yield "cp1252"


def _without_mark(head: bytes) -> str:
    """UTF-16 without a mark: in a table nearly every second byte is zero, and of the others none is."""
    even, odd = head[0::2], head[1::2]
    for zeros, letters, name in ((odd, even, "utf-16-le"), (even, odd, "utf-16-be")):
        if len(zeros) > 8 and zeros.count(0) > 0.7 * len(zeros) and not letters.count(0):
            return name
    return ""


def _of_two_bytes(raw: bytes) -> list[str]:
    """The Chinese or Japanese encoding in which the words of the file are those of a test machine; nothing where none fits."""
    found = {}
    for name, words in _WORDS.items():
        shown = raw[:_LOOKED_AT].decode(name, "replace")
        strange = len(re.findall(r"[\ufffd\ue000-\uf8ff\uff61-\uff9f]", shown))
        found[name] = len("".join(words.findall(shown))) - 2 * strange
    best = max(found, key=lambda name: found[name])
    return [best] if found[best] > 0 else []


def _is_known(encoding: str) -> bool:
    """Whether Python knows it as an encoding of text, and tables are written in it."""
    try:
        found = codecs.lookup(encoding)
    except (LookupError, ValueError):
        return False
    return getattr(found, "_is_text_encoding", True) and found.name.replace("_", "-") not in _NOT_OF_TABLES
