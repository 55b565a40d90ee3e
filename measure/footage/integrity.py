"""What can be wrong with a film's frames although every one of them can be decoded: doubled and dark ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from measure.footage.footage import Picture

_EVERY = 8
_DARK_SHARE = 0.25


@dataclass
class Health:
    """Frames that repeat the one before to the last grey level, and frames much darker than the first."""

    doubled: list[int] = field(default_factory=list)
    dark: list[int] = field(default_factory=list)

    def watch(self, frames: Iterator[tuple[int, Picture]]) -> Iterator[tuple[int, Picture]]:
        """Hand the frames on and remember what is wrong with them."""
        before, brightness = None, None
        for number, picture in frames:
            sample = picture[::_EVERY, ::_EVERY]
            mean = float(sample.mean())
            brightness = mean if brightness is None else brightness
            if mean < _DARK_SHARE * brightness:
                self.dark.append(number)
            if before is not None and np.array_equal(sample, before[::_EVERY, ::_EVERY]) and np.array_equal(picture, before):
                self.doubled.append(number)
            before = picture
            yield number, picture

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences for the summary."""
        found = (("repeat the one before", self.doubled), ("are dark", self.dark))
        return tuple(f"{len(frames)} frames {what}: {_listed(frames)}" for what, frames in found if frames)


def _listed(frames: list[int]) -> str:
    return ", ".join(str(frame) for frame in frames[:8]) + (", ..." if len(frames) > 8 else "")
