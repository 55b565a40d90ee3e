"""Rates and strokes of a set of loops: which are alike, and which polynomials of the rate they can carry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identify.criteria import SAME_RATE, SAME_STROKE
from identify.estimation.rate import NO_RATE, Abscissa, RatePolynomials, rate_of
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array
from measure.common.errors import InputError


def rates_of(loops: Sequence[LoopData], abscissa: Abscissa) -> Array:
    """Frequency, or speed in the middle of the stroke, of each loop."""
    return np.array([rate_of(data, abscissa) for data in loops])


def polynomials_for(loops: Sequence[LoopData], abscissa: Abscissa, order: int) -> RatePolynomials:
    """Polynomials of the rate over the rates of these loops.

    Raises
    ------
    InputError
        A loop without a frequency; fewer frequencies than a polynomial of this order needs.
    """
    if abscissa == "none":
        return NO_RATE
    require_rates(loops, abscissa, order)
    x, f = rates_of(loops, abscissa), rates_of(loops, "frequency_Hz")
    per_Hz = float(f @ x / (f @ f))
    if abscissa == "speed_m_per_s" and np.max(np.abs(x / (per_Hz * f) - 1.0)) < SAME_RATE:
        middle, half = _middle_and_half(f)
        return OfOneStroke(abscissa, order, per_Hz * middle, per_Hz * half, middle, half)
    return RatePolynomials(abscissa, order, *_middle_and_half(x))


def _middle_and_half(x: Array) -> tuple[float, float]:
    return float((x.min() + x.max()) / 2.0), float(np.ptp(x) / 2.0) or 1.0


@dataclass(frozen=True)
class OfOneStroke(RatePolynomials):
    """Polynomials of the speed for loops of one stroke: the speed of each is its frequency times 2 pi A, with one amplitude for all.

    So a fit over the speed is the one over the frequency, and says the same of a deployment. middle_Hz, half_Hz : of the frequencies.
    """

    middle_Hz: float = 0.0
    half_Hz: float = 1.0

    def z_of(self, data: LoopData) -> float:
        """The scaled speed of a loop."""
        return (data.frequency_Hz - self.middle_Hz) / self.half_Hz


def covered(loops: Sequence[LoopData]) -> dict[str, tuple[float, ...]]:
    """Frequency, stroke and mid-stroke speed of each loop, as the rate table of a model file keeps them."""
    kept = [data for data in loops if np.isfinite(data.mid_stroke_speed_m_per_s) and data.mid_stroke_speed_m_per_s > 0.0]
    return {
        "frequency_Hz": tuple(float(data.frequency_Hz) for data in kept),
        "stroke_m": tuple(float(2.0 * data.amplitude_m) for data in kept),
        "mid_stroke_speed_m_per_s": tuple(float(data.mid_stroke_speed_m_per_s) for data in kept),
    }


def require_rates(loops: Sequence[LoopData], abscissa: Abscissa, order: int) -> None:
    """Refuse polynomials that these loops cannot carry.

    Raises
    ------
    InputError
        A loop without a frequency; fewer frequencies than a polynomial of this order needs.
    """
    x = rates_of(loops, abscissa)
    for data, value in zip(loops, x, strict=True):
        if not np.isfinite(value):
            raise InputError(f"{data.name}: no full cycle, so no {abscissa}; leave the loop out or fit without --rate.")
    if len(groups_of_rate(x)) < order + 1:
        raise InputError(
            f"{len(groups_of_rate(x))} different values of {abscissa} in these loops; a polynomial of order {order} needs {order + 1}. "
            f"Give --rate-order {len(groups_of_rate(x)) - 1} or more loops."
        )


def groups_of_rate(x: Array) -> list[list[int]]:
    """Places of loops of one rate together, in rising order; values within two per cent count as one."""
    order = np.argsort(x)
    groups: list[list[int]] = [[int(order[0])]]
    for k in order[1:]:
        if x[k] - x[groups[-1][-1]] > SAME_RATE * abs(x[k]):
            groups.append([])
        groups[-1].append(int(k))
    return groups


def strokes(loops: Sequence[LoopData]) -> list[list[LoopData]]:
    """Loops with a full cycle in groups of one amplitude, in rising order."""
    groups: list[list[LoopData]] = []
    for data in sorted(loops, key=lambda d: d.amplitude_m):
        if groups and data.amplitude_m < (1.0 + SAME_STROKE) * groups[-1][0].amplitude_m:
            groups[-1].append(data)
        else:
            groups.append([data])
    return groups


def by_stroke(loops: Sequence[LoopData]) -> list[int]:
    """Places of the largest group of loops of one stroke, by frequency; of all loops where no two have one."""
    return _largest(loops, "amplitude_m", "frequency_Hz", SAME_STROKE)


def by_frequency(loops: Sequence[LoopData]) -> list[int]:
    """Places of the largest group of loops of one frequency, by amplitude; of all loops where no two have one."""
    return _largest(loops, "frequency_Hz", "amplitude_m", SAME_RATE)


def _largest(loops: Sequence[LoopData], alike: str, then: str, within: float) -> list[int]:
    known = [k for k, data in enumerate(loops) if np.isfinite(getattr(data, alike))]
    groups = [[j for j in known if abs(getattr(loops[j], alike) / getattr(loops[k], alike) - 1.0) <= within] for k in known]
    group = max(groups, key=len, default=[])
    chosen = group if len(group) > 1 else list(range(len(loops)))
    return sorted(chosen, key=lambda k: float(np.nan_to_num(getattr(loops[k], then))))


def what_differs(loops: Sequence[LoopData]) -> list[str]:
    """What else differs between the files: frequency, stroke, stated conditions, further columns."""
    found = []
    frequencies, strokes = (np.array([getattr(d, key) for d in loops]) for key in ("frequency_Hz", "amplitude_m"))
    for name, values, same, unit, scale in (
        ("frequency", frequencies, SAME_RATE, "Hz", 1.0),
        ("stroke", 2e3 * strokes, SAME_STROKE, "mm", 1.0),
    ):
        if np.all(np.isfinite(values)) and np.ptp(values) > same * np.max(values) * scale:
            found.append(f"{name} ({values.min():.4g} to {values.max():.4g} {unit})")
    for name in sorted(set.intersection(*(set(d.other) for d in loops))):
        means = np.array([float(np.nanmean(d.other[name])) for d in loops])
        within = max(float(np.nanstd(d.other[name])) for d in loops)
        if np.ptp(means) > 3.0 * within:
            found.append(f'column "{name}" ({means.min():.4g} to {means.max():.4g})')
    return found


def follows_frequency(loops: Sequence[LoopData], values: Array) -> bool:
    """Whether a quantity follows the frequency from loop to loop: a line through its logarithm explains nine tenths of its variance."""
    x = np.log([d.frequency_Hz for d in loops])
    known = np.isfinite(x) & np.isfinite(values)
    if np.count_nonzero(known) < 3 or np.ptp(x[known]) < SAME_RATE:
        return False
    return bool(np.corrcoef(x[known], values[known])[0, 1] ** 2 > 0.9)


_CORRELATED = 0.9


def frequency_amplitude_correlation(loops: Sequence[LoopData]) -> float:
    """Correlation of frequency and amplitude over the loops; NaN where one of them does not vary."""
    f = np.array([d.frequency_Hz for d in loops])
    a = np.array([d.amplitude_m for d in loops])
    known = np.isfinite(f) & np.isfinite(a)
    if known.sum() < 3 or np.ptp(f[known]) < 0.02 * np.max(f[known]) or np.ptp(a[known]) < 0.02 * np.max(a[known]):
        return float("nan")
    return float(np.corrcoef(f[known], a[known])[0, 1])


def correlation_sentence(correlation: float) -> str:
    """What the correlation of frequency and amplitude forbids to conclude; nothing where it does not."""
    if not abs(correlation) > _CORRELATED:
        return ""
    return f"frequency and amplitude are correlated at {correlation:.2f}: what follows one cannot be told from what follows the other"
