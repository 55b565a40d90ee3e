"""Phantom films: `.cine` at 8, packed 10 and 12, and 16 bit, as the camera stored them; memory-mapped.

Layout: Vision Research, Cine File Format. A packed 10-bit film is handed out as its stored values, without the
camera's brightness curve.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measure.common.errors import InputError
from measure.footage.footage import Footage, Picture, check_size
from measure.footage.packed_pixels import unpack

_HEADER = struct.Struct("<2sHHHiIiIIIIQ")
_BITMAP = struct.Struct("<IiiHHIIiiII")
_PACKED = {256: 10, 1024: 12}
_RATE_AT = 768
_LARGEST_NOTE = 2**20


@dataclass(frozen=True)
class PhantomFilm(Footage):
    """A Phantom film.

    Attributes
    ----------
    path : Path
    stored_bits : int
        Of a pixel in the file.
    offsets : (frames,) tuple of int
        Bytes from the start of the file to the pixels of each picture.
    upside_down : bool
        Whether the lowest row comes first.
    """

    path: Path = Path()
    stored_bits: int = 8
    offsets: tuple[int, ...] = ()
    upside_down: bool = False

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame; the stream ends where the file does."""
        size = self.width * self.height * self.stored_bits // 8
        data = np.memmap(self.path, np.uint8, mode="r")
        for number, start in enumerate(self.offsets):
            if start + size > len(data):
                return
            picture = unpack(data[start : start + size], self.stored_bits, self.width, self.height)
            yield number, picture[::-1] if self.upside_down else picture


def is_cine(head: bytes) -> bool:
    """Whether a file with these first bytes (44 at least) is a `.cine`: its mark, which some tools blank, and a header of 44 bytes."""
    return len(head) >= 44 and head[:2] in (b"CI", b"\0\0") and head[2:4] == b"\x2c\0" and head[24:28] == b"\x2c\0\0\0"


def open_cine(path: Path) -> Footage:
    """Open a `.cine`.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Footage
        With the capture rate and exposure that the camera noted.

    Raises
    ------
    InputError
        It is cut within its headers, compressed, in colour, or of an unknown depth.
    """
    try:
        return _opened(path)
    except struct.error:
        raise InputError(f"{path}: begins like a Phantom film and is cut or damaged. Copy it again from the camera.") from None


def _opened(path: Path) -> Footage:
    mapped = memoryview(np.memmap(path, np.uint8, mode="r"))  # type: ignore[arg-type]
    _, _, compression, _, _, _, _, frames, at_bitmap, at_setup, at_offsets, _ = _HEADER.unpack_from(mapped, 0)
    _, width, rows, _, bit_count, packing, _, _, _, _, levels = _BITMAP.unpack_from(mapped, at_bitmap)
    height = abs(rows)
    check_size(path, width, height)
    stored = _PACKED.get(packing, bit_count if packing == 0 else 0)
    if compression != 0 or stored not in (8, 10, 12, 16):
        raise InputError(
            f"{path}: compression {compression}, packing {packing}, {bit_count} bit; grey films stored raw at 8, packed 10 or 12, "
            "or 16 bit are read. Save it again as an uncompressed grey cine."
        )
    if frames < 1 or at_offsets + 8 * frames > len(mapped):
        raise struct.error
    offsets = _pixels(mapped, struct.unpack_from(f"<{frames}Q", mapped, at_offsets), width * height * stored // 8)
    rate, exposure = _clock(mapped, at_setup)
    bits = min(stored, max(int(levels) - 1, 1).bit_length()) if stored == 16 and levels else stored
    return PhantomFilm(
        str(path), width, height, bits, frames, rate, exposure,
        path=path, stored_bits=stored, offsets=offsets, upside_down=rows > 0 and packing == 0,
    )  # fmt: skip


def _pixels(mapped: memoryview, starts: tuple[int, ...], size: int) -> tuple[int, ...]:
    """Where the pixels begin: behind a note whose own length stands first and the picture's last.

    Some tools write no notes; there the pixels begin behind what the spacing of the pictures leaves over.
    """
    spare = max(starts[1] - starts[0] - size, 0) if len(starts) > 1 else 0
    return tuple(start + (_note_length(mapped, start, size) or spare) for start in starts)


def _note_length(mapped: memoryview, start: int, size: int) -> int:
    if start + 8 > len(mapped):
        return 0
    (length,) = struct.unpack_from("<I", mapped, start)
    if not 8 <= length <= min(_LARGEST_NOTE, len(mapped) - start):
        return 0
    return length if struct.unpack_from("<I", mapped, start + length - 4)[0] == size else 0


def _clock(mapped: memoryview, at_setup: int) -> tuple[float | None, float | None]:
    """Frames per second and exposure in seconds, where the film carries the camera's settings."""
    if at_setup == 0 or at_setup + _RATE_AT + 8 > len(mapped) or bytes(mapped[at_setup + 140 : at_setup + 142]) != b"ST":
        return None, None
    rate, shutter_us = struct.unpack_from("<II", mapped, at_setup + _RATE_AT)
    return float(rate) or None, shutter_us * 1e-6 or None
