"""Where the steps of a deployment have to be shorter: as a leg runs into a stop.

A stop sets in within its smoothing length, which a fast leg crosses in less than a step. Where a run is compared with a
measurement, a step there is divided until a part of it covers no more than 6 % of that length as the stop begins, which is a
kink, and 40 % while it sets in, which is smooth, and is no longer than the stiffness of the stop asks. Runs that are compared
to the last digit, as for derivatives, have to be divided alike, so the division is chosen in one run and followed by the others.

In a sweep each run goes in steps of its own: long ones in flight, one that ends where a stop begins, short ones until it has
set in. They depend on the run alone, so its neighbours change no digit.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.dispatch.lanes import Lanes, Rows, chosen, larger, smaller
from simulate.kernel.layout import FULL, LEG, LEG_SIZE, LEGS, LOWEST, OUT, OUT_V, STOP

MOST_PARTS = 64
_A_PART, _INSIDE = 0.06, 0.4  # of the smoothing length, in one part: as a stop begins, and while it sets in
_AROUND = 0.25  # of a step: so near to its ends the beginning of a stop counts as in it
_SET_IN = 3.0  # smoothing lengths behind which a stop is a plain spring and damper
_BEHIND = 0.02  # smoothing lengths: a step that is to end at a stop ends so far behind its beginning
_AT_REST = 1e-9  # m/s, so that a leg at rest is divided by

StepDivision = NDArray[np.int64]


UNDIVIDED: StepDivision = np.empty(0, dtype=np.int64)
"""No step divided; neither is any step behind the end of a division."""


@njit(cache=True, error_model="numpy")
def parts_of_step(w: Array, by_lane: Array, i: int, n: int, step: float, at_stops: float) -> int:
    """Into how many parts the step at hand of run i is divided, by where its legs stand and how fast they are.

    at_stops : the longest part while a leg is at a stop, s.
    """
    parts, smoothing, stiff = 1, by_lane[(STOP + 2) * n + i], min(MOST_PARTS, int(np.ceil(step / at_stops - 1e-9)))
    for leg in range(LEGS):
        at = LEG + leg * LEG_SIZE
        u, v = w[(OUT + leg) * n + i], w[(OUT_V + leg) * n + i]
        over, under = u - by_lane[(at + FULL) * n + i], by_lane[(at + LOWEST) * n + i] - u
        travel = abs(v) * step
        inside, begins = max(over, under), is_near(-over, v, travel) or is_near(under, v, travel)
        if begins or inside > 0.0:
            parts = max(parts, stiff)
        if begins:
            parts = max(parts, min(MOST_PARTS, int(travel / (_A_PART * smoothing)) + 1))
        elif 0.0 < inside < _SET_IN * smoothing:
            parts = max(parts, min(MOST_PARTS, int(travel / (_INSIDE * smoothing)) + 1))
    return parts


@njit(cache=True, error_model="numpy")
def is_near(way: float, v: float, travel: float) -> bool:
    """Whether a leg passes the beginning of a stop, `way` from it, in this step, or nearly so: a run that follows may pass it beside."""
    ahead = way if v > 0.0 else -way
    return -_AROUND * travel < ahead < (1.0 + _AROUND) * travel


@njit(cache=True, error_model="numpy", forceinline=True)
def own_step(w: Rows, by_lane: Rows, longest: float, at_stops: float, part: float) -> Lanes:
    """How far each run may go in its next step, s, by where its legs stand and how fast they are.

    longest, at_stops : limits in flight, and while a leg is at a stop. part : of the smoothing length, at most so much of it in a step.
    """
    smoothing, step = by_lane[STOP + 2], longest + 0.0 * by_lane[STOP + 2]
    for leg in range(LEGS):
        numbers = LEG + leg * LEG_SIZE
        over, under = w[OUT + leg] - by_lane[numbers + FULL], by_lane[numbers + LOWEST] - w[OUT + leg]
        inside, inwards = larger(over, under), chosen(over > under, w[OUT_V + leg], -w[OUT_V + leg])
        way = way_at_stop(inside, inwards, smoothing, part)
        step = smaller(way / (abs(inwards) + _AT_REST), step)
        step = chosen(inside > 0.0, smaller(step, at_stops), step)
    return step


@njit(cache=True, error_model="numpy", forceinline=True)
def step_near_rest(w: Rows, shortest: float, slow: float, per_braking: float) -> Lanes:
    """How far each run may go where dry friction is stiff near rest, s: until its slowest leg could have slowed down to `slow`.

    shortest : the step that the friction asks for. per_braking : over the largest deceleration, s^2/m.
    """
    slowest = abs(w[OUT_V])
    for leg in range(1, LEGS):
        slowest = smaller(abs(w[OUT_V + leg]), slowest)
    return larger((slowest - slow) * per_braking, shortest)


@njit(cache=True, error_model="numpy", forceinline=True)
def way_at_stop(inside: Lanes, inwards: Lanes, smoothing: Lanes, part: float) -> Lanes:
    """How far a leg may move in a step that stands so far inside a stop and moves inwards so fast, m."""
    setting_in, behind = _SET_IN * smoothing, _BEHIND * smoothing
    short, free = part * smoothing, 1e9
    ahead = chosen(inside < 0.0, behind - inside, chosen(inside < setting_in, short, free))
    back = chosen(inside < 0.0, free, chosen(inside < setting_in, smaller(inside + behind, short), larger(inside - setting_in, short)))
    return chosen(inwards > 0.0, ahead, back)
