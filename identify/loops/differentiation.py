"""How an actuator was moved: elongation, speed and acceleration out of noisy samples, reversals and full cycles.

Every sample gets a polynomial in time, fitted to its neighbours; its value and derivatives there are the elongation, the
speed and the acceleration. How many neighbours is decided sample by sample with cubics: as many as agree, within their
noise, with what fewer neighbours said. Then a quintic goes through them, because the cubic's acceleration of a sinusoid is
one per cent too small, which an inertia takes for its own. So a sinusoid is smoothed over a good part of its quarter
period, a ramp over most of its length, and neither is rounded off at a sharp reversal. The times are taken as they are,
jitter and gaps included. A record that a few harmonics explain down to the noise is taken from them instead
(`identify.loops.harmonics`).

Source of the choice of neighbours: intersection of confidence intervals (Goldenshluger and Nemirovski 1997).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from identify.loops.harmonics import harmonic_motion
from identify.loops.loop_data import Cycles
from measure.common.arrays import Array

_HALVES = (3, 5, 8, 13, 21, 34, 55, 89)  # neighbours on each side that are tried
_WIDE = 5  # neighbours on each side from which on a quintic is afforded
_AGREEMENT = 2.0  # standard deviations
_ENTRIES_AT_ONCE = 40_000  # what fits a processor's cache
_KEPT = 0.8  # of the absolute deviations, the smaller ones; a median would jump from step to step of a quantised signal
_KEPT_SIGMA = 0.66159  # root mean square of these for a normal distribution of one


@dataclass(frozen=True)
class Motion:
    """Smoothed motion, each (n,), one standard deviation of the raw elongation's noise, and that of the turning points.

    turns_m : of what all turning points are off by alike, beyond the errors.
    errors : (k, 3, n) in what independent ways elongation, speed and acceleration may be wrong over the whole record, each of one
    standard deviation; none are known but for harmonics.
    """

    elongation_m: Array
    speed_m_per_s: Array
    acceleration_m_per_s2: Array
    noise_m: float
    turns_m: float
    errors: Array


def motion(time_s: Array, elongation_m: Array) -> Motion:
    """Elongation, speed and acceleration from samples of the elongation; see the module for how."""
    noise = noise_of(time_s, elongation_m)
    sine = harmonic_motion(time_s, elongation_m, noise)
    if sine is not None:
        (u, v, a), errors = sine
        return Motion(u, v, a, noise, 0.0, errors)
    n = len(time_s)
    best, low, high, halves = np.empty((3, n)), np.full(n, -np.inf), np.full(n, np.inf), np.zeros(n, dtype=int)
    agreeing = np.arange(n)
    for half in _HALVES:
        if half > max(_HALVES[0], n // 8) or not len(agreeing):
            break
        fitted, gain = local_polynomial(time_s, elongation_m, half, agreeing)
        reach = _AGREEMENT * noise * gain
        low[agreeing] = np.maximum(low[agreeing], fitted[0] - reach)
        high[agreeing] = np.minimum(high[agreeing], fitted[0] + reach)
        agree = low[agreeing] <= high[agreeing]
        agreeing = agreeing[agree]
        best[:, agreeing] = fitted[:, agree]
        halves[agreeing] = half
    for half in [half for half in _HALVES if half >= _WIDE]:
        at = np.flatnonzero(halves == half)
        if len(at):
            best[:, at] = local_polynomial(time_s, elongation_m, half, at, degree=5)[0]
    return Motion(best[0], best[1], best[2], noise, noise, np.empty((0, 3, n)))


def local_polynomial(time_s: Array, values: Array, half: int, at: NDArray[np.intp], degree: int = 3) -> tuple[Array, Array]:
    """Value, first and second derivative at the samples `at` of a polynomial through 2 half + 1 neighbours.

    Returns
    -------
    (3, m) value and derivatives; (m,) standard deviation of the value for noise of one. Near the ends the neighbours lie
    on one side.
    """
    n = len(time_s)
    half = min(half, (n - 1) // 2)
    first = np.clip(at - half, 0, n - 2 * half - 1)
    times, near = sliding_window_view(time_s, 2 * half + 1), sliding_window_view(values, 2 * half + 1)
    rows = max(1, _ENTRIES_AT_ONCE // (2 * half + 1))
    chunks = zip(_chunks(first, rows), _chunks(at, rows), strict=True)
    parts = [_polynomials(times[k], near[k], time_s[i], degree) for k, i in chunks]
    return np.concatenate([fitted for fitted, _ in parts], axis=1), np.concatenate([gain for _, gain in parts])


def _chunks(indices: NDArray[np.intp], rows: int) -> list[NDArray[np.intp]]:
    return [indices[k : k + rows] for k in range(0, len(indices), rows)]


def _polynomials(times: Array, near: Array, centre: Array, degree: int) -> tuple[Array, Array]:
    """Least-squares polynomials, one a row, by their normal equations; times are scaled to the width of the row."""
    scale, level = times[:, -1] - times[:, 0], near[:, 0]
    x = (times - centre[:, None]) / scale[:, None]
    powers = [np.ones_like(x)]
    for _ in range(degree):
        powers.append(powers[-1] * x)
    moments = [np.einsum("ij,ij->i", powers[(k + 1) // 2], powers[k // 2]) for k in range(2 * degree + 1)]
    normal = np.stack([np.stack(moments[k : k + degree + 1], axis=1) for k in range(degree + 1)], axis=1)
    right = np.zeros((len(x), degree + 1, 2))
    right[:, :, 0] = np.stack([np.einsum("ij,ij->i", power, near - level[:, None]) for power in powers], axis=1)
    right[:, 0, 1] = 1.0
    solved = np.linalg.solve(normal, right)
    value, slope, bend = solved[:, 0, 0], solved[:, 1, 0], solved[:, 2, 0]
    return np.stack([value + level, slope / scale, 2.0 * bend / scale**2]), np.sqrt(solved[:, 0, 1])


def noise_of(time_s: Array, values: Array) -> float:
    """One standard deviation of the noise of a smooth signal, from what a cubic through seven neighbours leaves.

    The largest fifth of what is left does not count, so jumps and reversals do not. Never below what the signal's quantum makes,
    q / sqrt(12). Noise that is slower than a few samples is not seen.
    """
    fitted, gain = local_polynomial(time_s, values, _HALVES[0], np.arange(len(time_s)))
    left = (values - fitted[0]) / np.sqrt(np.maximum(1.0 - gain**2, 1e-3))
    smaller = np.sort(np.abs(left))[: max(1, int(_KEPT * len(left)))]
    return max(float(np.sqrt(np.mean(smaller**2))) / _KEPT_SIGMA, quantum_of(values) / np.sqrt(12.0))


def quantum_of(values: Array) -> float:
    """The smallest step of a signal that often repeats its last value, else zero.

    A signal that always moves on by more than its quantum shows the quantum as noise; only one that stands still between
    steps hides it.
    """
    steps = np.abs(np.diff(values))
    moved = steps[steps > 0.0]
    return float(moved.min()) if len(moved) and len(moved) < 0.9 * len(steps) else 0.0


def dead_band(motion_found: Motion, quantum_m: float) -> float:
    """How far the elongation must come back before it counts as a reversal: noise, quantum and a thousandth of the range.

    A growing protocol begins with strokes of a two-hundredth of its last one; gauges are linear to a thousandth.
    """
    return max(5.0 * motion_found.noise_m, 2.0 * quantum_m, 1e-3 * float(np.ptp(motion_found.elongation_m)))


def reversals(elongation_m: Array, band_m: float) -> tuple[int, ...]:
    """Indices at which the elongation turns and then comes back by more than `band_m`."""
    turns: list[int] = []
    high = low = 0
    direction = 0
    values = elongation_m.tolist()
    for i, u in enumerate(values):
        high = i if u > values[high] else high
        low = i if u < values[low] else low
        if direction >= 0 and values[high] - u > band_m:
            turns += [high] if direction else []
            direction, low = -1, i
        elif direction <= 0 and u - values[low] > band_m:
            turns += [low] if direction else []
            direction, high = 1, i
    return tuple(turns)


def one_way(elongation_m: Array, turns: tuple[int, ...]) -> Array:
    """The elongation without steps back between two reversals: a glitch of the gauge is no reversal, and the law would take it for one.

    Between two reversals the mean of the running extreme from either side is taken, which leaves a monotone stroke as it is.
    """
    straightened = np.array(elongation_m, dtype=float)
    for a, b in pairwise(turns):
        stroke = straightened[a : b + 1] * np.sign(straightened[b] - straightened[a])
        ahead, back = np.maximum.accumulate(stroke), np.minimum.accumulate(stroke[::-1])[::-1]
        straightened[a : b + 1] = (ahead + back) / 2.0 * np.sign(straightened[b] - straightened[a])
    return straightened


def cycles(time_s: Array, elongation_m: Array, band_m: float) -> Cycles:
    """Reversals, full cycles, frequency and amplitude; all from the signal."""
    turns = reversals(elongation_m, band_m)
    spans = tuple((turns[k], turns[k + 2] + 1) for k in range(0, len(turns) - 2, 2))
    if not spans:
        return Cycles(turns, (), float("nan"), float("nan"))
    at = [_vertex_time(time_s, elongation_m, k) for k in turns]
    periods = [at[k + 2] - at[k] for k in range(len(turns) - 2)]
    strokes = [abs(elongation_m[b] - elongation_m[a]) for a, b in pairwise(turns)]
    both = [(up + down) / 2.0 for up, down in pairwise(strokes)]
    return Cycles(turns, spans, float(1.0 / np.median(periods)), float(np.median(both) / 2.0))


def _vertex_time(time_s: Array, elongation_m: Array, k: int) -> float:
    """Time of the extreme of the parabola through a sample and its neighbours, within half a step of the sample."""
    if not 0 < k < len(time_s) - 1:
        return float(time_s[k])
    before, here, after = elongation_m[k - 1 : k + 2]
    bend = before - 2.0 * here + after
    shift = 0.5 * (before - after) / bend if bend else 0.0
    return float(time_s[k] + np.clip(shift, -0.5, 0.5) * (time_s[k + 1] - time_s[k - 1]) / 2.0)


def moving(elongation_m: Array, band_m: float) -> slice:
    """The samples between the first and the last motion: idle seconds before and after are left out."""
    start = np.flatnonzero(np.abs(elongation_m - elongation_m[0]) > band_m)
    end = np.flatnonzero(np.abs(elongation_m - elongation_m[-1]) > band_m)
    if not len(start) or not len(end):
        return slice(0, len(elongation_m))
    return slice(max(int(start[0]) - 1, 0), min(int(end[-1]) + 2, len(elongation_m)))
