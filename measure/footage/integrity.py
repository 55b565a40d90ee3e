"""What can be wrong with frames although every one of them can be decoded: repeated and dark ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from measure.footage.footage import Picture

_EVERY = 8
_DARK_SHARE = 0.25


@dataclass
class IntegrityCheck:
    """Frames that are wrong.

    Attributes
    ----------
    repeated : list of int
        Frames that repeat the one before to the last grey level.
    dark : list of int
        Frames whose mean is below a quarter of the first one's.
    """

    repeated: list[int] = field(default_factory=list)
    dark: list[int] = field(default_factory=list)

    def watch(self, frames: Iterator[tuple[int, Picture]]) -> Iterator[tuple[int, Picture]]:
        """Hand the frames on and record what is wrong with them.

        Parameters
        ----------
        frames : iterator of (int, (height, width) array)

        Returns
        -------
        The same.
        """
        before, brightness = None, None
        for number, picture in frames:
            sample = picture[::_EVERY, ::_EVERY]
            mean = float(sample.mean())
            brightness = mean if brightness is None else brightness
            if mean < _DARK_SHARE * brightness:
                self.dark.append(number)
            if before is not None and np.array_equal(sample, before[::_EVERY, ::_EVERY]) and np.array_equal(picture, before):
                self.repeated.append(number)
            before = picture
            yield number, picture

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences for the summary."""
        found = (("repeat the one before", self.repeated), ("are dark", self.dark))
        return tuple(f"frames {what} ({len(frames)}): {_listed(frames)}" for what, frames in found if frames)


def _listed(frames: list[int]) -> str:
    return ", ".join(str(frame) for frame in frames[:8]) + (", ..." if len(frames) > 8 else "")
