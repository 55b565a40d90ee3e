"""The noise of a channel: a part with a short memory, a white part, heavy tails; estimated from what a fit leaves.

    E[r_i r_j] = s^2 ((1 - omega) rho^d + omega [i = j]),    innovations Student t with 5 degrees of freedom

d is how many samples i and j are apart (a missing frame counts), omega the white share of the variance s^2. The memory is bounded: noise
that remembers longer than a few samples cannot be told from a missing effect, and would swallow one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
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
_STRETCH, _OF_DIFFERENCES = 5, 8  # how far apart the samples of a pair are at most; differences tell less of what is slow
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
    values, count, columns, spread = (_placed(places, of) for of in (residual, trusted, taken.columns, taken.spread))
    pairs = _Pairs.of(values, count, columns, spread, _STRETCH)
    memory, white, _ = _likeliest(pairs.products, len(residual), _stretches(_STRETCH))
    unit = ChannelNoise(memory, white).whitened(residual, apart)
    scale = float(np.sqrt(share * np.mean(weights(unit / noise.scale) * unit**2)))
    return ChannelNoise(memory, white, max(scale, SMALLEST_SCALE))


def from_differences(runs: Iterable[tuple[Array, Array]]) -> ChannelNoise:
    """The noise of a channel from the differences of neighbouring samples, in which a slow gap hardly shows.

    Noise is equally loud everywhere. Pieces that are louder than most hold a gap that is quick for a while, as behind a stop; they are left
    out.

    Parameters
    ----------
    runs : of each run what is left (n,), and how far its samples stand apart, see `spacing`.
    """
    steps = [_steps(*run) for run in runs]
    powers = [_powers(values, there) for values, there in steps]
    moving = np.concatenate([power[power > 0.0] for power in powers])
    if not len(moving):
        return ChannelNoise(scale=0.0)
    limit = _LOUD * float(np.median(moving))
    product, count = np.zeros((2, _OF_DIFFERENCES + 1))
    for (values, there), power in zip(steps, powers, strict=True):
        quiet = there * np.repeat(power <= limit, _PIECE)[: len(there)]
        nothing = np.empty((len(values), 0))
        pairs = _Pairs.of(values, quiet, nothing, nothing, _OF_DIFFERENCES)
        product, count = product + pairs.product, count + pairs.count
    memory, white, square = _likeliest(_Pairs(product, count).products, int(count[0]), _stretches(_OF_DIFFERENCES, differences=True))
    return ChannelNoise(memory, white, float(np.sqrt(square)))


def _steps(gaps: Array, apart: Array) -> tuple[Array, Array]:
    """Differences of neighbouring samples, (n,), and one where there are both of them, else nought."""
    places = places_of(apart)
    values, there = _placed(places, gaps), _placed(places, np.ones(len(gaps)))
    both = there[1:] * there[:-1]
    return both * np.diff(values), both


def _powers(values: Array, there: Array) -> Array:
    """Mean square of the values of each piece, zero of one that is empty."""
    starts = np.arange(0, len(values), _PIECE)
    if not len(starts):
        return np.zeros(0)
    count, square = np.add.reduceat(there, starts), np.add.reduceat(values**2, starts)
    return square / np.maximum(count, 1.0)


@dataclass(frozen=True)
class _Pairs:
    """Pairs of samples 0, 1, ... apart: their products added up as far as both samples are trusted, and so their number, (d,)."""

    product: Array
    count: Array

    @classmethod
    def of(cls, values: Array, trusted: Array, columns: Array, spread: Array, farthest: int) -> _Pairs:
        """Of a run's samples (n,), each trusted (n,) so much, those that are not there not at all, with what was `Taken` given back."""
        product, count = np.zeros((2, farthest + 1))
        for d in range(min(farthest + 1, len(values))):
            later, earlier = slice(d, None), slice(0, len(values) - d)
            both = np.minimum(trusted[later], trusted[earlier])
            given = np.einsum("ij,ij->i", spread[later], columns[earlier])
            product[d], count[d] = both @ (values[later] * values[earlier] + given), np.sum(both)
        return cls(product, count)

    @property
    def products(self) -> Array:
        """Their mean product."""
        return self.product / np.maximum(self.count, 1e-300)


def _placed(places: NDArray[np.intp], values: Array) -> Array:
    """Samples (n, ...) at their places in a run without holes; nothing in between."""
    if places[-1] + 1 == len(places):
        return values
    out = np.zeros((places[-1] + 1, *values.shape[1:]))
    out[places] = values
    return out


@dataclass(frozen=True)
class _Stretches:
    """For each memory and white share, (g,): what stretches of noise of variance one look like.

    quadratic : (g, d), whose product with those of pairs is the square of an innovation over its size. log_size : of these
    squares. unlikely : minus the logarithm of the prior.
    """

    quadratic: Array
    log_size: Array
    unlikely: Array


@cache
def _stretches(farthest: int, differences: bool = False) -> _Stretches:
    """Of samples 0 to `farthest` of the noise, or of its differences.

    Noise is taken for as many times less likely beforehand as it makes the variance of a mean over many samples larger than white noise
    does: a memory that the samples do not show is none.
    """
    quadratic, log_size, unlikely = [], [], []
    for memory in _MEMORIES:
        for white in _WHITE:
            own = (1.0 - white) * memory ** np.arange(farthest + 2.0)
            own[0] = 1.0
            seen = 2.0 * own[:-1] - own[1:] - np.concatenate([own[1:2], own[:-2]]) if differences else own[:-1]
            ahead = np.concatenate([[1.0], -linalg.solve_toeplitz(seen[:-1], seen[1:])])
            size, at_once = float(ahead @ seen), np.correlate(ahead, ahead, "full")[farthest:]
            quadratic.append(np.concatenate([at_once[:1], 2.0 * at_once[1:]]) / size)
            log_size.append(np.log(size))
            unlikely.append(np.log(white + (1.0 - white) * (1.0 + memory) / (1.0 - memory)))
    return _Stretches(np.array(quadratic), np.array(log_size), np.array(unlikely))


def _likeliest(products: Array, count: int, of: _Stretches) -> tuple[float, float, float]:
    """Memory and white share under which stretches whose pairs have such products are likeliest, and the variance of the noise."""
    square = np.maximum(of.quadratic @ products, 1e-300)
    best = int(np.argmin(0.5 * count * (np.log(square) + of.log_size) + of.unlikely))
    memory, white = np.unravel_index(best, (len(_MEMORIES), len(_WHITE)))
    return float(_MEMORIES[memory]), float(_WHITE[white]), float(square[best])
