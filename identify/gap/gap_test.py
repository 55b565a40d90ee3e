"""Whether what a fit leaves is more than noise: its slow parts against its fast ones."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import fft, linalg, special

from identify.criteria import FAST_NOISE, GAP_P, SURE_MISFIT
from identify.estimation.fit import Fitted, Posed
from identify.gap.misfit import misfit_of, not_repeated
from identify.noise.noise_model import ChannelNoise, from_differences, places_of, spacing
from measure.common.arrays import Array

_LOW_SHARE, _LOWEST_SHARE = 0.25, 0.05
_LEAST_SAMPLES = 16
_LEAST_FLOAT = 1e-300
_OUTLIER, _USUAL, _USUAL_SIGMAS = 5.0, 0.9, 1.645  # sigmas; the share of samples that tells sigma, and how many it is of it
_DRAWS, _MOST_DRAWN, _SEED = 100, 10_000, 2009  # of noise, and samples of one
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

    Noise has a short memory, a missing effect moves what is slow. The memory of each channel's noise and its white share, over all runs,
    come from the differences of samples in short windows, in which a slow gap hardly shows, and of a loop from what does not come again in
    every cycle. They are taken out. Noise then shakes every frequency alike: the power of the slow quarter of a cosine transform, for each
    degree of freedom that the fit has left, is compared with that of the rest. How far the two differ by chance is seen in noise of the
    same memory and length that goes the same way (parametric bootstrap). A noise level is hardly assumed, so a sigma that is off cannot
    fake a gap; only what lies below a tenth of the noise is none. Single samples that stand out from those around them are left out.
    """
    return GapTest(slow_p(_by_channel(fit), fit.determined), _release_p(fit), fit.rms)


def slow_p(channels: Sequence[Sequence[Series]], taken: float = 0.0) -> float:
    """How likely noise is as slow as what is left of these channels, of which a fit has taken so many degrees of freedom.

    Series that are too short to tell are left out.
    """
    channels = [long for series in channels if (long := _long(map(_without_outliers, _long(series))))]
    noises = [_noise_of(series) for series in channels]
    found = [_powers(series, noise) for series, noise in zip(channels, noises, strict=True)]
    slow_n, count = sum(power.slow_n for power in found), sum(len(one.gaps) for series in channels for one in series)
    if not count:
        return 1.0
    freedom = max(slow_n - taken, 1.0)
    ratio = sum(power.slow / power.noise for power in found) / freedom
    share = min(1.0, _MOST_DRAWN / count)
    alike = tuple(_DrawnNoise.of(noise, series, share) for noise, series in zip(noises, channels, strict=True))
    mean, deviation = _by_chance(alike)
    spread = deviation * float(np.sqrt(share * slow_n / freedom))
    return float(special.ndtr((share * mean - np.log(max(ratio, 1e-300))) / spread))


def _long(series: Iterable[Series]) -> list[Series]:
    return [one for one in series if len(one.gaps) >= _LEAST_SAMPLES]


def _by_channel(fit: Fitted[Posed]) -> list[list[Series]]:
    """What is left, channel by channel, of every run."""
    found: dict[str, list[Series]] = {}
    loops = {loop.data.name: loop.data for loop in fit.problem.loops}
    for block in fit.problem.blocks:
        gaps, loop = fit.part(block), loops.get(block.run)
        own = None if loop is None else not_repeated(loop, gaps)
        found.setdefault(block.channel, []).append(Series(gaps, spacing(block.samples), own))
    return list(found.values())


@dataclass(frozen=True)
class Series:
    """What is left of a channel of a run, (n,), and how many samples apart neighbours stand, see `noise_model.spacing`.

    not_repeated : (n,) what of it does not come again in every cycle of a loop, NaN where no cycle does; by default all.
    """

    gaps: Array
    apart: Array
    not_repeated: Array | None = None

    def only(self, keep: NDArray[np.bool_]) -> Series:
        """Some of the samples; the others are missing."""
        own = None if self.not_repeated is None else self.not_repeated[keep]
        return Series(self.gaps[keep], spacing(places_of(self.apart)[keep]), own)

    @property
    def noise(self) -> tuple[Array, Array]:
        """What tells of noise alone, and how far its samples stand apart."""
        if self.not_repeated is None:
            return self.gaps, self.apart
        known = np.isfinite(self.not_repeated)
        return self.not_repeated[known], self.only(known).apart


def _without_outliers(one: Series) -> Series:
    """Without single samples that stand out from the four around them as noise hardly ever does; these become missing samples."""
    around = np.concatenate([one.gaps[2:0:-1], one.gaps, one.gaps[-2:-4:-1]])
    beside = np.delete(np.lib.stride_tricks.sliding_window_view(around, 5), 2, axis=1)
    off = np.abs(one.gaps - np.median(beside, axis=1))
    usual = float(np.quantile(off, _USUAL))
    keep = (off <= _OUTLIER * usual / _USUAL_SIGMAS) | (usual == 0.0)
    return one.only(keep)


def _noise_of(series: Sequence[Series]) -> ChannelNoise:
    found = from_differences([one.noise for one in series])
    return replace(found, scale=max(found.scale, _LEAST_NOISE))


@dataclass(frozen=True)
class _Powers:
    """Slow power of a channel's series, their number of slow coefficients, and the noise of one coefficient by the fast ones."""

    slow: float
    slow_n: int
    noise: float


def _powers(series: Sequence[Series], noise: ChannelNoise) -> _Powers:
    found = [power for one in series if (power := power_of(noise.whitened(one.gaps, one.apart))) is not None]
    fast = sum(power.fast for power in found) / max(sum(power.fast_n for power in found), 1)
    return _Powers(sum(power.slow for power in found), sum(power.slow_n for power in found), max(fast, (_LEAST_NOISE / noise.scale) ** 2))


@dataclass(frozen=True)
class _DrawnNoise:
    """Noise that is drawn for a channel: its memory and white share, and as bytes how far apart the samples of each series stand."""

    memory: float
    white: float
    apart: tuple[bytes, ...]

    @classmethod
    def of(cls, noise: ChannelNoise, series: Sequence[Series], share: float) -> _DrawnNoise:
        """For as many samples of each series as a share of its length."""
        lengths = [max(int(share * len(one.apart)), _LEAST_SAMPLES) for one in series]
        return cls(noise.memory, noise.white, tuple(one.apart[:n].tobytes() for one, n in zip(series, lengths, strict=True)))

    def drawn(self, chance: np.random.Generator) -> list[Series]:
        """One draw, of scale one."""
        return [self._series(np.frombuffer(apart), chance) for apart in self.apart]

    def _series(self, apart: Array, chance: np.random.Generator) -> Series:
        places = places_of(apart)
        innovations = np.sqrt(1.0 - self.memory**2) * chance.normal(size=places[-1] + 1)
        innovations[0] /= np.sqrt(1.0 - self.memory**2)
        steps = np.stack([np.ones(len(innovations)), np.full(len(innovations), -self.memory)])  # x_k - memory x_k-1 is new
        remembers = linalg.solve_banded((1, 0), steps, innovations)[places]
        white = chance.normal(size=len(places))
        return Series(np.sqrt(1.0 - self.white) * remembers + np.sqrt(self.white) * white, apart)


@lru_cache(maxsize=16)
def _by_chance(channels: tuple[_DrawnNoise, ...]) -> tuple[float, float]:
    """Mean and deviation of the logarithm of slow over fast power in such noise. Fits of the same runs mostly find the same noise."""
    chance = np.random.default_rng(_SEED)
    drawn = [np.log(_drawn_ratio(channels, chance)) for _ in range(_DRAWS)]
    return float(np.mean(drawn)), float(np.std(drawn, ddof=1))


def _drawn_ratio(channels: Sequence[_DrawnNoise], chance: np.random.Generator) -> float:
    """Slow over fast power of noise of its own in each channel."""
    slow = slow_n = 0.0
    for channel in channels:
        drawn = channel.drawn(chance)
        power = _powers(drawn, _noise_of(drawn))
        slow, slow_n = slow + power.slow / power.noise, slow_n + power.slow_n
    return slow / slow_n


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
        return float(special.fdtrc(self.slow_n, self.fast_n, self.ratio))


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
    """How likely releases as far from the planned one are, if they follow their priors.

    In spreads of their priors the estimates q of a right model scatter by V = I - 2 H + C: C is their covariance under the noise that is
    left, H the one under white noise, for which the fit took it. So what a film hardly shows, and stays as planned, hardly counts. What it
    shows by its square alone obeys no straight line and counts at least as if it were determined. q'q is compared with a chi^2 of the same
    mean and variance (Satterthwaite 1946).
    """
    problem = fit.problem
    own = np.array([i for i in fit.columns if problem.first_nuisance <= i < problem.first_zero and not problem.held[i]], dtype=np.intp)
    if not len(own):
        return 1.0
    places, spread = np.searchsorted(fit.columns, own), np.array([problem.parameters[i].spread for i in own])
    q = fit.q[own] / spread
    scatter = np.eye(len(own)) + (fit.covariance - 2.0 * fit.covariance_if_white)[np.ix_(places, places)] / np.outer(spread, spread)
    by_square = problem.unseen[own]
    scatter[by_square, by_square] = np.maximum(np.diag(scatter), 1.0)[by_square]
    mean, half_variance = float(np.trace(scatter)), float(np.sum(scatter**2))
    return float(special.chdtrc(mean**2 / half_variance, q @ q * mean / half_variance)) if mean > 0.0 else 1.0
