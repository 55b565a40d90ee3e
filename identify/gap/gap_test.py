"""Whether what a fit leaves is more than noise: its slow parts against its fast ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import fft, signal, stats

from identify.criteria import FAST_NOISE, GAP_P, SURE_MISFIT
from identify.estimation.fit import Fitted, Posed
from identify.estimation.noise_model import ChannelNoise, spacing
from identify.gap.misfit import misfit_of
from measure.common.arrays import Array

_LOW_SHARE, _LOWEST_SHARE = 0.25, 0.05
_LEAST_SAMPLES = 16
_LEAST_FLOAT = 1e-300
_LONGEST_MEMORY = 0.95
_DRAWS, _MOST_DRAWN, _SEED = 50, 20_000, 2009  # of noise, and samples of one
_LEAST_NOISE = 0.1  # of the noise that a measurement is taken to have


@dataclass(frozen=True)
class GapTest:
    """Whether what is left is more than noise: probabilities of as much if it were noise.

    slow_p : slow parts of the gap against its fast parts. release_p : the releases against their priors (chi^2).
    """

    slow_p: float
    release_p: float
    rms_over_noise: float

    @property
    def p_value(self) -> float:
        """The smaller one, both having been looked at."""
        return float(min(1.0, 2.0 * min(self.slow_p, self.release_p)))


def p_words(value: float) -> str:
    """A probability as people read it; one too small for a float is not called nought."""
    return f"p = {value:.2g}" if value >= _LEAST_FLOAT else f"p < {_LEAST_FLOAT:.0e}"


def gap_test(fit: Fitted[Posed]) -> GapTest:
    """Test a fit for a gap beyond noise.

    Noise has a short memory, a missing effect moves what is slow. The memory of each channel's noise, over all runs, comes from the
    differences of neighbouring samples, in which a slow gap does not show, less what rounding makes of them, and is taken out. Noise then
    shakes every frequency alike: the power of the slow quarter of a cosine transform, for each degree of freedom that the fit has left, is
    compared with that of the rest. How far the two differ by chance is seen in noise of the same memory, rounding and length that goes the
    same way (parametric bootstrap). A noise level is hardly assumed, so a sigma that is off cannot fake a gap; only what lies below a tenth
    of the noise is none.
    """
    return GapTest(slow_p(_by_channel(fit), fit.determined), _release_p(fit), fit.rms)


def slow_p(channels: Sequence[Sequence[Series]], taken: float = 0.0) -> float:
    """How likely noise is as slow as what is left of these channels, of which a fit has taken so many degrees of freedom.

    Series that are too short to tell are left out.
    """
    long = [[one for one in series if len(one.gaps) >= _LEAST_SAMPLES] for series in channels]
    channels = [_with_fine_rounding(series) for series in long if series]
    found = [_powers(series) for series in channels]
    slow_n, count = sum(power.slow_n for power in found), sum(len(one.gaps) for series in channels for one in series)
    if not count:
        return 1.0
    freedom = max(slow_n - taken, 1.0)
    ratio = sum(power.slow / power.noise for power in found) / freedom
    chance, share = np.random.default_rng(_SEED), min(1.0, _MOST_DRAWN / count)
    drawn = [np.log(_drawn_ratio(channels, share, chance)) for _ in range(_DRAWS)]
    spread = float(np.std(drawn, ddof=1)) * float(np.sqrt(share * slow_n / freedom))
    return float(stats.norm.sf((np.log(max(ratio, 1e-300)) - share * float(np.mean(drawn))) / spread))


def _by_channel(fit: Fitted[Posed]) -> list[list[Series]]:
    """What is left, channel by channel, of every run."""
    found: dict[str, list[Series]] = {}
    for block in fit.problem.blocks:
        found.setdefault(block.channel, []).append(Series(fit.part(block), spacing(block.samples), block.rounding))
    return list(found.values())


@dataclass(frozen=True)
class Series:
    """What is left of a channel of a run, (n,), how many samples apart neighbours stand, see `noise_model.spacing`, and its rounding.

    rounding : one standard deviation of the error of rounding, which has no memory.
    """

    gaps: Array
    apart: Array
    rounding: float = 0.0


def memory_of(series: Sequence[Series]) -> tuple[float, float]:
    """Correlation rho of neighbouring samples of the noise but for its rounding, and its variance.

    From its differences: their variance is 2 (1 - rho) times that of the noise, and neighbours correlate by -(1 - rho) / 2. Rounding adds
    two of its own variances to theirs, and takes one off the product of neighbours.
    """
    power, product, rounding, count = _of_differences(series)
    power, product = power - 2.0 * rounding, product + rounding
    rho = float(np.clip(1.0 + 2.0 * product / power, 0.0, _LONGEST_MEMORY)) if power > 0.0 else 0.0
    return rho, max(power / (2.0 * (1.0 - rho) * max(count, 1)), _LEAST_NOISE**2)


def _with_fine_rounding(series: Sequence[Series]) -> list[Series]:
    """Without the rounding where that is coarser than what differs from sample to sample: it is no noise then."""
    power, _, rounding, _ = _of_differences(series)
    return list(series) if power > 2.0 * rounding else [replace(one, rounding=0.0) for one in series]


def _of_differences(series: Sequence[Series]) -> tuple[float, float, float, int]:
    """Sums over all differences: of their squares, of the products of neighbours, of the squares of rounding, and how many there are."""
    power = product = rounding = 0.0
    count = 0
    for one in series:
        steps, beside = np.diff(one.gaps), one.apart[1:] == 1.0
        pairs, own = beside[1:] & beside[:-1], int(beside.sum())
        power += float(np.sum(steps[beside] ** 2))
        product += float(np.sum(steps[1:][pairs] * steps[:-1][pairs])) * own / max(pairs.sum(), 1)
        rounding += own * one.rounding**2
        count += own
    return power, product, rounding, count


@dataclass(frozen=True)
class _Powers:
    """Slow power of a channel's series, their number of slow coefficients, and the noise of one coefficient by the fast ones."""

    slow: float
    slow_n: int
    noise: float


def _powers(series: Sequence[Series]) -> _Powers:
    own = ChannelNoise(memory_of(series)[0])
    found = [power for one in series if (power := power_of(own.whitened(one.gaps, one.apart))) is not None]
    fast = sum(power.fast for power in found) / max(sum(power.fast_n for power in found), 1)
    return _Powers(sum(power.slow for power in found), sum(power.slow_n for power in found), max(fast, _LEAST_NOISE**2))


def _drawn_ratio(channels: Sequence[Sequence[Series]], share: float, chance: np.random.Generator) -> float:
    """Slow over fast power of noise with the memory and the missing samples of these channels, of a share of their length."""
    slow = slow_n = 0.0
    for series in channels:
        rho, variance = memory_of(series)
        power = _powers([_noise_like(one, rho, variance, share, chance) for one in series])
        slow, slow_n = slow + power.slow / power.noise, slow_n + power.slow_n
    return slow / slow_n


def _noise_like(one: Series, rho: float, variance: float, share: float, chance: np.random.Generator) -> Series:
    apart = one.apart[: max(int(share * len(one.apart)), _LEAST_SAMPLES)]
    places = np.cumsum(np.where(np.isfinite(apart), apart, 0.0)).astype(int)
    innovations = chance.normal(0.0, np.sqrt(variance * (1.0 - rho**2)), places[-1] + 1)
    innovations[0] /= np.sqrt(1.0 - rho**2)
    gaps = signal.lfilter([1.0], [1.0, -rho], innovations)[places]
    if one.rounding:
        gaps += chance.normal(0.0, one.rounding, len(gaps))
    return replace(one, gaps=gaps, apart=apart)


@dataclass(frozen=True)
class Power:
    """Sum of squares of the slow and of the fast part of a series, and how many coefficients each has."""

    slow: float
    fast: float
    slow_n: int
    fast_n: int

    @property
    def ratio(self) -> float:
        """Slow power over fast power, one where the series is white."""
        return (self.slow / self.slow_n) / max(self.fast / self.fast_n, 1e-300)

    @property
    def p_value(self) -> float:
        """How likely as much is, were the series white (F test)."""
        return float(stats.f.sf(self.ratio, self.slow_n, self.fast_n))


def power_of(series: Array, slow: float = _LOW_SHARE) -> Power | None:
    """The slow share of a series (n,) against the rest, or None of one that is too short to tell."""
    if len(series) < _LEAST_SAMPLES:
        return None
    power = np.asarray(fft.dct(series, norm="ortho")) ** 2
    cut = max(4, int(slow * len(series)))
    return Power(float(power[:cut].sum()), float(power[cut:].sum()), cut, len(series) - cut)


def leaves_noise(fit: Fitted[Posed], noise: Sequence[ChannelNoise]) -> bool:
    """Whether what a fit leaves is such noise, one for each block: it forgets within a few samples, and comes again in no loop."""
    blocks = fit.problem.blocks
    return is_noise([of.whitened(fit.part(b), spacing(b.samples)) for of, b in zip(noise, blocks, strict=True)]) and not _comes_again(fit)


def _comes_again(fit: Fitted[Posed]) -> bool:
    """Whether loops have a gap as large as their noise that comes again in every cycle."""
    loops = [loop.data for loop in fit.problem.loops]
    if not loops:
        return False
    left = misfit_of(loops, fit.residuals_N)
    over = left.repeated_N / np.array([data.force_sigma_N for data in loops])
    return bool(left.significance > SURE_MISFIT and np.max(over) > 1.0)


def is_noise(innovations: Sequence[Array]) -> bool:
    """Whether what is left of each channel, whitened, is noise: nothing slow, or very slow, stands out by chance and by its size."""
    looks = [power_of(series, slow) for series in innovations for slow in (_LOW_SHARE, _LOWEST_SHARE)]
    powers = [power for power in looks if power is not None]
    return not any(power.p_value < GAP_P / len(powers) and power.ratio > FAST_NOISE**2 for power in powers)


def _release_p(fit: Fitted[Posed]) -> float:
    """How likely releases as far from the planned one are, if they follow their priors."""
    problem = fit.problem
    q = fit.q[problem.first_nuisance : problem.first_zero]
    return float(stats.chi2.sf(q @ q, len(q))) if len(q) else 1.0
