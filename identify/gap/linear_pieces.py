"""A fit as linear pieces: what is left in each channel, and what parameters, errors of the model file and a hypothesis change there.

What columns bring with the noise as it is takes one small system, for any prior that they are given:

    S = I + T^-2        gain = g' S^-1 g / 2 - ln det(S) / 2 - ln det(T)

I their information with nothing known of them, g the slope of the log likelihood with them, T the spread of their prior.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import special

from measure.common.arrays import Array

_LEAST_WIDTH = 1e-10  # eigenvalue of a matrix with ones on its diagonal; what is less is rounding
_FADED = 3.0  # times that noise which remembers, for it has taken up what is missing, makes a slow effect look too weak


@dataclass(frozen=True)
class Channel:
    """Rows of one run and channel, and how many samples apart neighbours stand, see `noise_model.spacing`."""

    rows: slice
    apart: Array


@dataclass(frozen=True)
class Columns:
    """What a hypothesis adds: columns (m, k) to the gaps, one typical size each.

    spread : (k,) standard deviations of their priors. at : (k,) amounts at which the columns were taken, zero as a rule.
    low, high : (k,) bounds of the amounts.
    """

    values: Array
    spread: Array
    at: Array
    low: Array
    high: Array

    @classmethod
    def free(cls, values: Array, spread: float) -> Columns:
        """Without bounds, from zero, all of one spread."""
        k = values.shape[1]
        return cls(values, np.full(k, spread), np.zeros(k), np.full(k, -np.inf), np.full(k, np.inf))

    @classmethod
    def none(cls, rows: int) -> Columns:
        """Nothing."""
        return cls.free(np.empty((rows, 0)), 1.0)

    @property
    def count(self) -> int:
        """How many there are."""
        return self.values.shape[1]

    @property
    def is_bounded(self) -> bool:
        """Whether any of the amounts has a bound."""
        return bool(np.any(np.isfinite([self.low, self.high])))

    def log_inside(self, amounts: Array, deviation: Array) -> float:
        """What the bounds do to a log evidence: the share of the posterior inside over that of the prior, amount by amount.

        amounts, deviation : (k,) of the posterior without bounds.
        """
        after = _log_share((self.low - amounts) / deviation, (self.high - amounts) / deviation)
        before = _log_share(self.low / self.spread, self.high / self.spread)
        return float(np.sum(after - before))

    def beside(self, other: Columns) -> Columns:
        """These and others, side by side."""
        pairs = ((getattr(self, name), getattr(other, name)) for name in ("spread", "at", "low", "high"))
        return Columns(np.hstack([self.values, other.values]), *(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True)
class Gain:
    """Log evidence that columns bring, and the most that they may bring once the noise is estimated anew.

    amounts : (k,) and covariance : (k, k) of the columns themselves.
    """

    log_z: float
    most: float
    amounts: Array
    covariance: Array
    columns: Columns


@dataclass(frozen=True)
class Shown:
    """What measurements say of columns: their information (k, k), all else integrated out, and the slope (k,) of the log likelihood."""

    information: Array
    slope: Array

    def of(self, part: int, count: int) -> Shown:
        """The same of one part of them, where they are parts of `count` columns each."""
        own = slice(part * count, (part + 1) * count)
        return Shown(self.information[own, own], self.slope[own])

    def gain(self, columns: Columns) -> Gain:
        """What these columns bring with their prior, from nought."""
        rest = self.information + np.diag(columns.spread**-2.0)
        size = np.sqrt(np.maximum(np.diag(rest), 1e-300))
        widths, ways = np.linalg.eigh(rest / np.outer(size, size))
        widths = np.maximum(widths, _LEAST_WIDTH)
        covariance = (ways / widths) @ ways.T / np.outer(size, size)
        amounts = covariance @ self.slope
        log_det = float(np.sum(np.log(widths)) + 2.0 * np.sum(np.log(size)))
        met = 0.5 * float(self.slope @ covariance @ self.slope)
        price = 0.5 * log_det + float(np.sum(np.log(columns.spread)))
        cut = columns.log_inside(amounts, np.sqrt(np.diag(covariance))) if columns.is_bounded else 0.0
        return Gain(met - price + cut, _FADED * met - price + max(cut, 0.0), amounts, covariance, columns)


@dataclass(frozen=True)
class Lines:
    """A fit as linear pieces: gaps (m,), columns (m, p) of base and releases, errors (m, q) of the model file in tolerances.

    errors_at : (q,) sizes of the errors at which all is taken. prior_gaps, prior_columns : (r,), (r, p) what is known of base and releases
    beforehand, in standard deviations. log_spread : sum of the logarithms of these, in scales.
    """

    gaps: Array
    columns: Array
    errors: Array
    errors_at: Array
    prior_gaps: Array
    prior_columns: Array
    channels: tuple[Channel, ...]
    log_spread: float = 0.0

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """Channel by channel, without the columns that do nothing there: a release moves its own film only."""
        values = np.hstack([self.columns, self.errors])
        return tuple(Part.of(channel, self.gaps, values[channel.rows]) for channel in self.channels)

    def parts_beside(self, own: Columns) -> list[Part]:
        """Channel by channel with the columns of a hypothesis."""
        return [part.beside(own, self.count) for part in self.parts] if own.count else list(self.parts)

    def prior_precision(self, own: Columns) -> Array:
        """What is known beforehand of base and releases, errors and amounts, (p + q + k, p + q + k)."""
        p, n = self.columns.shape[1], self.count + own.count
        precision = np.zeros((n, n))
        precision[:p, :p] = self.prior_columns.T @ self.prior_columns
        rest = np.arange(p, n)
        precision[rest, rest] = np.concatenate([np.ones(self.count - p), own.spread**-2.0])
        return precision

    def prior_pull(self, own: Columns) -> Array:
        """The slope of what is known beforehand where the columns were taken, (p + q + k,)."""
        return np.concatenate([self.prior_columns.T @ self.prior_gaps, self.errors_at, own.at / own.spread**2])

    @property
    def count(self) -> int:
        """How many columns there are."""
        return self.columns.shape[1] + self.errors.shape[1]

    def shifted(self, shift: Array | float) -> Lines:
        """With other gaps: something (m,) is added to them."""
        return replace(self, gaps=self.gaps + shift) if np.any(shift) else self


@dataclass(frozen=True)
class Part:
    """One channel: gaps (n,), the columns (n, k) that do something there, and which these are (k,)."""

    channel: Channel
    gaps: Array
    values: Array
    places: NDArray[np.intp]

    @classmethod
    def of(cls, channel: Channel, gaps: Array, values: Array) -> Part:
        """Of all gaps, and the columns in this channel."""
        places = np.flatnonzero(np.any(values != 0.0, axis=0))
        return cls(channel, gaps[channel.rows], np.ascontiguousarray(values[:, places]), places)

    def beside(self, own: Columns, first: int) -> Part:
        """With the columns of a hypothesis, which stand from `first` on."""
        values = own.values[self.channel.rows]
        more = np.flatnonzero(np.any(values != 0.0, axis=0))
        return Part(self.channel, self.gaps, np.hstack([self.values, values[:, more]]), np.concatenate([self.places, first + more]))

    def residual(self, step: Array) -> Array:
        """Gaps after a step of all columns, (n,)."""
        return self.gaps + self.values @ step[self.places]


def _log_share(low: Array, high: Array) -> Array:
    """Logarithm of the part of a standard normal between two ends, without loss far out."""
    mirrored = low > 0.0
    a, b = np.where(mirrored, -high, low), np.where(mirrored, -low, high)
    upper, lower = special.log_ndtr(b), special.log_ndtr(a)
    return upper + np.log1p(-np.exp(np.minimum(lower - upper, -1e-16)))
