"""Samples that pile up: at the end of a channel's range, or on the steps of its converter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import special

from identify.criteria import BY_CHANCE, NO_NOISE
from identify.loops.differentiation import local_polynomial, noise_of, quantum_of
from measure.common.arrays import Array

_SMOOTHED = 8  # neighbours on each side
_TRUNCATED = 3.0  # standard deviations below a limit from which on it cuts the noise
_CREST = 10.0  # steps; a crest that stays within one step for a while falls by three within half that time, a cut one by far more
_TELLS = 3  # samples in a stay; two also lie alike to both sides of a turning point, however sharp it is and however small the steps
_THIRD = 2  # samples in a third of a stay, at least
_STAYS = 0.05  # of a loop's height; a limit hides a reversal, behind which the force changes by more even where the law is soft
_SAME = 1e-9  # of a range; values nearer to each other are one, but for the last digits of a double
_MOST_MOVES = 0.9  # share of samples that differ from the one before, from which on no steps are seen
_ON_STEPS, _NEARLY = 0.05, 0.99  # of a step, and share of the samples that are so near to one


def at_limits(time_s: Array, values: Array) -> NDArray[np.bool_]:
    """Samples that a saturated channel cuts off, (n,): those at an extreme at which the signal stays, and those that the limit truncates.

    Elsewhere a noisy signal hardly ever repeats a value. At a limit it does. The number of repeats at the extreme is compared with
    the rate of repeats elsewhere (binomial). A record without noise is not judged: a flat branch looks the same there.
    """
    cut = np.zeros(len(values), dtype=bool)
    for sign in (1.0, -1.0):
        cut |= _at_upper_limit(time_s, sign * values)
    return cut


def _at_upper_limit(time_s: Array, values: Array) -> NDArray[np.bool_]:
    none, at = np.zeros(len(values), dtype=bool), values == values.max()
    stays = np.diff(values) == 0.0
    of, elsewhere = at[:-1], ~at[:-1] & ~at[1:]
    if np.count_nonzero(stays & of) < 2 or not np.any(elsewhere):
        return none
    rate = (np.count_nonzero(stays & elsewhere) + 1.0) / (np.count_nonzero(elsewhere) + 2.0)
    if rate > 1.0 - _MOST_MOVES or _fall(values, at) < _CREST * _finest(values):
        return none
    if special.bdtrc(np.count_nonzero(stays & of) - 1, np.count_nonzero(of), rate) > BY_CHANCE:
        return none
    free = np.flatnonzero(~at)
    noise = noise_of(time_s[free], values[free]) if len(free) > 2 * _SMOOTHED else 0.0
    if noise < NO_NOISE * np.ptp(values):
        return none
    smooth = local_polynomial(time_s, values, _SMOOTHED, np.arange(len(values)))[0][0]
    return at | (smooth > values.max() - _TRUNCATED * noise)


def _finest(values: Array) -> float:
    """The smallest distance of two values: the step of a converter, also where the signal moves on by many steps a sample."""
    apart = np.diff(np.unique(values))
    return float(np.min(apart[apart > _SAME * np.ptp(values)]))


def _fall(values: Array, at: NDArray[np.bool_]) -> float:
    """How far the signal falls beside its stays at the maximum, within half their length; median over the stays that tell, zero for one."""
    falls = []
    for first, last in _stays(at):
        half = (last - first) // 2
        if last - first >= _TELLS and first > 0 and last < len(values):  # a record that begins or ends at rest is not cut off
            beside = np.concatenate([values[max(first - half, 0) : first], values[last : last + half]])
            falls.append(values.max() - float(beside.mean()))
    return float(np.median(falls)) if len(falls) > 1 else 0.0


def _stays(at: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Stretches (first, last + 1) of samples that are true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(int)))
    return [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]


def at_rest(elongation_m: Array, force_N: Array) -> bool:
    """Whether the force stays while the elongation stays at its extremes: the drive dwells there, and no limit hides a motion.

    Behind a limit the law goes on to the reversal and back, by a good part of the loop's height. What the force changes by from the first
    third of a stay to the last one, up at the upper end and down at the lower, is held with its error against that height,
    twice the integral of F du over the whole way. Where the force is too noisy to tell, no rest is taken for granted.
    """
    changes = []
    for sign in (1.0, -1.0):
        for first, last in _stays(sign * elongation_m == np.max(sign * elongation_m)):
            third = (last - first) // 3
            if third >= _THIRD:
                changes.append(sign * (force_N[last - third : last].mean() - force_N[first : first + third].mean()))
    if len(changes) < _TELLS:
        return False
    moved = np.diff(elongation_m)
    height = 2.0 * abs(float(np.sum((force_N[1:] - force_N.mean()) * moved))) / float(np.sum(np.abs(moved)))
    error = float(np.std(changes, ddof=1)) / np.sqrt(len(changes))
    return abs(float(np.mean(changes))) + _TRUNCATED * error < _STAYS * height


def steps_of(values: Array) -> float:
    """The step of a channel that its noise does not cover, in its unit; zero where there is none.

    The signal repeats its last value often, and what it shows is a multiple of the step.
    """
    step = quantum_of(values)
    if step == 0.0:
        return 0.0
    places = (values - values[0]) / step
    return step if np.mean(np.abs(places - np.round(places)) < _ON_STEPS) > _NEARLY and np.ptp(places) > 1.0 else 0.0
