"""What comes into a force from outside: the hum of the mains, and spikes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.criteria import HUM_ABOVE_LINES, HUM_ABOVE_NOISE, MAINS_HZ, SPIKE
from measure.common.arrays import Array

_OFF_MAINS = 0.5  # Hz, by which a grid's frequency is off at most
_ASIDE = 0.2  # of the mains frequency, on either side, where the background is looked at
_PADDED = 4
_LEAST_PERIODS, _HIGHEST = 20.0, 0.45  # of the record; of the sampling rate
_MOST_HARMONICS = 5
_NYQUIST = 2.2  # samples a period
_TAIL, _ABOVE_TAIL = 0.95, 5.0  # quantile of all jumps, and how many times above it a spike is
_MATTERS = 1e-3  # of the range


@dataclass(frozen=True)
class Hum:
    """A line of the mains in a force: frequency, amplitude of its first harmonic, N, and the whole of it, (n,) N."""

    frequency_Hz: float
    amplitude_N: float
    force_N: Array


def hum_of(time_s: Array, force_N: Array) -> Hum | None:
    """The hum at 50 or 60 Hz and its harmonics, or None.

    The line has to stand out of the noise beside it, and of every line of the loop's own harmonics beside it.
    """
    rate = (len(time_s) - 1) / float(np.ptp(time_s))
    for mains in MAINS_HZ:
        if mains * _NYQUIST > rate or mains * np.ptp(time_s) < _LEAST_PERIODS:
            continue
        found = _line(time_s, force_N, rate, mains)
        if found is not None:
            harmonics = [k for k in range(1, _MOST_HARMONICS + 1) if k * found < _HIGHEST * rate]
            columns, weights = _waves(time_s, found, harmonics), np.hanning(len(time_s) + 2)[1:-1]
            centred = force_N - np.polyval(np.polyfit(time_s, force_N, 1), time_s)
            share = np.linalg.lstsq(columns * weights[:, None], centred * weights, rcond=None)[0]
            return Hum(found, float(np.hypot(share[0], share[1])), columns @ share)
    return None


def _waves(time_s: Array, frequency: float, harmonics: list[int]) -> Array:
    turns = 2.0 * np.pi * frequency * (time_s - time_s[0])
    return np.stack([wave(k * turns) for k in harmonics for wave in (np.cos, np.sin)], axis=1)


def _line(time_s: Array, force_N: Array, rate: float, mains: float) -> float | None:
    """The frequency of a line near that of the mains, if there is one."""
    n = len(time_s)
    even = np.linspace(time_s[0], time_s[-1], n)
    wave = np.interp(even, time_s, force_N)
    wave = (wave - np.polyval(np.polyfit(even, wave, 1), even)) * np.hanning(n)
    power, f = np.abs(np.fft.rfft(wave, _PADDED * n)) ** 2, np.fft.rfftfreq(_PADDED * n, 1.0 / rate)
    near, width = np.abs(f - mains) < _OFF_MAINS, 4.0 * rate / n
    peak = int(np.argmax(np.where(near, power, 0.0)))
    beside = (np.abs(f - mains) < _ASIDE * mains) & (np.abs(f - f[peak]) > width)
    if np.count_nonzero(beside) < 4 * _PADDED:
        return None
    background, lines = float(np.median(power[beside])), float(power[beside].max())
    stands_out = power[peak] > HUM_ABOVE_NOISE * background and power[peak] > HUM_ABOVE_LINES * lines
    return _vertex(f, power, peak) if stands_out else None


def _vertex(f: Array, power: Array, k: int) -> float:
    """Frequency of the vertex of the parabola through a peak's logarithm and its neighbours."""
    before, here, after = np.log(power[k - 1 : k + 2] + 1e-300)
    bend = before - 2.0 * here + after
    return float(f[k] + (0.5 * (before - after) / bend if bend else 0.0) * (f[1] - f[0]))


def spikes_of(force_N: Array, noise_N: float) -> NDArray[np.bool_]:
    """Single samples, (n,), that jump away from both neighbours and back by far more than the noise, and than nearly all others do.

    Real noise has longer tails than a normal distribution; what belongs to the tail is no spike.
    """
    height = jumps(force_N)
    usual = max(SPIKE * noise_N, _ABOVE_TAIL * float(np.quantile(height[1:-1], _TAIL)), _MATTERS * float(np.ptp(force_N)))
    return height > usual


def jumps(values: Array) -> Array:
    """By how much each sample, (n,), stands off both neighbours; nought where it lies between them, or they far from one another."""
    height = np.zeros(len(values))
    up, back = values[1:-1] - values[:-2], values[1:-1] - values[2:]
    across = np.abs(values[2:] - values[:-2])
    lone = np.where(up * back > 0.0, np.minimum(np.abs(up), np.abs(back)), 0.0)
    height[1:-1] = np.where(lone > 2.0 * across, lone, 0.0)
    return height
