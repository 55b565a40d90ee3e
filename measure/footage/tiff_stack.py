"""A film as one TIFF with many pictures (a stack), read a few pictures at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.common.limits import limited
from measure.footage.footage import Footage, Picture, check_size
from measure.footage.picture_file import in_whole_levels, to_grey, whole_levels
from measure.footage.tiff_directory import page_sizes

_AT_ONCE_BYTES = 2**26
"""Pictures decoded in one call; each call walks through the file's directories again."""


@dataclass(frozen=True)
class TiffStack(Footage):
    """A TIFF with many pictures. `levels` : gain and offset of its grey values."""

    path: Path = Path()
    levels: tuple[float, float] = (1.0, 0.0)

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame; a picture that cannot be decoded ends the film."""
        some = max(1, _AT_ONCE_BYTES // (self.width * self.height * self.bits // 8))
        for start in range(0, self.frames, some):
            pages = _decoded(self.path, start, min(some, self.frames - start))
            for k, page in enumerate(pages):
                picture = in_whole_levels(page, self.levels)
                if picture is None or picture.shape != (self.height, self.width):
                    return
                yield start + k, picture
            if len(pages) < min(some, self.frames - start):
                return


def open_stack(path: Path) -> Footage:
    """Open a TIFF that holds a film.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    Footage

    Raises
    ------
    InputError
        A single picture, pictures of different sizes, a file that cannot be decoded.
    """
    sizes = page_sizes(memoryview(np.memmap(path, np.uint8, mode="r")))  # type: ignore[arg-type]
    if len(sizes) == 1:
        raise InputError(f"{path}: is a single picture; a film is a file of frames or a folder of numbered pictures. Name its folder.")
    for width, height in set(sizes):
        check_size(path, width, height)
    if len(set(sizes)) > 1:
        a, b = sorted(set(sizes))[:2]
        raise InputError(f"{path}: holds pictures of {a[0]} x {a[1]} px and of {b[0]} x {b[1]} px. Keep to one size.")
    first = _decoded(path, 0, 1) if sizes else []
    if not first:
        raise InputError(f"{path}: cannot be decoded; it is cut or damaged. Copy it again.")
    levels = whole_levels(first[0])
    picture = in_whole_levels(first[0], levels)
    if picture is None:
        raise InputError(f"{path}: its first picture holds values that are not numbers. Save it again without them.")
    return TiffStack(str(path), *sizes[0], 8 * picture.dtype.itemsize, len(sizes), path=path, levels=levels)


def _decoded(path: Path, start: int, count: int) -> list[NDArray]:
    with limited(path):
        decoded, pages = cv2.imreadmulti(str(path), start, count, flags=cv2.IMREAD_UNCHANGED)
    grey = [to_grey(page) for page in pages] if decoded else []
    return [page for page in grey if page is not None]
