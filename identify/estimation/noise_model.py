"""The noise of a channel: short memory, heavy tails, a scale of its own; estimated from what a fit leaves.

    r_i = rho^d r_(i-1) + e_i,    e_i / s_i  Student t with 5 degrees of freedom,    s_i^2 = s^2 (1 - rho^(2 d)) / (1 - rho^2)

d is how many samples apart two neighbours stand (a missing frame counts), s the scale of an innovation one sample apart. The
memory is bounded: noise that remembers longer than a few samples cannot be told from a missing effect, and would swallow one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from identify.criteria import DEGREES
from measure.common.arrays import Array

LARGEST_LAG1 = 0.85
SMALLEST_SCALE = 0.3  # of the noise that the fast part of a channel shows
_ROUNDS = 4
_PER_SIGMA = 1.4826
_LOG_T = float(special.gammaln((DEGREES + 1.0) / 2.0) - special.gammaln(DEGREES / 2.0) - 0.5 * np.log(DEGREES * np.pi))


@dataclass(frozen=True)
class ChannelNoise:
    """The noise of one run and channel. lag1 : correlation of neighbouring samples. scale : of an innovation, in units of its sigma."""

    lag1: float = 0.0
    scale: float = 1.0

    @property
    def sigma(self) -> float:
        """Standard deviation of the noise itself, of which an innovation is a part."""
        return self.scale * float(np.sqrt(DEGREES / (DEGREES - 2.0) / (1.0 - self.lag1**2)))

    def decay(self, apart: Array) -> tuple[Array, Array]:
        """rho^d and s_i (n,) for samples that stand `apart` (n,) from the one before; the first has none, which is infinitely far."""
        kept = self.lag1**apart
        return kept, self.scale * np.sqrt((1.0 - kept**2) / (1.0 - self.lag1**2))

    def whitened(self, values: Array, apart: Array) -> Array:
        """Innovations over their scales of a residual (n,), or of columns (n, k)."""
        kept, size = self.decay(apart)
        shape = (-1, *([1] * (values.ndim - 1)))
        out = values / size.reshape(shape)
        out[1:] -= (kept / size)[1:].reshape(shape) * values[:-1]
        return out

    def log_size(self, apart: Array) -> float:
        """Sum of the logarithms of the scales, what whitening takes off a log likelihood."""
        return float(np.sum(np.log(self.decay(apart)[1])))


def spacing(samples: NDArray[np.intp]) -> Array:
    """How many samples each stands behind the one before, (n,), from their indices; infinity for the first."""
    return np.concatenate([[np.inf], np.diff(samples).astype(float)])[: len(samples)]


def weights(innovations: Array) -> Array:
    """How much each whitened value counts under Student's t, (n,): one in the middle, little far out."""
    return (DEGREES + 1.0) / (DEGREES + innovations**2)


def log_likelihood(innovations: Array) -> float:
    """Of whitened values under Student's t of scale one."""
    return len(innovations) * _LOG_T - 0.5 * (DEGREES + 1.0) * float(np.sum(np.log1p(innovations**2 / DEGREES)))


@dataclass(frozen=True)
class Taken:
    """What a fit has taken from the noise of a channel: so many parameters, and with them mostly what was slow in it.

    variance : (n,) of what the fit makes of each sample. beside : (n,) its covariance with that of the sample before; of the first nought.
    """

    count: float
    variance: Array
    beside: Array

    @classmethod
    def nothing(cls, n: int) -> Taken:
        """By a fit that has no parameters here."""
        return cls(0.0, np.zeros(n), np.zeros(n))

    @classmethod
    def by(cls, columns: Array, covariance: Array, count: float) -> Taken:
        """By parameters of columns (n, k) and a covariance (k, k), of which these samples have determined so many."""
        spread = columns @ covariance
        beside = np.zeros(len(columns))
        beside[1:] = np.einsum("ij,ij->i", spread[1:], columns[:-1])
        return cls(count, np.einsum("ij,ij->i", spread, columns), beside)


def estimated(residual: Array, apart: Array, taken: Taken | None = None, start: ChannelNoise | None = None) -> ChannelNoise:
    """Memory and scale that suit a residual (n,) best, by a few rounds of reweighting (EM for Student's t).

    A residual is smaller than the noise by what a fit has taken from it, and forgets sooner: that is given back, so that the noise suits
    best with the parameters integrated out (restricted likelihood: Harville 1977).

    Parameters
    ----------
    apart : see `spacing`.
    start : noise that is nearly right, from which one round is enough.
    """
    taken = taken or Taken.nothing(len(residual))
    if len(residual) < 4:
        return ChannelNoise(0.0, max(1.0, float(np.sqrt(np.mean(residual**2))) if len(residual) else 1.0))
    share = len(residual) / max(len(residual) - taken.count, 0.5 * len(residual))
    noise = start or ChannelNoise(0.0, max(_PER_SIGMA * float(np.median(np.abs(residual))), SMALLEST_SCALE))
    for _ in range(_ROUNDS if start is None else 1):
        noise = _reestimated(noise, residual, apart, share, taken)
    return noise


def _reestimated(noise: ChannelNoise, residual: Array, apart: Array, share: float, taken: Taken) -> ChannelNoise:
    beside = np.flatnonzero(apart == 1.0)
    count = weights(noise.whitened(residual, apart))
    trusted = np.minimum(count[beside], count[beside - 1])
    power = float(np.sum(trusted * (residual[beside - 1] ** 2 + taken.variance[beside - 1])))
    product = float(np.sum(trusted * (residual[beside - 1] * residual[beside] + taken.beside[beside])))
    lag1 = float(np.clip(product / power if power > 0.0 else 0.0, 0.0, LARGEST_LAG1))
    unit = ChannelNoise(lag1, 1.0).whitened(residual, apart)
    scale = float(np.sqrt(share * np.mean(weights(unit / noise.scale) * unit**2)))
    return ChannelNoise(lag1, max(scale, SMALLEST_SCALE))
