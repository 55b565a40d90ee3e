"""What the time stamps of a film say: which frames were dropped, and when the others were taken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_WHOLE = 0.25
"""Distance from a whole number of usual steps up to which a longer step means dropped frames."""

_LARGEST_GAP = 10_000
"""A jump by more frames than this is a fault of the stamps."""


@dataclass(frozen=True)
class FrameClock:
    """Frames as their stamps number them.

    Attributes
    ----------
    stamps : (n,) array of int
        Stamps of the frames that the file holds, in order, in the file's own units of time.
    numbers : (n,) array of int
        The frame that each of them is, counted from 0; a number that is left out was dropped.
    instants : (numbers[-1] + 1,) array or None
        When all of them were taken, in units of the usual step; None where they are evenly spaced.
    """

    stamps: NDArray[np.int64]
    numbers: NDArray[np.int64]
    instants: NDArray[np.float64] | None = None

    @property
    def frames(self) -> int:
        """Frames that the film should have, dropped ones included."""
        return int(self.numbers[-1]) + 1 if len(self.numbers) else 0

    @property
    def dropped(self) -> int:
        """Frames that were dropped."""
        return self.frames - len(self.numbers)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is wrong, or unusual, in sentences."""
        remarks = []
        if self.dropped:
            at = np.flatnonzero(np.diff(self.numbers) > 1)
            shown = ", ".join(f"{self.numbers[i]} to {self.numbers[i + 1]}" for i in at[:3]) + (", ..." if len(at) > 3 else "")
            remarks.append(f"{self.dropped} frames were dropped by the time stamps (frame {shown})")
        if self.instants is not None:
            percent = 100 * np.diff(self.instants)
            remarks.append(
                f"the frame rate varies: {percent.min():.0f} to {percent.max():.0f} % of the usual step; the time stamps are used"
            )
        return tuple(remarks)

    def number(self, stamp: int | None, last: int) -> int:
        """Number of a frame by its stamp; the one after `last` where the stamp is not known or goes back."""
        if stamp is None or not len(self.stamps):
            return last + 1
        place = min(int(np.searchsorted(self.stamps, stamp)), len(self.stamps) - 1)
        return max(int(self.numbers[place]), last + 1)


def frame_clock(stamps: NDArray[np.int64]) -> FrameClock:
    """Number frames by their time stamps.

    The usual step is the median. Where all steps are whole multiples of it (to a quarter), a longer one means dropped
    frames. Stamps that stray from an even spacing by more than their rounding are a rate that varies, as in films of
    phones; they are kept. Steps that are no multiples at all are a rate that varies, too, and nothing was dropped.

    Parameters
    ----------
    stamps : (n,) array of int
        In increasing order, in any unit; empty where the file has none.

    Returns
    -------
    FrameClock
    """
    if len(stamps) < 3:
        return FrameClock(stamps, np.arange(len(stamps)))
    steps = np.diff(stamps)
    usual = float(np.median(steps))
    multiples = np.maximum(np.rint(steps / usual), 1).astype(np.int64)
    even = np.abs(steps / usual - multiples)
    if even.max() > _WHOLE or multiples.max() > _LARGEST_GAP:
        relative = (stamps - stamps[0]) / steps.mean()
        return FrameClock(stamps, np.arange(len(stamps)), relative)
    numbers = np.concatenate([[0], np.cumsum(multiples)])
    slope, offset = np.polyfit(numbers, stamps, 1)
    if np.abs(stamps - slope * numbers - offset).max() <= 1.0 + 1e-6 * abs(stamps[-1]):
        return FrameClock(stamps, numbers)
    relative = np.interp(np.arange(numbers[-1] + 1), numbers, (stamps - stamps[0]) / slope)
    return FrameClock(stamps, numbers, relative)
