"""What a fit of loops leaves: how much of it comes again in every cycle, in parts of each loop's own height.

Noise is another one in every cycle, hum and drift too; a law of the wrong shape is wrong in every cycle alike. So the mean product of the
residuals of two cycles at the same place is the square of the misfit, and noise has none on the average, however coloured it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.criteria import SAME_STROKE
from identify.loops.loop_data import LoopData, area
from measure.common.arrays import Array

_PLACES = 96  # of a cycle
_FEWEST = 12
_COARSE = 16  # places of a cycle where there is but one

_ROUNDING = 1e-6  # of a place: samples that lie on the edge of two fall into the same one whatever the last digits of the clock


@dataclass(frozen=True)
class Misfit:
    """What is left of each loop, (loops,).

    heights_N : of the measured loops, area over stroke. rms_N : root mean square of the residual. repeated_N : of the part that comes
    again in every cycle. significance : of the repeated part, in its standard deviations for noise; NaN where no cycle comes again.
    """

    heights_N: Array
    rms_N: Array
    repeated_N: Array
    significance: float

    @property
    def relative(self) -> Array:
        """The repeated part of each loop over half of its height."""
        return self.repeated_N / np.maximum(self.heights_N / 2.0, 1e-300)

    @property
    def pooled(self) -> float:
        """Root mean square of `relative` over the loops."""
        return float(np.sqrt(np.mean(self.relative**2)))


def misfit_of(loops: Sequence[LoopData], residuals: Sequence[Array]) -> Misfit:
    """The misfit of loops by the residuals, N, of their samples that count."""
    rows = [_repeated(data, residual) for data, residual in zip(loops, residuals, strict=True)]
    squares, variances, powers = (np.array(column) for column in zip(*rows, strict=True))
    squares = squares - np.array([data.force_step_N**2 / 12.0 for data in loops])  # rounding comes again in every cycle, and is no misfit
    known = np.isfinite(variances) & (powers > 0.0)
    weights = 1.0 / np.maximum(powers[known], 1e-300)
    spread = float(np.sqrt(np.sum(weights**2 * variances[known])))
    significance = float(np.sum(weights * squares[known]) / spread) if spread > 0.0 else float("nan")
    return Misfit(
        heights_N=np.array([height_of(data) for data in loops]),
        rms_N=np.array([float(np.sqrt(np.mean(residual**2))) for residual in residuals]),
        repeated_N=np.sqrt(np.maximum(squares, 0.0)),
        significance=significance,
    )


def height_of(data: LoopData) -> float:
    """Height of a measured loop, area over stroke, N; the force range where no cycle is whole."""
    strokes = [float(np.ptp(data.elongation_m[a:b])) for a, b in data.cycles.spans]
    return abs(area(data, data.force_N)) / float(np.mean(strokes)) if strokes else data.force_range_N


def not_repeated(data: LoopData, residual: Array) -> Array:
    """A residual (n,) less the mean of the other cycles of the same stroke at the same place in the cycle.

    NaN outside of such cycles; the residual itself where no stroke is repeated. Of another cycle the nearest sample counts, as it is, so
    that noise keeps its memory.
    """
    whole, out = _whole(data, residual), np.full(len(data.force_N), np.nan)
    for spans in (spans for spans in _alike(data) if len(spans) > 1):
        for own in spans:
            others = [whole[_nearest(data.time_s, own, other)] for other in spans if other != own]
            out[slice(*own)] = whole[slice(*own)] - np.mean(others, axis=0)
    return out[data.used] if np.any(np.isfinite(out)) else residual


def _nearest(time_s: Array, own: tuple[int, int], other: tuple[int, int]) -> NDArray[np.intp]:
    """For each sample of a cycle, the sample of another one that is nearest by its place in the cycle."""
    shares = [(time - time[0]) / max(time[-1] - time[0], 1e-300) for time in (time_s[slice(*own)], time_s[slice(*other)])]
    return np.round(np.interp(shares[0], shares[1], np.arange(*other))).astype(np.intp)


def _whole(data: LoopData, residual: Array) -> Array:
    """A residual of the samples that count, at its places in the whole record; NaN elsewhere."""
    whole = np.full(len(data.force_N), np.nan)
    whole[data.used] = residual
    return whole


def _repeated(data: LoopData, residual: Array) -> tuple[float, float, float]:
    """Mean square of the repeated part, its variance for noise, and mean square of the whole; N^2, N^4, N^2."""
    whole = _whole(data, residual)
    groups = [_by_place(data, whole, spans) for spans in _alike(data)]
    groups = [table for table in groups if len(table) > 1 and table.shape[1] >= _FEWEST]
    if not groups:
        return _slow(data, residual), float("nan"), float(np.mean(residual**2))
    parts = [_products(table) for table in groups]
    pairs = np.array([len(table) * (len(table) - 1) for table in groups], dtype=float)
    share = pairs / pairs.sum()
    square = float(share @ [part[0] for part in parts])
    return square, float(share**2 @ [part[1] for part in parts]), float(np.mean([np.mean(table**2) for table in groups]))


def _alike(data: LoopData) -> list[list[tuple[int, int]]]:
    """The full cycles in groups of one stroke."""
    groups: list[tuple[float, list[tuple[int, int]]]] = []
    for a, b in data.cycles.spans:
        stroke = float(np.ptp(data.elongation_m[a:b]))
        near = [spans for usual, spans in groups if abs(stroke - usual) < SAME_STROKE * usual]
        if near:
            near[0].append((a, b))
        else:
            groups.append((stroke, [(a, b)]))
    return [spans for _, spans in groups]


def _by_place(data: LoopData, whole: Array, spans: Sequence[tuple[int, int]]) -> Array:
    """Mean residual of each cycle by its place in the cycle, (cycles, places), each row about its mean; places that all have."""
    places = int(min(_PLACES, *(b - a for a, b in spans)))
    table = np.full((len(spans), places), np.nan)
    for row, (a, b) in enumerate(spans):
        time, values = data.time_s[a:b], whole[a:b]
        known = np.isfinite(values)
        share = (time - time[0]) / max(time[-1] - time[0], 1e-300)
        at = np.minimum((places * share + _ROUNDING).astype(int), places - 1)[known]
        count = np.bincount(at, minlength=places)
        total = np.bincount(at, values[known], minlength=places)
        table[row, count > 0] = total[count > 0] / count[count > 0]
    kept = table[:, np.all(np.isfinite(table), axis=0)]
    return kept - kept.mean(axis=1, keepdims=True) if kept.size else kept


def _products(table: Array) -> tuple[float, float]:
    """Mean product of two different cycles, and its variance for noise of the same autocorrelation."""
    cycles, places = table.shape
    pairs = cycles * (cycles - 1)
    square = float((np.sum(table.sum(axis=0) ** 2) - np.sum(table**2)) / (pairs * places))
    power = float(np.mean(table**2))
    waves = np.abs(np.fft.rfft(table, 2 * places, axis=1)) ** 2
    lags = np.fft.irfft(waves.mean(axis=0))[:places] / places
    memory = _memory(lags / max(lags[0], 1e-300))
    return square, 2.0 * power**2 * memory / (pairs * places)


def _memory(correlation: Array) -> float:
    """1 + 2 sum of squares of the autocorrelations up to the first that is not positive."""
    ends = np.flatnonzero(correlation <= 0.0)
    return float(1.0 + 2.0 * np.sum(correlation[1 : ends[0] if len(ends) else len(correlation)] ** 2))


def _slow(data: LoopData, residual: Array) -> float:
    """Where no cycle comes again: mean square of what changes over a sixteenth of a cycle, less what noise of the samples makes of it."""
    turns = max(len(data.cycles.reversals), 2)
    width = max(len(residual) // (_COARSE * turns // 2), 1)
    count = len(residual) // width
    means = residual[: count * width].reshape(count, width).mean(axis=1)
    return float(np.mean(means**2) - data.force_sigma_N**2 / width)
