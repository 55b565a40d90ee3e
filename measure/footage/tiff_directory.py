"""How many pictures a TIFF holds and how large they are, from its directories alone.

TIFF 6.0, section 2; BigTIFF (offsets of 64 bit) likewise.
"""

from __future__ import annotations

import struct

_WIDTH, _HEIGHT, _SHORT = 256, 257, 3
_MOST_PAGES = 1_000_000
_MOST_TAGS = 512


def is_tiff(head: bytes) -> bool:
    """Whether a file that begins with these bytes (four at least) is a TIFF or BigTIFF."""
    return head[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")


def page_sizes(data: bytes | memoryview) -> list[tuple[int, int]]:
    """Sizes of all pictures of a TIFF, in the order of the file.

    Parameters
    ----------
    data : bytes or memoryview
        The whole file; it may be memory-mapped.

    Returns
    -------
    list of (int, int)
        Width and height of each, px. A chain of directories that is damaged ends there; it may be empty.
    """
    order = "<" if bytes(data[:2]) == b"II" else ">"
    big = bytes(data[2:4]) in (b"+\0", b"\0+")
    sizes: list[tuple[int, int]] = []
    known: set[int] = set()
    try:
        (place,) = struct.unpack_from(order + ("Q" if big else "I"), data, 8 if big else 4)
        while place and place not in known and len(sizes) < _MOST_PAGES:
            known.add(place)
            size, place = _directory(data, place, order, big)
            sizes.append(size)
    except (struct.error, KeyError):
        pass
    return sizes


def _directory(data: bytes | memoryview, place: int, order: str, big: bool) -> tuple[tuple[int, int], int]:
    """Size of the picture of one directory, and where the next directory stands."""
    count_code, entry, entry_size, next_code = ("Q", "HHQ", 20, "Q") if big else ("H", "HHI", 12, "I")
    (count,) = struct.unpack_from(order + count_code, data, place)
    if count > _MOST_TAGS:
        raise struct.error
    start, sizes = place + struct.calcsize("=" + count_code), {}
    for i in range(count):
        at = start + entry_size * i
        tag, kind, _ = struct.unpack_from(order + entry, data, at)
        if tag in (_WIDTH, _HEIGHT):
            (sizes[tag],) = struct.unpack_from(order + ("H" if kind == _SHORT else "I"), data, at + struct.calcsize("=" + entry))
    (following,) = struct.unpack_from(order + next_code, data, start + entry_size * count)
    return (sizes[_WIDTH], sizes[_HEIGHT]), following
