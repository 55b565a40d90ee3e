"""The noise of a channel: a part with a short memory, a white part, heavy tails; estimated from what a fit leaves.

    E[r_i r_j] = s^2 ((1 - omega) rho^d + omega [i = j]),    innovations Student t with 5 degrees of freedom

d is how many samples i and j are apart (a missing frame counts), omega the white share of the variance s^2. The memory is bounded: noise
that remembers longer than a few samples cannot be told from a missing effect, and would swallow one. Memory and white share are those under
which each sample is predicted best from those of the few places before it that hold one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, special

from identify.criteria import DEGREES
from measure.common.arrays import Array

LONGEST_MEMORY = 0.85
SMALLEST_SCALE = 0.3  # of the noise that the fast part of a channel shows
_ROUNDS = 4
_PER_SIGMA = 1.4826
_REACH, _OF_CONTRASTS = 5, 8  # samples before one from which it is predicted; contrasts tell less of what is slow
_PIECE, _LOUD = 30, 2.0  # samples of a piece, and how many times the usual power of a piece is no noise
_MEMORIES, _WHITE = np.linspace(0.0, LONGEST_MEMORY, 35), np.linspace(0.0, 0.95, 20)
_triangular: Any = linalg.get_lapack_funcs("tbtrs", dtype=float)  # solves banded triangular equations
_LOG_T = float(special.gammaln((DEGREES + 1.0) / 2.0) - special.gammaln(DEGREES / 2.0) - 0.5 * np.log(DEGREES * np.pi))


@dataclass(frozen=True)
class ChannelNoise:
    """The noise of one run and channel.

    memory : correlation of neighbouring samples of the part that remembers. white : share of the variance that does not.
    scale : of the noise, in units of its sigma.
    """

    memory: float = 0.0
    white: float = 0.0
    scale: float = 1.0

    @property
    def lag1(self) -> float:
        """Correlation of neighbouring samples."""
        return (1.0 - self.white) * self.memory

    @property
    def sigma(self) -> float:
        """Standard deviation, of which the scale of Student's t is a part."""
        return self.scale * float(np.sqrt(DEGREES / (DEGREES - 2.0)))

    def whitened(self, values: Array, apart: Array) -> Array:
        """Innovations over their scales of a residual (n,), or of columns (n, k)."""
        return Whitening.of(self, apart).whitened(values)


@dataclass(frozen=True)
class Whitening:
    """What makes a run's samples independent of each other.

    kept : (n,) how much of the sample before a sample remembers. size : (n,) scale of what is new in it. tied : (2, n) lower Cholesky
    factor of the covariance of both parts once the memory is taken out, when only neighbours are correlated; None without a white part.
    """

    kept: Array
    size: Array
    tied: Array | None

    @classmethod
    def of(cls, noise: ChannelNoise, apart: Array) -> Whitening:
        """For samples that stand `apart` (n,) from the one before; the first has none, which is infinitely far."""
        kept = noise.memory**apart
        unit = np.sqrt(1.0 - kept**2)
        return cls(kept, noise.scale * unit, cls._tied(noise.white, kept, unit) if noise.white > 0.0 and noise.memory > 0.0 else None)

    @staticmethod
    def _tied(white: float, kept: Array, unit: Array) -> Array:
        rows = np.zeros((2, len(kept)))
        rows[0] = 1.0 - white + white * (1.0 + kept**2) / unit**2
        rows[1, :-1] = -white * kept[1:] / (unit[1:] * unit[:-1])
        return np.asarray(linalg.cholesky_banded(rows, overwrite_ab=True, lower=True, check_finite=False))

    def whitened(self, values: Array) -> Array:
        """Innovations over their scales of a residual (n,), or of columns (n, k)."""
        shape = (-1, *([1] * (values.ndim - 1)))
        out = values / self.size.reshape(shape)
        out[1:] -= (self.kept / self.size)[1:].reshape(shape) * values[:-1]
        return out if self.tied is None else np.asarray(_triangular(self.tied, out, uplo="L", overwrite_b=True)[0]).reshape(values.shape)

    @property
    def log_size(self) -> float:
        """Sum of the logarithms of the scales, what whitening takes off a log likelihood."""
        return float(np.sum(np.log(self.size if self.tied is None else self.size * self.tied[0])))


def spacing(samples: NDArray[np.intp]) -> Array:
    """How many samples each stands behind the one before, (n,), from their indices; infinity for the first."""
    return np.concatenate([[np.inf], np.diff(samples).astype(float)])[: len(samples)]


def places_of(apart: Array) -> NDArray[np.intp]:
    """The place of each sample in its run, (n,), from its `spacing`; the first one stands at zero."""
    return np.cumsum(np.where(np.isfinite(apart), apart, 0.0)).astype(np.intp)


def weights(innovations: Array) -> Array:
    """How much each whitened value counts under Student's t, (n,): one in the middle, little far out."""
    return (DEGREES + 1.0) / (DEGREES + innovations**2)


def log_probability(noise: ChannelNoise, residual: Array, apart: Array) -> float:
    """Of a residual (n,) under a noise."""
    whitening = Whitening.of(noise, apart)
    return log_likelihood(whitening.whitened(residual)) - whitening.log_size


def log_likelihood(innovations: Array) -> float:
    """Of whitened values under Student's t of scale one."""
    return len(innovations) * _LOG_T - 0.5 * (DEGREES + 1.0) * float(np.sum(np.log1p(innovations**2 / DEGREES)))


@dataclass(frozen=True)
class Taken:
    """What a fit has taken from the noise of a channel: so many parameters, and with them mostly what was slow in it.

    columns : (n, k) of what a step of each does to the samples. spread : (n, k), the same times the covariance of the steps.
    """

    count: float
    columns: Array
    spread: Array

    @classmethod
    def nothing(cls, n: int) -> Taken:
        """By a fit that has no parameters here."""
        return cls(0.0, np.empty((n, 0)), np.empty((n, 0)))

    @classmethod
    def by(cls, columns: Array, covariance: Array, count: float) -> Taken:
        """By parameters of columns (n, k) and a covariance (k, k), of which these samples have determined so many."""
        return cls(count, columns, columns @ covariance)


def estimated(residual: Array, apart: Array, taken: Taken | None = None, start: ChannelNoise | None = None) -> ChannelNoise:
    """Memory, white share and scale that suit a residual (n,) best, by a few rounds of reweighting (EM for Student's t).

    A residual is smaller than the noise by what a fit has taken from it, and forgets sooner: that is given back, so that the noise suits
    best with the parameters integrated out (restricted likelihood: Harville 1977).

    Parameters
    ----------
    apart : see `spacing`.
    start : noise that is nearly right, from which one round is enough.
    """
    taken = taken or Taken.nothing(len(residual))
    if len(residual) < 4:
        return ChannelNoise(scale=max(1.0, float(np.sqrt(np.mean(residual**2))) if len(residual) else 1.0))
    share = len(residual) / max(len(residual) - taken.count, 0.5 * len(residual))
    noise = start or ChannelNoise(scale=max(_PER_SIGMA * float(np.median(np.abs(residual))), SMALLEST_SCALE))
    for _ in range(_ROUNDS if start is None else 1):
        noise = _reestimated(noise, residual, apart, share, taken)
    return noise


def _reestimated(noise: ChannelNoise, residual: Array, apart: Array, share: float, taken: Taken) -> ChannelNoise:
    trusted, places = weights(noise.whitened(residual, apart)), places_of(apart)
    placed = replace(taken, columns=_placed(places, taken.columns), spread=_placed(places, taken.spread))
    windows = _Windows.of(_placed(places, residual), _placed(places, trusted), _REACH, placed)
    memory, white, _ = _likeliest(windows, len(residual))
    unit = ChannelNoise(memory, white).whitened(residual, apart)
    scale = float(np.sqrt(share * np.mean(weights(unit / noise.scale) * unit**2)))
    return ChannelNoise(memory, white, max(scale, SMALLEST_SCALE))


def from_differences(runs: Sequence[tuple[Array, Array]]) -> ChannelNoise:
    """The noise of a channel from the differences of samples in short windows, in which a slow gap hardly shows.

    Noise is equally loud everywhere. Pieces that are louder than most hold a gap that is quick for a while, as behind a stop; they are left
    out.

    Parameters
    ----------
    runs : of each run what is left (n,), and how far its samples stand apart, see `spacing`.
    """
    powers = [_powers(*run) for run in runs]
    moving = np.concatenate([power[power > 0.0] for power in powers])
    if not len(moving):
        return ChannelNoise(scale=0.0)
    limit = _LOUD * float(np.median(moving))
    quiet = [(power <= limit)[places_of(apart) // _PIECE].astype(float) for (_, apart), power in zip(runs, powers, strict=True)]
    placed = [[_placed(places_of(apart), of) for of in (gaps, told)] for (gaps, apart), told in zip(runs, quiet, strict=True)]
    found = _Windows.together([_Windows.of(values, told, _OF_CONTRASTS) for values, told in placed])
    memory, white, square = _likeliest(found, int(sum(map(np.sum, quiet))), contrasts=True)
    return ChannelNoise(memory, white, float(np.sqrt(square)))


def _powers(gaps: Array, apart: Array) -> Array:
    """Mean square of the steps from sample to sample in each piece, of those no farther apart than is usual; zero where there are none."""
    pieces = places_of(apart) // _PIECE
    near = apart[1:] <= np.median(apart[1:]) if len(gaps) > 1 else np.zeros(0, dtype=bool)
    count, square = (np.bincount(pieces[:-1], of, pieces[-1] + 1) for of in (near, near * np.diff(gaps) ** 2))
    return square / np.maximum(count, 1.0)


def _placed(places: NDArray[np.intp], values: Array) -> Array:
    """Samples (n, ...) at their places in a run without holes; nothing in between."""
    if places[-1] + 1 == len(places):
        return values
    out = np.zeros((places[-1] + 1, *values.shape[1:]))
    out[places] = values
    return out


@dataclass(frozen=True)
class _Windows:
    """Samples, each with those up to `reach` places before it, put together by which of these places hold a sample.

    held : (p,) the places 1 to reach before the sample, as bits of a number. count : (p,) of the samples, as far as they are trusted.
    products : (p, k) as many times the mean product of the values at two places 0 to reach before it, in the order of `numpy.triu_indices`.
    """

    reach: int
    held: NDArray[np.intp]
    count: Array
    products: Array

    @classmethod
    def of(cls, values: Array, trust: Array, reach: int, taken: Taken | None = None) -> _Windows:
        """Of samples (n,) at places without holes, each trusted (n,) so much, those that are not there not at all.

        A pair counts with the smaller trust of its two samples. What a fit has taken is given back to the products.
        """
        groups = _grouped((trust > 0.0).tobytes(), reach)
        products, weight = np.zeros((2, reach + 1, len(values)))
        for apart in range(min(reach + 1, len(values))):
            later, earlier = slice(apart, None), slice(0, len(values) - apart)
            product = values[later] * values[earlier]
            if taken is not None:
                product += np.einsum("ij,ij->i", taken.spread[later], taken.columns[earlier])
            weight[apart, later] = np.minimum(trust[later], trust[earlier])
            products[apart, later] = weight[apart, later] * product
        of_windows = trust[groups.samples], products.take(groups.pairs), weight.take(groups.pairs)
        count, sums, weights = (np.add.reduceat(of, groups.starts) if len(groups.held) else of for of in of_windows)
        return cls(reach, groups.held, count, count[:, None] * sums / np.maximum(weights, 1e-300))

    @classmethod
    def together(cls, parts: Sequence[_Windows]) -> _Windows:
        """Those of several runs."""
        held, place = np.unique(np.concatenate([one.held for one in parts]), return_inverse=True)
        count, products = np.zeros(len(held)), np.zeros((len(held), parts[0].products.shape[1]))
        np.add.at(count, place, np.concatenate([one.count for one in parts]))
        np.add.at(products, place, np.concatenate([one.products for one in parts]))
        return cls(parts[0].reach, held, count, products)


@dataclass(frozen=True)
class _Groups:
    """Windows of a run put together by which places before their sample hold one.

    held : (p,) these places, as bits of a number. starts : (p,) the first window of each group. samples : (m,) of each window, group by
    group. pairs : (m, k) where in (reach + 1, n), laid flat, each of its pairs stands: how many places apart, and the later place.
    """

    held: NDArray[np.intp]
    starts: NDArray[np.intp]
    samples: NDArray[np.intp]
    pairs: NDArray[np.intp]


@lru_cache(maxsize=32)
def _grouped(there: bytes, reach: int) -> _Groups:
    """The windows of places (n,) of which one byte each says whether it holds a sample; none lies before the first."""
    at = np.concatenate([np.zeros(reach, dtype=np.uint8), np.frombuffer(there, dtype=np.uint8)])
    n, back = len(there), np.arange(reach + 1)
    held = at[np.arange(n)[:, None] + reach - back[1:]] @ (1 << back[:-1])
    samples = np.flatnonzero(at[reach:])
    samples = samples[np.argsort(held[samples], kind="stable")]
    groups, starts = np.unique(held[samples], return_index=True)
    later, earlier = np.triu_indices(reach + 1)
    pairs = (earlier - later) * n + np.maximum(samples[:, None] - later, 0)  # a pair that reaches before the first place never counts
    return _Groups(groups, starts, samples, pairs)


def _likeliest(found: _Windows, samples: int, contrasts: bool = False) -> tuple[float, float, float]:
    """Memory and white share under which the windows of so many samples are likeliest, and the variance of the noise.

    Noise is taken for as many times less likely beforehand as it makes the variance of a mean over many samples larger than white noise
    does: a memory that the samples do not show is none.

    contrasts : whether only the differences of samples count, in which what is slow hardly shows; a sample alone has none.
    """
    told = np.flatnonzero((found.count > 0.0) & ((found.held > 0) | (not contrasts)))
    square, log_size = np.zeros((2, len(_MEMORIES) * len(_WHITE)))
    for held, count, products in zip(found.held[told], found.count[told], found.products[told], strict=True):
        new = _newness(found.reach, int(held), contrasts)
        square += products[new.pairs] @ new.quadratic
        log_size += count * new.log_size
    whole = max(float(np.sum(found.count[told])), 1e-300)
    square = np.maximum(square / whole, 1e-300)
    best = int(np.argmin(0.5 * samples * (np.log(square) + log_size / whole) + _unlikely()))
    memory, white = np.unravel_index(best, (len(_MEMORIES), len(_WHITE)))
    return float(_MEMORIES[memory]), float(_WHITE[white]), float(square[best])


@cache
def _unlikely() -> Array:
    """Minus the logarithm of the prior of each memory and white share, (g,)."""
    memory, white = _MEMORIES[:, None], _WHITE[None, :]
    return np.log(white + (1.0 - white) * (1.0 + memory) / (1.0 - memory)).ravel()


@dataclass(frozen=True)
class _Newness:
    """What is new in a sample beside those before it, for each memory and white share (g,), in noise of variance one.

    pairs : (p,) of places, of `_Windows`. quadratic : (p, g), whose product with the products of these pairs is the square of what is new
    over its variance. log_size : (g,) of this variance.
    """

    pairs: NDArray[np.intp]
    quadratic: Array
    log_size: Array


@cache
def _newness(reach: int, held: int, contrasts: bool) -> _Newness:
    """With samples at these places: a sample minus its best linear prediction.

    Of contrasts, the coefficients of the prediction add up to one (ordinary kriging: Cressie 1993); one sample alone tells nothing.
    """
    back = np.array([0, *(place for place in range(1, reach + 1) if held & (1 << (place - 1)))])
    apart = np.abs(back[:, None] - back)
    memory, white = _MEMORIES[:, None, None, None], _WHITE[None, :, None, None]
    noise = ((1.0 - white) * memory**apart + white * (apart == 0)).reshape(-1, len(back), len(back))
    n, size = len(back) - 1, len(back) - 1 + contrasts
    left, right = np.ones((len(noise), size, size)), np.ones((len(noise), size, 1))
    left[:, :n, :n], left[:, n:, n:], right[:, :n, 0] = noise[:, 1:, 1:], 0.0, noise[:, 1:, 0]
    ahead = np.ones((len(noise), n + 1))
    ahead[:, 1:] = -np.linalg.solve(left, right)[:, :n, 0]
    variance = np.einsum("gi,gij,gj->g", ahead, noise, ahead)
    i, j = np.triu_indices(n + 1)
    quadratic = (np.where(i == j, 1.0, 2.0) * ahead[:, i] * ahead[:, j] / variance[:, None]).T
    pairs = back[i] * (2 * reach + 1 - back[i]) // 2 + back[j]
    return _Newness(pairs, quadratic, np.log(variance))
