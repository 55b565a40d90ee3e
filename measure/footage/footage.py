"""A film as a stream of grey pictures, whatever file it comes from.

A variant knows the capture rate and pixel depth that the camera wrote down, how many frames the file promises, and
hands the pictures out one after the other, so that memory does not grow with the length of the film. The variants stand
in their own modules; `measure.footage.formats` chooses among them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError

LARGEST_PICTURE_PX = 64_000_000
"""No camera used for this work has more pixels; a file that claims more is damaged or hostile."""

SMALLEST_SIDE_PX = 16

Picture = NDArray[np.uint8 | np.uint16]
"""Grey values, (height, width)."""


@dataclass(frozen=True)
class Footage(ABC):
    """A film: what is known of it before the first picture is read.

    Attributes
    ----------
    name : str
        File or folder, for messages.
    width, height : int
        Size of a picture, px.
    bits : int
        Depth of a pixel.
    frames : int
        Frames that the film should have; frames that the file says are missing are counted.
    fps : float or None
        Capture rate reported by the camera, frames per second. The rate at which a container is to be played is not it.
    exposure_s : float or None
        Exposure time reported by the camera, s.
    remarks : tuple of str
        What is wrong with the film as a whole, in sentences.
    instants : (frames,) array or None
        When the frames were taken, in units of the usual time from frame to frame, the first at zero. None: evenly
        spaced, 0, 1, 2 ... Divided by the capture rate they are seconds.
    first : int
        Number in the whole film of the frame that is counted as 0 here.
    per_frame : int
        Pictures a frame of the camera: 2 where a film is split into its fields.
    """

    name: str
    width: int
    height: int
    bits: int
    frames: int
    fps: float | None = None
    exposure_s: float | None = None
    remarks: tuple[str, ...] = ()
    instants: NDArray[np.float64] | None = None
    first: int = 0
    per_frame: int = 1

    @abstractmethod
    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Read the film from its first frame on.

        Returns
        -------
        Iterator of (int, (height, width) array)
            Number of the frame, counted from 0, and its grey values. A number is left out where a frame is missing; the
            stream ends early where the file is cut.
        """

    def times_s(self, count: int, fps: float) -> NDArray[np.float64]:
        """Instants of the first `count` frames, s, from the first frame.

        Parameters
        ----------
        count : int
            Number of frames, missing ones included.
        fps : float
            Capture rate, frames per second.

        Returns
        -------
        (count,) array
            Evenly spaced, or with the pattern of the file's own time stamps.
        """
        if self.instants is None or len(self.instants) < count:
            return np.arange(count) / fps
        return self.instants[:count] / fps


@dataclass(frozen=True)
class ArrayFootage(Footage):
    """A film in memory; `stack` is (frames, height, width) of 8 or 16 bit."""

    stack: Picture | None = None

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame."""
        assert self.stack is not None
        yield from enumerate(self.stack)


def from_array(stack: Picture, fps: float | None = None, name: str = "array") -> Footage:
    """Make a film of a NumPy array.

    Parameters
    ----------
    stack : (frames, height, width) array of uint8 or uint16
        Grey values.
    fps : float, optional
        Capture rate, frames per second.
    name : str
        Used in messages.

    Returns
    -------
    Footage

    Raises
    ------
    InputError
        Another shape or type of number.
    """
    if stack.ndim != 3 or stack.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{name}: shape {stack.shape} of {stack.dtype}; a film is (frames, height, width) of uint8 or uint16.")
    frames, height, width = stack.shape
    return ArrayFootage(name, width, height, 8 * stack.dtype.itemsize, frames, fps, stack=stack)


def check_size(path: Path | str, width: int, height: int) -> None:
    """Refuse a picture of a size that no camera makes, before anything of it is decoded.

    Parameters
    ----------
    path : Path or str
        Used in the message.
    width, height : int
        Size that the header states, px.

    Raises
    ------
    InputError
        Smaller than 16 x 16 px, or more than 64 megapixels.
    """
    if min(width, height) < SMALLEST_SIDE_PX or width * height > LARGEST_PICTURE_PX:
        raise InputError(
            f"{path}: states a size of {width} x {height} px; accepted are {SMALLEST_SIDE_PX} x {SMALLEST_SIDE_PX} px to "
            f"{LARGEST_PICTURE_PX // 1_000_000} megapixels. Crop or scale the film."
        )
