"""Covariance of least squares whose residuals are neither white nor independent: the sandwich, each block with its own spectrum."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import linalg, optimize

from measure.common.arrays import Array

_JITTER = 1e-10  # of a diagonal of one: rounding leaves a matrix positive
_SAME = 1e-8  # of a length, which is the same within this
_REACH = 6  # frequencies of a doubled transform, half as many independent ones


def sandwich(jacobian: Array, gaps: Array, blocks: Sequence[slice], free: NDArray[np.bool_]) -> Array:
    """Covariance (k, k) of the parameters, in the scale of the columns.

        C = H^-1 (sum_b J_b' W_b J_b + J_p' J_p) H^-1,   H = J'J

    W_b is the covariance of the noise of block b, a loop or a channel of a deployment. It is taken as stationary, from the smoothed
    spectrum of the block's own gap, so that a slow drift makes levels uncertain and leaves beta, which the reversals tell, nearly
    as it was; and never below the noise of the samples, one in the units of the gaps. J_p are the rows of the priors.
    A parameter at a bound is no error of the others; its own variance is what it would have off the bound.

    Parameters
    ----------
    jacobian : (m, k). gaps : (m,) in units of the noise. blocks : rows of each block; what is behind the last of them are priors.
    free : (k,) which parameters stand clear of their bounds.
    """
    inside = _sandwich(jacobian, gaps, blocks, free)
    if not np.all(free):
        whole = _sandwich(jacobian, gaps, blocks, np.ones_like(free))
        held = np.flatnonzero(~free)
        inside[held, held] = np.diag(whole)[held]
    return inside


def _sandwich(jacobian: Array, gaps: Array, blocks: Sequence[slice], kept: NDArray[np.bool_]) -> Array:
    table, size = scaled(jacobian[:, kept])
    middle, measured = np.zeros((table.shape[1],) * 2), max((rows.stop for rows in blocks), default=0)
    for rows in blocks:
        if rows.stop > rows.start:
            middle += scatter(table[rows], gaps[rows])
    counted = int(np.count_nonzero(np.linalg.norm(table[:measured], axis=0) > 0.0))
    middle *= measured / max(measured - counted, 1)
    middle += table[measured:].T @ table[measured:]
    inverse = inverse_of(table.T @ table)
    whole = np.zeros((jacobian.shape[1],) * 2)
    whole[np.ix_(kept, kept)] = inverse @ middle @ inverse / np.outer(size, size)
    return whole


def shift_of(jacobian: Array, change: Array, free: NDArray[np.bool_]) -> Array:
    """By how much parameters (k,) bend where the gaps are wrong by a change (m,); zero for those at a bound."""
    table, size = scaled(jacobian[:, free])
    whole = np.zeros(jacobian.shape[1])
    whole[free] = -inverse_of(table.T @ table) @ (table.T @ change) / size
    return whole


def scaled(table: Array) -> tuple[Array, Array]:
    """Columns of unit length, and what their lengths were; a column of zeros stays and counts as of length one."""
    size = np.sqrt(np.sum(table**2, axis=0))
    size = np.where(size > 0.0, size, 1.0)
    return table / size, size


def inverse_of(normal: Array) -> Array:
    """Pseudo-inverse of the normal matrix of columns of unit length."""
    return np.linalg.pinv(normal, rcond=1e-13, hermitian=True)


def scatter(table: Array, gap: Array) -> Array:
    """J' W J of one block, (k, k), from the spectra of its columns (n, k) and of its gap (n,); W is never below one."""
    n = len(gap)
    waves = np.fft.rfft(table, 2 * n, axis=0)
    power = smoothed_power(gap)
    power *= max(1.0, 1.0 / max(float(np.mean(gap**2)), 1e-12))
    weight = np.where((np.arange(n + 1) == 0) | (np.arange(n + 1) == n), 1.0, 2.0) * power / (2 * n)
    return np.real((waves * weight[:, None]).conj().T @ waves)


def smoothed_power(gap: Array) -> Array:
    """Power of a gap (sine taper) at the n + 1 frequencies of a transform of twice its length; its mean is the variance.

    Each value is the mean over a neighbourhood of at least four independent frequencies and a fifth of the frequency itself,
    because a fit has taken out of its gap what its own parameters can imitate at just their frequencies. A neighbourhood
    is averaged over its upper and lower side, and the larger mean counts.
    """
    n = len(gap)
    taper = np.sin(np.pi * (np.arange(n) + 0.5) / n)
    power = np.abs(np.fft.rfft(gap * taper, 2 * n)) ** 2 / np.sum(taper**2)
    total = np.concatenate([[0.0], np.cumsum(power)])
    k = np.arange(n + 1)
    reach = np.maximum(_REACH, k // 5)
    below, above = np.maximum(k - reach, 0), np.minimum(k + reach + 1, n + 1)
    lower = (total[k + 1] - total[below]) / (k + 1 - below)
    upper = (total[above] - total[k]) / (above - k)
    both = (total[above] - total[below]) / (above - below)
    return np.where(k < reach, np.maximum(both, np.minimum(lower, upper)), both)


def clipped(gaps: Array, blocks: Sequence[slice]) -> Array:
    """Gaps cut off at three robust standard deviations of all blocks, for a covariance that outliers do not make."""
    measured = max((rows.stop for rows in blocks), default=0)
    most = 3.0 * 1.4826 * float(np.median(np.abs(gaps[:measured])))
    return np.concatenate([np.clip(gaps[:measured], -most, most), gaps[measured:]])


def own_shares(table: Array) -> Array:
    """Which share of each parameter's signature no combination of the others can imitate, (k,), 0 to 1.

    A hub's inertia in sinusoids of one frequency, for one, looks like a slope of both asymptotes: its share is zero, and
    whatever value a fit returns for it is an accident of the noise.

    Parameters
    ----------
    table : (m, k) what the parameters do to the gaps.
    """
    known = np.any(table != 0.0, axis=0)
    shares = np.zeros(table.shape[1])
    columns, _ = scaled(table[:, known])
    shares[known] = 1.0 / np.sqrt(np.maximum(np.diag(inverse_of(columns.T @ columns)), 1.0))
    return shares


def within_bounds(step: Array, covariance: Array, low: Array, high: Array) -> Array:
    """The likeliest step (k,) within bounds, from that without: what leaves them is held there, the rest follows as it is correlated.

    An amplitude and a direction may stand in for each other; were one of them cut alone, a step would lead nowhere.
    """
    held, found = np.zeros(len(step), bool), step
    while True:
        out = ~held & ((found < low) | (found > high))
        if not out.any():
            return np.clip(found, low, high)
        held |= out
        moved = np.clip(step[held], low[held], high[held]) - step[held]
        found = step + covariance[:, held] @ np.linalg.lstsq(covariance[np.ix_(held, held)], moved, rcond=None)[0]


@njit(cache=True)
def add_at(places: NDArray[np.intp], whole: Array, part: Array) -> None:
    """Add a matrix (k, k) to some rows and the same columns, (k,), of a whole one (n, n), in place."""
    for i in range(len(places)):
        for j in range(len(places)):
            whole[places[i], places[j]] += part[i, j]


@dataclass(frozen=True)
class Factored:
    """A symmetric positive matrix, scaled by its diagonal and decomposed by Cholesky. root : (n, n), lower. size : (n,) of the scaling."""

    root: Array
    size: Array

    @classmethod
    def of(cls, matrix: Array) -> Factored:
        """Decompose."""
        size = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
        return cls(linalg.cholesky(matrix / np.outer(size, size) + _JITTER * np.eye(len(size)), lower=True), size)

    def solve(self, right: Array) -> Array:
        """The inverse times a vector (n,) or a matrix (n, k)."""
        scaled = (right.T / self.size).T
        return (np.asarray(linalg.cho_solve((self.root, True), scaled)).T / self.size).T

    @property
    def inverse(self) -> Array:
        """The inverse, (n, n)."""
        return self.solve(np.eye(len(self.size)))

    def over(self, vector: Array) -> float:
        """The square of a vector (n,) in the measure of the matrix, v' M v."""
        return float(np.sum((self.root.T @ (self.size * vector)) ** 2))

    def length(self, step: Array) -> float:
        """Length of a step (n,), each number in units of what the matrix says of it by itself."""
        return float(np.linalg.norm(self.size * step))

    def shortened(self, step: Array, length: float) -> Array:
        """Of all steps (n,) that are no longer than that, the one from which lines promise most (Moré 1978).

        The less the matrix says along a direction, the less is left of it. step : the best one of any length.
        """
        if length >= (1.0 - _SAME) * self.length(step):
            return step
        values, axes = self._axes
        along = axes.T @ (self.size * step)

        def left(log_damping: float) -> Array:
            return along * values / (values + np.exp(log_damping))

        low, high = np.log(_SAME**2 * values[0]), np.log(np.linalg.norm(along * values) / length)
        found = optimize.root_scalar(lambda at: np.log(np.linalg.norm(left(at)) / length), bracket=(low, high + 1.0), xtol=1e-3)
        return axes @ left(found.root) / self.size

    def ever_shorter(self, step: Array, promised: float, length: float) -> Iterator[tuple[float, Array]]:
        """Steps (n,) from a length on, each half as long as the one before, while they promise that; with the length of each.

        The first is longer where it promises less, but not longer than the whole step. promised : by how much v' M v is to fall.
        """
        whole, longest = self.over(step), self.length(step)
        length = min(length, longest) if whole >= promised else longest

        def promises(part: Array) -> bool:
            return whole - self.over(step - part) >= promised

        while length < longest and not promises(self.shortened(step, length)):
            length = min(2.0 * length, longest)
        while promises(part := self.shortened(step, length)):
            yield length, part
            length /= 2.0

    @cached_property
    def _axes(self) -> tuple[Array, Array]:
        """Eigenvalues (n,), the smallest first, and eigenvectors (n, n) of the scaled matrix."""
        values, axes = np.linalg.eigh(self.root @ self.root.T)
        return np.maximum(values, _JITTER), axes

    @property
    def log_det(self) -> float:
        """Logarithm of the determinant."""
        return 2.0 * float(np.sum(np.log(np.diag(self.root))) + np.sum(np.log(self.size)))
