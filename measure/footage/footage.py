"""A film as a stream of pictures, whatever file it comes from.

A variant lives in `measure/formats`: it knows the rate and depth that the camera wrote down, how many frames the file
promises, and hands them out one after the other, so that memory does not grow with the film.
"""

from __future__ import annotations

import stat
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError

LARGEST_PICTURE_PX = 64_000_000
"""No camera for this work has more; a file that claims more is broken or meant to be."""

Picture = NDArray[np.uint8 | np.uint16]


@dataclass(frozen=True)
class Footage(ABC):
    """A film: what is known of it before the first picture is read.

    width, height : px. bits : depth of a pixel. frames : how many the file promises, gaps in the numbering included.
    fps : capture rate by the camera's own word, None where nobody measured it; the nominal rate of a container is not
    it. exposure_s : likewise. remarks : sentences on what is wrong with the film as a whole.
    """

    name: str
    width: int
    height: int
    bits: int
    frames: int
    fps: float | None = None
    exposure_s: float | None = None
    remarks: tuple[str, ...] = ()

    @abstractmethod
    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Number of the frame, counted from 0, and its grey values (height, width), forward only.

        A number may be left out where a frame is missing; the stream ends early where the file is cut.
        """


@dataclass(frozen=True)
class ArrayFootage(Footage):
    """A film that is in memory already: (frames, height, width), 8 or 16 bit."""

    stack: Picture | None = None

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame."""
        assert self.stack is not None
        yield from enumerate(self.stack)


def from_array(stack: Picture, fps: float | None = None, name: str = "array") -> Footage:
    """A film from a NumPy array (frames, height, width) of 8 or 16 bit."""
    if stack.ndim != 3 or stack.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{name}: shape {stack.shape} of {stack.dtype}; a film is (frames, height, width) of uint8 or uint16.")
    frames, height, width = stack.shape
    return ArrayFootage(name, width, height, 8 * stack.dtype.itemsize, frames, fps, stack=stack)


def open_footage(path: Path) -> Footage:
    """Open a film file or a folder of numbered pictures; what it is shows in its first bytes, not in its name.

    Photron's `.mraw` alone has no first bytes of its own and goes by its name.

    Raises
    ------
    InputError
        Nothing is there, it is not a regular local file, or not a film.
    """
    from measure.footage import images, phantom, photron, video

    path = Path(path)
    if path.is_dir():
        return images.open_folder(path)
    head = _first_bytes(path)
    if path.suffix.lower() in photron.SUFFIXES:
        return photron.open_photron(path)
    if phantom.is_cine(head):
        return phantom.open_cine(path)
    if video.is_container(head):
        return video.open_video(path)
    if images.picture_kind(head):
        raise InputError(f"{path}: is a single picture; a film is a file of frames or a folder of numbered pictures. Name its folder.")
    raise InputError(
        f"{path}: is not a film; its first bytes are {head[:8]!r}. "
        "Known are avi, mp4, mov, mkv, Phantom cine, Photron mraw, and folders of numbered TIFF, PNG or BMP pictures."
    )


def _first_bytes(path: Path) -> bytes:
    from measure.common.command_line import existing_file

    if path.exists() and not stat.S_ISREG(path.stat().st_mode):
        raise InputError(f"{path}: is not a regular file. Copy the film to the disk and name the copy.")
    existing_file(path, what="a film")
    with open(path, "rb") as file:
        head = file.read(64)
    if not head:
        raise InputError(f"{path}: is empty. Copy the film again from the camera.")
    return head


def check_size(path: Path | str, width: int, height: int) -> None:
    """Refuse a picture that no camera made, before anything of it is decoded."""
    if width < 16 or height < 16 or width * height > LARGEST_PICTURE_PX:
        raise InputError(
            f"{path}: says it is {width} x {height} px; between 16 x 16 px and {LARGEST_PICTURE_PX // 1_000_000} megapixels are taken. "
            "Crop or scale the film."
        )
