"""Folders of numbered pictures (TIFF, PNG, BMP), in full depth, in the order of their numbers."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

from measure.common.errors import InputError
from measure.common.limits import limited
from measure.footage.footage import Footage, Picture, check_size

_NAMES = (".tif", ".tiff", ".png", ".bmp")
_LARGEST_FILE = 512 * 2**20


@dataclass(frozen=True)
class ImageFolder(Footage):
    """A film as a folder of pictures; files and numbers belong together, a missing number is a missing frame."""

    files: tuple[Path, ...] = ()
    numbers: tuple[int, ...] = ()

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame; a picture that cannot be decoded ends the film."""
        for number, file in zip(self.numbers, self.files, strict=True):
            picture = _decode(file, (self.width, self.height))
            if picture is None:
                return
            yield number, picture


def open_folder(folder: Path) -> Footage:
    """Open a folder of pictures named by numbers, such as `frame_0001.tif`.

    Raises
    ------
    InputError
        No pictures, no numbers, numbers used twice, pictures of different sizes.
    """
    files = [file for file in folder.iterdir() if file.suffix.lower() in _NAMES and file.is_file() and not file.name.startswith(".")]
    if len(files) < 2:
        raise InputError(
            f"{folder}: holds {len(files)} pictures ({', '.join(_NAMES)}); a film needs two at least. Name the folder that holds them."
        )
    numbered = sorted((_number(file), file) for file in files)
    numbers, files = [n for n, _ in numbered], [f for _, f in numbered]
    steps = np.diff(numbers)
    if steps.min() == 0:
        twice = int(np.argmin(steps))
        raise InputError(f"{folder}: {files[twice].name} and {files[twice + 1].name} have the same number. Keep one film in a folder.")
    step = int(steps.min())
    places = [(n - numbers[0]) // step for n in numbers]
    first = _decode(files[0], None)
    if first is None:
        raise InputError(f"{files[0]}: cannot be decoded; it is cut or damaged. Copy it again.")
    height, width = first.shape
    return ImageFolder(
        str(folder), width, height, 8 * first.dtype.itemsize, places[-1] + 1,
        remarks=_gaps(numbers, step), files=tuple(files), numbers=tuple(places),
    )  # fmt: skip


def read_mask(file: Path, width: int, height: int) -> np.ndarray:
    """A picture as large as a film's, as truth values (height, width): white belongs to marks, black does not.

    Raises
    ------
    InputError
        No such file, no picture, another size.
    """
    from measure.common.command_line import existing_file

    picture = _decode(existing_file(file, what="a mask (PNG, BMP, TIFF)"), (width, height), "the film")
    if picture is None:
        raise InputError(f"{file}: cannot be decoded; it is cut or damaged. Save it again.")
    return picture > np.iinfo(picture.dtype).max // 2


def _gaps(numbers: list[int], step: int) -> tuple[str, ...]:
    gaps = [(a, b) for a, b in pairwise(numbers) if b - a != step]
    if not gaps:
        return ()
    shown = ", ".join(f"{a} to {b}" for a, b in gaps[:3]) + (", ..." if len(gaps) > 3 else "")
    return (f"the numbering jumps {len(gaps)} times ({shown}); frames are missing there",)


def _number(file: Path) -> int:
    """The last number in a name; it orders frame_9 before frame_10."""
    found = re.findall(r"\d+", file.stem)
    if not found:
        raise InputError(f"{file}: has no number in its name; the order of the film is not known. Number the pictures, or remove this one.")
    return int(found[-1])


def _decode(file: Path, size: tuple[int, int] | None, like: str = "the first picture") -> Picture | None:
    """Grey values in full depth, or None where the file is damaged; its size is checked before decoding."""
    if file.stat().st_size > _LARGEST_FILE:
        raise InputError(f"{file}: is larger than {_LARGEST_FILE // 2**20} MB. Save one picture per file.")
    data = file.read_bytes()
    kind = picture_kind(data[:16])
    if kind is None:
        raise InputError(f"{file}: is not a {file.suffix} picture; its first bytes are {data[:8]!r}. Remove it or save it again.")
    said = picture_size(data, kind)
    if said is None:
        return None
    check_size(file, *said)
    if size is not None and said != size:
        raise InputError(f"{file}: is {said[0]} x {said[1]} px, {like} {size[0]} x {size[1]} px. Keep to one size.")
    with limited(file):
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if picture is None or picture.dtype not in (np.uint8, np.uint16):
        return None
    if picture.ndim == 3:
        picture = cv2.cvtColor(picture[:, :, :3], cv2.COLOR_BGR2GRAY)
    return picture  # type: ignore[return-value]


def picture_kind(head: bytes) -> str | None:
    """What picture a file that begins with these bytes is."""
    kinds = {b"\x89PNG": "png", b"II*\0": "tiff", b"MM\0*": "tiff"}
    return kinds.get(head[:4]) or ("bmp" if head[:2] == b"BM" else None)


def picture_size(data: bytes, kind: str) -> tuple[int, int] | None:
    """Width and height that a picture's header gives, px, or None where the header is cut."""
    try:
        if kind == "png":
            return struct.unpack(">II", data[16:24])  # type: ignore[return-value]
        if kind == "bmp":
            width, height = struct.unpack("<ii", data[18:26])
            return width, abs(height)
        return _tiff_size(data)
    except (struct.error, KeyError):
        return None


def _tiff_size(data: bytes) -> tuple[int, int]:
    """Width and height from tags 256 and 257 of the first directory (TIFF 6.0, section 2)."""
    order = "<" if data[:2] == b"II" else ">"
    (start,) = struct.unpack_from(order + "I", data, 4)
    (count,) = struct.unpack_from(order + "H", data, start)
    sizes = {}
    for i in range(min(count, 512)):
        tag, kind, _ = struct.unpack_from(order + "HHI", data, start + 2 + 12 * i)
        if tag in (256, 257):
            (sizes[tag],) = struct.unpack_from(order + ("H" if kind == 3 else "I"), data, start + 10 + 12 * i)
    return sizes[256], sizes[257]
