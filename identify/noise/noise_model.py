"""The noise of a channel: a part with a short memory, a white part, heavy tails; what makes its samples independent; how it is estimated.

    E[r_i r_j] = s^2 ((1 - omega) rho^d + omega [i = j]),    innovations Student t with 5 degrees of freedom

d is how many samples i and j are apart (a missing frame counts), omega the white share of the variance s^2. The memory is
bounded: noise that remembers longer than a few samples cannot be told from a missing effect, and would swallow one. Memory and white share
are those under which each sample is predicted best from those of the few places before it that hold one (`windows`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import special

from identify.criteria import DEGREES
from identify.noise.windows import Taken, Windows, likeliest
from measure.common.arrays import Array

SMALLEST_SCALE = 0.3  # of the noise that the fast part of a channel shows
_ROUNDS = 4
_PER_SIGMA = 1.4826
_REACH, _OF_CONTRASTS = 5, 8  # samples before one from which it is predicted; contrasts tell less of what is slow
_PIECE, _LOUD = 30, 2.0  # samples of a piece, and how many times the usual power of a piece is no noise
_LOG_T = float(special.gammaln((DEGREES + 1.0) / 2.0) - special.gammaln(DEGREES / 2.0) - 0.5 * np.log(DEGREES * np.pi))


@dataclass(frozen=True)
class ChannelNoise:
    """The noise of one run and channel.

    memory : correlation of neighbouring samples of the part that remembers, negative where they alternate. white : share of the variance
    that does not remember. scale : of the noise, in units of its sigma.
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
    factor of the covariance of both parts once the memory is taken out, when only neighbours are correlated; the first row is its diagonal.
    """

    kept: Array
    size: Array
    tied: Array

    @classmethod
    def of(cls, noise: ChannelNoise, apart: Array) -> Whitening:
        """For samples that stand `apart` (n,) from the one before; the first has none, which is infinitely far."""
        return cls(*_factors(noise.memory, noise.white if noise.memory != 0.0 else 0.0, noise.scale, apart))

    def whitened(self, values: Array) -> Array:
        """Innovations over their scales of a residual (n,), or of columns (n, k)."""
        return _innovations(np.ascontiguousarray(values).reshape(len(values), -1), self.kept, self.size, self.tied).reshape(values.shape)

    @property
    def log_size(self) -> float:
        """Sum of the logarithms of the scales, what whitening takes off a log likelihood."""
        return float(np.sum(np.log(self.size * self.tied[0])))


@njit(cache=True, error_model="numpy")
def _factors(memory: float, white: float, scale: float, apart: Array) -> tuple[Array, Array, Array]:
    """What is kept, the sizes and the factor of `Whitening`."""
    kept, unit, tied = np.empty(len(apart)), np.empty(len(apart)), np.zeros((2, len(apart)))
    for i in range(len(apart)):
        if i > 0 and apart[i] == apart[i - 1]:
            kept[i], unit[i] = kept[i - 1], unit[i - 1]
        else:
            kept[i] = memory ** apart[i]
            unit[i] = np.sqrt(1.0 - kept[i] ** 2)
        if i > 2 and apart[i] == apart[i - 1] == apart[i - 2] and tied[0, i - 1] == tied[0, i - 2]:  # it changes no more
            tied[0, i], tied[1, i - 1] = tied[0, i - 1], tied[1, i - 2]
            continue
        tied[0, i] = 1.0 - white + white * (1.0 + kept[i] ** 2) / unit[i] ** 2
        if i > 0:
            tied[1, i - 1] = -white * kept[i] / (unit[i] * unit[i - 1] * tied[0, i - 1])
            tied[0, i] -= tied[1, i - 1] ** 2
        tied[0, i] = np.sqrt(tied[0, i])
    return kept, scale * unit, tied


@njit(cache=True, error_model="numpy")
def _innovations(values: Array, kept: Array, size: Array, tied: Array) -> Array:
    """What is new in each sample of columns (n, k), over its scale."""
    out = np.empty(values.shape)
    for i in range(len(values)):
        unit = 1.0 / (size[i] * tied[0, i])
        for k in range(values.shape[1]):
            out[i, k] = unit * values[i, k]
        if i > 0:
            remembered, shared = unit * kept[i], tied[1, i - 1] / tied[0, i]
            for k in range(values.shape[1]):
                out[i, k] -= remembered * values[i - 1, k] + shared * out[i - 1, k]
    return out


def spacing(samples: NDArray[np.intp]) -> Array:
    """How many samples each stands behind the one before, (n,), from their indices; infinity for the first."""
    return np.concatenate([[np.inf], np.diff(samples).astype(float)])[: len(samples)]


@njit(cache=True)
def places_of(apart: Array) -> NDArray[np.intp]:
    """The place of each sample in its run, (n,), from its `spacing`; the first one stands at zero."""
    places, place = np.empty(len(apart), dtype=np.intp), 0
    for i in range(len(apart)):
        place += int(apart[i]) if np.isfinite(apart[i]) else 0
        places[i] = place
    return places


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
    placed = Taken(taken.count, _placed(places, taken.columns), _placed(places, taken.spread))
    windows = Windows.of(_placed(places, residual), _placed(places, trusted), _REACH, placed)
    memory, white, _ = likeliest(windows, len(residual))
    unit = ChannelNoise(memory, white).whitened(residual, apart)
    trusted = weights(unit / noise.scale)
    scale = float(np.sqrt(share * (trusted @ unit**2) / trusted.sum()))  # settles sooner than a sum over n (Kent 1994)
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
    found = Windows.together([Windows.of(values, told, _OF_CONTRASTS) for values, told in placed])
    memory, white, square = likeliest(found, int(sum(map(np.sum, quiet))), contrasts=True)
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
