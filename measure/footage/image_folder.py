"""A film as a folder of numbered pictures, in full depth, in the order of their numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from measure.common.errors import InputError
from measure.footage.footage import Footage, Picture
from measure.footage.picture_file import SUFFIXES, in_whole_levels, read_picture, whole_levels


@dataclass(frozen=True)
class ImageFolder(Footage):
    """A folder of pictures.

    Attributes
    ----------
    files, numbers : tuples of equal length
        The pictures, and the frame that each of them is; a number that is left out is a missing frame.
    levels : (float, float)
        Gain and offset of the grey values.
    """

    files: tuple[Path, ...] = ()
    numbers: tuple[int, ...] = ()
    levels: tuple[float, float] = (1.0, 0.0)

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame; a picture that cannot be decoded ends the film."""
        for number, file in zip(self.numbers, self.files, strict=True):
            decoded = read_picture(file, (self.width, self.height))
            picture = None if decoded is None else in_whole_levels(decoded, self.levels)
            if picture is None:
                return
            yield number, picture


def open_folder(folder: Path) -> Footage:
    """Open a folder of pictures named by numbers, such as `frame_0001.tif` or `run3_0001_250fps.png`.

    Where a name holds several numbers, the one that differs from file to file is the number of the frame.

    Parameters
    ----------
    folder : Path
        It may hold other files too; only TIFF, PNG, BMP and JPEG are looked at.

    Returns
    -------
    Footage

    Raises
    ------
    InputError
        Fewer than two pictures, no numbers, numbers used twice, pictures of different sizes.
    """
    found = [file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES and file.is_file() and not file.name.startswith(".")]
    if len(found) < 2:
        raise InputError(
            f"{folder}: holds {len(found)} pictures ({', '.join(SUFFIXES)}); a film needs two at least. Name the folder that holds them."
        )
    numbered = sorted(zip(_frame_numbers(found), found, strict=True))
    numbers, files = [n for n, _ in numbered], [f for _, f in numbered]
    step = min(b - a for a, b in pairwise(numbers))
    if step == 0:
        twice = next(i for i, (a, b) in enumerate(pairwise(numbers)) if a == b)
        raise InputError(f"{folder}: {files[twice].name} and {files[twice + 1].name} have the same number. Keep one film in a folder.")
    places = [(n - numbers[0]) // step for n in numbers]
    return _opened(folder, files, places, _gaps(numbers, step))


def _opened(folder: Path, files: list[Path], places: list[int], remarks: tuple[str, ...]) -> Footage:
    first = read_picture(files[0])
    if first is None:
        raise InputError(f"{files[0]}: cannot be decoded; it is cut or damaged. Copy it again.")
    levels = whole_levels(first)
    picture = in_whole_levels(first, levels)
    if picture is None:
        raise InputError(f"{files[0]}: holds values that are not numbers. Save it again without them.")
    height, width = picture.shape
    return ImageFolder(
        str(folder), width, height, 8 * picture.dtype.itemsize, places[-1] + 1,
        remarks=remarks, files=tuple(files), numbers=tuple(places), levels=levels,
    )  # fmt: skip


def _gaps(numbers: list[int], step: int) -> tuple[str, ...]:
    gaps = [(a, b) for a, b in pairwise(numbers) if b - a != step]
    if not gaps:
        return ()
    shown = ", ".join(f"{a} to {b}" for a, b in gaps[:3]) + (", ..." if len(gaps) > 3 else "")
    return (f"the numbering jumps ({shown}); frames are missing there",)


def _frame_numbers(files: list[Path]) -> list[int]:
    """The number of each file. Of several in a name, the one that differs in all files and spans least; or else the last."""
    rows = [[int(digits) for digits in re.findall(r"\d+", file.stem)] for file in files]
    for file, row in zip(files, rows, strict=True):
        if not row:
            raise InputError(
                f"{file}: has no number in its name; the order of the film is not known. Number the pictures, or remove this one."
            )
    last = [row[-1] for row in rows]
    if len({len(row) for row in rows}) > 1:
        return last
    distinct = [list(column) for column in zip(*rows, strict=True) if len(set(column)) == len(rows)]
    return min(distinct, key=lambda column: max(column) - min(column), default=last)
