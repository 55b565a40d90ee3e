"""Motion of an actuator that a shaker drives with a sine: a few harmonics say all of it.

Where a short Fourier series explains the elongation down to its noise, speed and acceleration follow from the series over
the whole record and are hundreds of times better than any difference of neighbouring samples. That is what lets an
inertia be separated from a slope.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from measure.common.arrays import Array

_MOST_HARMONICS = 5
_WORSE_THAN_NOISE = 1.4
_LEAST_CYCLES = 1.0
_NUDGE = 1e-6  # of the frequency
_DUTIES = np.linspace(0.1, 0.9, 17)  # shares of the period that a triangle rises for, which are tried


def harmonic_motion(time_s: Array, elongation_m: Array, noise_m: float) -> tuple[Array, Array] | None:
    """Motion of a record that is a sine with few harmonics, and in what ways it may be wrong; else None.

    u = c_0 + c_1 t + sum_k a_k cos k w t + b_k sin k w t, with w by Gauss-Newton from the spectrum's peak. It is accepted
    where what it leaves is about the noise, no harmonic more is worth its two coefficients (BIC), and no triangle says it as well in
    fewer parameters: in coarse steps the higher harmonics of a corner drown, and the series would round it off.

    Returns
    -------
    (3, n) elongation, speed and acceleration; (k, 3, n) independent errors of these, each of one standard deviation, for noise that
    is white: coefficients and frequency are known no better than the noise lets them.
    """
    w = _first_frequency(time_s, elongation_m)
    if w is None:
        return None
    richest = _fit(time_s, elongation_m, w, _MOST_HARMONICS)
    if np.sqrt(richest[2]) > _WORSE_THAN_NOISE * noise_m:
        return None
    fits = [*(_fit(time_s, elongation_m, w, harmonics) for harmonics in range(1, _MOST_HARMONICS)), richest]
    n = len(time_s)
    w, c, left = min(fits, key=lambda f: n * np.log(max(f[2], 1e-30)) + len(f[1]) * np.log(n))
    harmonics = (len(c) - 2) // 2
    if np.sqrt(left) > _WORSE_THAN_NOISE * noise_m or w * np.ptp(time_s) < 2 * np.pi * _LEAST_CYCLES:
        return None
    if harmonics > 1 and _is_triangle(time_s, elongation_m, w, c, left):
        return None
    moved = np.stack([c @ basis for basis in _bases(time_s, w, harmonics, 3)])
    return moved, _errors(time_s, w, c, max(noise_m, float(np.sqrt(left))))


def _is_triangle(time_s: Array, values: Array, w: float, c: Array, left: float) -> bool:
    """Whether straight strokes of this frequency and phase have the better BIC than the series of these coefficients c."""
    n, phase = len(values), np.arctan2(c[2], c[3])
    best = np.inf
    for duty in _DUTIES:
        turn = (w * (time_s - time_s[0]) + phase) / (2.0 * np.pi) + duty / 2.0  # odd about the middle of its rise, as its first harmonic is
        straight = np.interp(turn % 1.0, [0.0, duty, 1.0], [-1.0, 1.0, -1.0])
        basis = np.stack([np.ones(n), time_s - time_s[0], straight])
        best = min(best, float(np.mean((values - _least_squares(basis, values) @ basis) ** 2)))
    of_triangle, of_series = 6, len(c) + 1  # level, drift, height, share of the rise, frequency, phase
    return n * np.log(max(best, 1e-30)) + of_triangle * np.log(n) < n * np.log(max(left, 1e-30)) + of_series * np.log(n)


def _errors(time_s: Array, w: float, c: Array, noise_m: float) -> Array:
    """What one standard deviation of each independent combination of coefficients and frequency does to the motion, (k, 3, n)."""
    harmonics, small = (len(c) - 2) // 2, _NUDGE * w
    faster, slower = ([c @ basis for basis in _bases(time_s, w + nudge, harmonics, 3)] for nudge in (small, -small))
    nudged = [(more - less) / (2.0 * small) for more, less in zip(faster, slower, strict=True)]
    slopes = [np.vstack([basis, own]) for basis, own in zip(_bases(time_s, w, harmonics, 3), nudged, strict=True)]
    length = np.sqrt(np.einsum("ij,ij->i", slopes[0], slopes[0]))
    scaled = slopes[0] / length[:, None]
    power, ways = np.linalg.eigh(scaled @ scaled.T)
    root = noise_m * ways / (np.sqrt(np.maximum(power, 1e-12)) * length[:, None])
    return np.stack([root.T @ slope for slope in slopes], axis=1)


def _first_frequency(time_s: Array, values: Array) -> float | None:
    """Angular frequency of the largest peak, from evenly resampled values; None for a record without one."""
    n = len(time_s)
    if n < 16:
        return None
    even = np.linspace(time_s[0], time_s[-1], n)
    wave = np.interp(even, time_s, values)
    wave = (wave - np.polyval(np.polyfit(even - even[0], wave, 1), even - even[0])) * np.hanning(n)
    power = np.abs(np.fft.rfft(wave, 8 * n))
    peak = int(np.argmax(power[1:])) + 1
    return 2 * np.pi * peak / (8 * n * (even[1] - even[0]))


def _fit(time_s: Array, values: Array, w: float, harmonics: int) -> tuple[float, Array, float]:
    """Frequency, coefficients and mean square left, after Gauss-Newton steps in the frequency."""
    t = time_s - time_s[0]
    for _ in range(6):
        basis, rate = _bases(time_s, w, harmonics, 2)
        c = _least_squares(basis, values)
        slope = (c @ rate - c[1]) * t / w
        step = _least_squares(np.vstack([basis, slope]), values - c @ basis)[-1]
        w += float(np.clip(step, -0.1 * w, 0.1 * w))
        if abs(step) < 1e-8 * w:
            break
    (basis,) = _bases(time_s, w, harmonics, 1)
    c = _least_squares(basis, values)
    return w, c, float(np.mean((values - c @ basis) ** 2))


def _least_squares(basis: Array, values: Array) -> Array:
    """By the normal equations of rows of length one: the waves are nearly orthogonal, and it is ten times faster than an SVD."""
    length = np.sqrt(np.einsum("ij,ij->i", basis, basis)) + 1e-300
    normal = basis @ basis.T / np.outer(length, length)
    return np.linalg.lstsq(normal, basis @ values / length, rcond=1e-14)[0] / length


def _bases(time_s: Array, w: float, harmonics: int, orders: int) -> Sequence[Array]:
    """Rows 1, t, cos w t, sin w t, cos 2 w t ... and their derivatives in time, one array (2 harmonics + 2, n) for each order."""
    t = time_s - time_s[0]
    turned = np.exp(1j * w * t)
    lines = (np.ones_like(t), t), (np.zeros_like(t), np.ones_like(t)), (np.zeros_like(t), np.zeros_like(t))
    made = [np.empty((2 * harmonics + 2, len(t))) for _ in range(orders)]
    for basis, line in zip(made, lines, strict=False):
        basis[:2] = line
    wave = np.ones_like(turned)
    for k in range(1, harmonics + 1):
        wave = wave * turned
        for order, basis in enumerate(made):
            derivative = (1j * k * w) ** order * wave
            basis[2 * k], basis[2 * k + 1] = derivative.real, derivative.imag
    return made
