"""Picture files (TIFF, PNG, BMP, JPEG) as grey values in full depth; the size is checked before anything is decoded."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.common.inputs import existing_file
from measure.common.limits import limited
from measure.footage.footage import Picture, check_size
from measure.footage.tiff_directory import is_tiff, page_sizes

SUFFIXES = (".tif", ".tiff", ".png", ".bmp", ".jpg", ".jpeg")
_LARGEST_FILE = 512 * 2**20
_JPEG_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
"""Markers of a JPEG that are followed by the picture's size (ITU T.81, table B.1)."""


def picture_kind(head: bytes) -> str | None:
    """Which kind of picture a file is.

    Parameters
    ----------
    head : bytes
        The first bytes of the file, four at least.

    Returns
    -------
    str or None
        "png", "tiff", "bmp" or "jpeg"; None for anything else.
    """
    if is_tiff(head):
        return "tiff"
    kinds = {b"\x89PN": "png", b"\xff\xd8\xff": "jpeg"}
    return kinds.get(head[:3]) or ("bmp" if head[:2] == b"BM" else None)


def picture_size(data: bytes, kind: str) -> tuple[int, int] | None:
    """Width and height that the header of a picture states.

    Parameters
    ----------
    data : bytes
        The whole file.
    kind : str
        From `picture_kind`.

    Returns
    -------
    (int, int) or None
        px; None where the header is cut.
    """
    try:
        if kind == "png":
            return struct.unpack(">II", data[16:24])  # type: ignore[return-value]
        if kind == "bmp":
            width, height = struct.unpack("<ii", data[18:26])
            return width, abs(height)
        return _jpeg_size(data) if kind == "jpeg" else page_sizes(data)[0]
    except (struct.error, IndexError):
        return None


def _jpeg_size(data: bytes) -> tuple[int, int]:
    """Size from the frame header, found by stepping from marker to marker."""
    place = 2
    while True:
        mark, kind, length = struct.unpack_from(">BBH", data, place)
        if mark != 0xFF:
            raise struct.error
        if kind in _JPEG_FRAMES:
            height, width = struct.unpack_from(">HH", data, place + 5)
            return width, height
        place += 2 + length


def read_picture(file: Path, size: tuple[int, int] | None = None, like: str = "the first picture") -> NDArray | None:
    """Grey values of a picture file.

    Parameters
    ----------
    file : Path
        TIFF, PNG, BMP or JPEG; what it is shows in its first bytes, not in its name.
    size : (int, int), optional
        Width and height that it must have, px.
    like : str
        What has that size, for the message.

    Returns
    -------
    (height, width) array of uint8, uint16, float32 or float64, or None
        None where the file is damaged. Colours are weighted to grey.

    Raises
    ------
    InputError
        Not a picture, several pictures in one file, too large, another size.
    """
    if file.stat().st_size > _LARGEST_FILE:
        raise InputError(f"{file}: is larger than {_LARGEST_FILE // 2**20} MB. Save one picture per file.")
    data = file.read_bytes()
    kind = picture_kind(data[:16])
    if kind is None:
        raise InputError(f"{file}: is not a {file.suffix} picture; its first bytes are {data[:8]!r}. Remove it or save it again.")
    stated = picture_size(data, kind)
    if stated is None:
        return None
    check_size(file, *stated)
    if size is not None and stated != size:
        raise InputError(f"{file}: is {stated[0]} x {stated[1]} px, {like} {size[0]} x {size[1]} px. Keep to one size.")
    if kind == "tiff" and len(page_sizes(data)) > 1:
        raise InputError(f"{file}: holds {len(page_sizes(data))} pictures. Name the file itself as the film, or save one picture per file.")
    with limited(file):
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    return None if picture is None else to_grey(picture)


def to_grey(picture: NDArray) -> NDArray | None:
    """One value for each pixel of a picture as OpenCV decodes it, None for a type of number that no camera writes."""
    if picture.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        return None
    if picture.ndim == 3:
        colours = picture[:, :, :3].astype(np.float32) if picture.dtype == np.float64 else picture[:, :, :3]
        return np.asarray(cv2.cvtColor(colours, cv2.COLOR_BGR2GRAY)) if picture.shape[2] >= 3 else picture[:, :, 0]
    return picture


def read_mask(file: Path, width: int, height: int) -> NDArray[np.bool_]:
    """Read which pixels of the first frame belong to marks: white ones do, black ones do not.

    Parameters
    ----------
    file : Path
        A picture as large as the film's.
    width, height : int
        Size of the film's pictures, px.

    Returns
    -------
    (height, width) array of bool

    Raises
    ------
    InputError
        No such file, no picture, another size.
    """
    picture = read_picture(existing_file(file, what="a mask (PNG, BMP, TIFF)"), (width, height), "the film")
    if picture is None:
        raise InputError(f"{file}: cannot be decoded; it is cut or damaged. Save it again.")
    return picture > (np.iinfo(picture.dtype).max // 2 if picture.dtype.kind == "u" else picture.max() / 2)


def whole_levels(first: NDArray) -> tuple[float, float]:
    """Gain and offset that turn the grey values of a film's pictures into whole levels.

    Cameras deliver whole numbers, and they stay as they are. Pictures that were calculated hold fractions, often from 0
    to 1: their range in the first frame is spread over the middle half of 16 bit, which leaves room for brighter frames.

    Parameters
    ----------
    first : (height, width) array
        The first picture.

    Returns
    -------
    (gain, offset) : (float, float)
        level = gain * value + offset.
    """
    if first.dtype.kind == "u":
        return 1.0, 0.0
    low, high = float(np.min(first)), float(np.max(first))
    whole = low >= 0.0 and 64.0 <= high <= 65535.0 and np.array_equal(first, np.rint(first))
    if whole or not high > low:
        return 1.0, 0.0
    gain = 32768.0 / (high - low)
    return gain, 16384.0 - gain * low


def in_whole_levels(picture: NDArray, levels: tuple[float, float]) -> Picture | None:
    """A picture in whole grey levels by `whole_levels`, None where it holds values that are not numbers."""
    if picture.dtype.kind == "u":
        return picture
    if not np.isfinite(picture).all():
        return None
    return np.clip(np.rint(levels[0] * picture + levels[1]), 0, 65535).astype(np.uint16)
