"""The numbers in a MATLAB 5 to 7 file, read with bounds on everything: a damaged one ends in an error, never in a crash.

Of the format only what laboratories put loops into is read: real matrices of any number type and structures of them, packed or
not. Cells, objects, texts and sparse matrices are passed over. (A well-known reader was seen to divide by zero and to
bring the interpreter down on files with a few changed bytes.)
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import numpy as np

from measure.common.arrays import Array

_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_MATRIX, _PACKED = 14, 15
_STRUCTURE, _FIRST_NUMBER, _LAST_NUMBER = 2, 6, 15
_LARGEST = 400_000_000  # bytes, unpacked
_DEEPEST = 5


class Mat5Error(ValueError):
    """The bytes are no MATLAB 5 file, or a damaged one."""


def read_mat5(raw: bytes) -> dict[str, Array]:
    """Every real matrix by name, structures as dotted names.

    Raises
    ------
    Mat5Error
    """
    if len(raw) < 128 or raw[126:128] not in (b"IM", b"MI"):
        raise Mat5Error("it has no MATLAB 5 header")
    order = "<" if raw[126:128] == b"IM" else ">"
    if struct.unpack(order + "H", raw[124:126])[0] != 0x0100:
        raise Mat5Error("it is of version 7.3 or newer")
    found: dict[str, Array] = {}
    for kind, data in _elements(raw[128:], order):
        for inner_kind, inner in _elements(_unpacked(data), order) if kind == _PACKED else [(kind, data)]:
            if inner_kind == _MATRIX:
                found.update(_matrix(inner, order, "", 0))
    return found


def _unpacked(data: bytes) -> bytes:
    machine = zlib.decompressobj()
    try:
        made = machine.decompress(data, _LARGEST)
    except zlib.error as error:
        raise Mat5Error(f"a packed part is damaged: {error}") from error
    if machine.unconsumed_tail or not machine.eof:
        raise Mat5Error("a packed part is cut or too large")
    return made


def _elements(raw: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Type and content of one element after the other."""
    place = 0
    while place < len(raw):
        if place + 8 > len(raw):
            raise Mat5Error("it is cut")
        kind, size = struct.unpack(order + "II", raw[place : place + 8])
        if kind >> 16:
            kind, size, start, end = kind & 0xFFFF, kind >> 16, place + 4, place + 8
        else:
            start = place + 8
            end = start + size + (-size % 8 if kind != _PACKED else 0)
        if start + size > len(raw) or (kind >> 16 == 0 and size > end - start):
            raise Mat5Error("it is cut")
        yield kind, raw[start : start + size]
        place = end


def _matrix(raw: bytes, order: str, before: str, depth: int) -> Iterator[tuple[str, Array]]:
    parts = list(_elements(raw, order))
    if len(parts) < 3 or len(parts[0][1]) < 4:
        return
    flags = struct.unpack(order + "I", parts[0][1][:4])[0]
    kind, is_complex = flags & 0xFF, bool(flags & 0x800)
    shape = tuple(int(n) for n in _numbers(parts[1], order))
    name = before + parts[2][1].decode("latin-1").strip("\x00")
    if kind == _STRUCTURE and depth < _DEEPEST:
        yield from _structure(parts, shape, order, name, depth)
    elif _FIRST_NUMBER <= kind <= _LAST_NUMBER and len(parts) > 3 and not is_complex:
        values = _numbers(parts[3], order).astype(float)
        if any(n < 0 for n in shape) or float(np.prod(np.array(shape, dtype=float))) != len(values):
            raise Mat5Error(f'"{name}" does not hold as many numbers as it says')
        yield name, values.reshape(shape, order="F")


def _structure(parts: list[tuple[int, bytes]], shape: tuple[int, ...], order: str, name: str, depth: int) -> Iterator[tuple[str, Array]]:
    """The fields of a structure of one element; arrays of structures are passed over."""
    if shape != (1, 1) or len(parts) < 5:
        return
    width = int(_numbers(parts[3], order)[0]) if len(parts[3][1]) else 0
    if width <= 0:
        raise Mat5Error(f'the fields of "{name}" have no names')
    words = [parts[4][1][k : k + width].split(b"\x00")[0].decode("latin-1") for k in range(0, len(parts[4][1]), width)]
    for word, (kind, data) in zip(words, parts[5:], strict=False):
        if kind == _MATRIX:
            yield from _matrix(data, order, f"{name}.{word}", depth + 1)


def _numbers(part: tuple[int, bytes], order: str) -> Array:
    kind, data = part
    if kind not in _TYPES or len(data) % int(_TYPES[kind][1]):
        raise Mat5Error("a number has an unknown type")
    return np.frombuffer(data, dtype=np.dtype(order + _TYPES[kind]))
