"""Where the steps of a deployment have to be shorter: as a leg runs into a stop.

A stop sets in within its smoothing length, which a fast leg crosses in less than a step. There a step is divided until a part
of it covers no more than 3 % of that length. Runs that are compared to the last digit, as for derivatives, have to be
divided alike, so the division is chosen in one run and followed by the others.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.kernel.layout import FULL, LEG, LEG_SIZE, LEGS, LOWEST, OUT, OUT_V, STOP

MOST_PARTS = 64
_A_PART = 0.03  # of the smoothing length
_SET_IN = 3.0  # smoothing lengths behind which a stop is a plain spring and damper

StepDivision = NDArray[np.int64]


UNDIVIDED: StepDivision = np.empty(0, dtype=np.int64)
"""No step divided; neither is any step behind the end of a division."""


@njit(cache=True, error_model="numpy")
def parts_of_step(w: Array, by_lane: Array, i: int, n: int, step: float) -> int:
    """Into how many parts the step at hand of run i is divided, by where its legs stand and how fast they are."""
    parts, smoothing = 1, by_lane[(STOP + 2) * n + i]
    for leg in range(LEGS):
        at = LEG + leg * LEG_SIZE
        u, v = w[(OUT + leg) * n + i], w[(OUT_V + leg) * n + i]
        over, under = u - by_lane[(at + FULL) * n + i], by_lane[(at + LOWEST) * n + i] - u
        travel = abs(v) * step
        if min(abs(over), abs(under)) < travel or 0.0 < max(over, under) < _SET_IN * smoothing:
            parts = max(parts, min(MOST_PARTS, int(travel / (_A_PART * smoothing)) + 1))
    return parts
