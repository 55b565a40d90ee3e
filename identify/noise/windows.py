"""Which memory and white share suit the samples of a run: each is predicted from those of the few places before it that hold one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from measure.common.arrays import Array

LONGEST_MEMORY = 0.85
_MEMORIES, _WHITE = np.linspace(0.0, LONGEST_MEMORY, 35), np.linspace(0.0, 0.95, 20)
_OF_EITHER_SIGN = np.concatenate([-_MEMORIES[12:0:-1], _MEMORIES])  # noise may alternate from sample to sample


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


@dataclass(frozen=True)
class Windows:
    """Samples, each with those up to `reach` places before it, put together by which of these places hold a sample.

    held : (p,) the places 1 to reach before the sample, as bits of a number. count : (p,) of the samples, as far as they are trusted.
    products : (p, k) as many times the mean product of the values at two places 0 to reach before it, in the order of `numpy.triu_indices`.
    """

    reach: int
    held: NDArray[np.intp]
    count: Array
    products: Array

    @classmethod
    def of(cls, values: Array, trust: Array, reach: int, taken: Taken | None = None) -> Windows:
        """Of samples (n,) at places without holes, each trusted (n,) so much, those that are not there not at all.

        A pair counts with the smaller trust of its two samples. What a fit has taken is given back to the products.
        """
        groups, taken = _grouped((trust > 0.0).tobytes(), reach), taken or Taken.nothing(len(values))
        pairs = _pairs(values, trust, taken.columns, taken.spread, reach)
        return cls(reach, groups.held, *_by_group(trust, *pairs, groups.stops, groups.samples, groups.pairs))

    @classmethod
    def together(cls, parts: Sequence[Windows]) -> Windows:
        """Those of several runs."""
        held, place = np.unique(np.concatenate([one.held for one in parts]), return_inverse=True)
        count, products = np.zeros(len(held)), np.zeros((len(held), parts[0].products.shape[1]))
        np.add.at(count, place, np.concatenate([one.count for one in parts]))
        np.add.at(products, place, np.concatenate([one.products for one in parts]))
        return cls(parts[0].reach, held, count, products)


@dataclass(frozen=True)
class _Groups:
    """Windows of a run put together by which places before their sample hold one.

    held : (p,) these places, as bits of a number. stops : (p,) the end of each group. samples : (m,) of each window, group by group.
    pairs : (m, k) where in (reach + 1, n), laid flat, each of its pairs stands: how many places apart, and the later place.
    """

    held: NDArray[np.intp]
    stops: NDArray[np.intp]
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
    groups, counts = np.unique(held[samples], return_counts=True)
    later, earlier = np.triu_indices(reach + 1)
    pairs = (earlier - later) * n + np.maximum(samples[:, None] - later, 0)  # a pair that reaches before the first place never counts
    return _Groups(groups, np.cumsum(counts), samples, pairs)


@njit(cache=True, error_model="numpy", fastmath={"reassoc"})
def _pairs(values: Array, trust: Array, columns: Array, spread: Array, reach: int) -> tuple[Array, Array]:
    """Product, with what a fit has taken, times weight of each pair, and the weights, by how far apart and the later place, laid flat."""
    n, k = columns.shape
    products, weights = np.zeros((reach + 1) * n), np.zeros((reach + 1) * n)
    for later in range(n):
        for apart in range(min(reach, later) + 1):
            earlier, at, product = later - apart, apart * n + later, 0.0
            for i in range(k):
                product += spread[later, i] * columns[earlier, i]
            weights[at] = min(trust[later], trust[earlier])
            products[at] = weights[at] * (values[later] * values[earlier] + product)
    return products, weights


@njit(cache=True, error_model="numpy")
def _by_group(
    trust: Array, products: Array, weights: Array, stops: NDArray[np.intp], samples: NDArray[np.intp], pairs: NDArray[np.intp]
) -> tuple[Array, Array]:
    """Count and products of `Windows`, from what the samples (n,) and their pairs count."""
    count, sums, start = np.zeros(len(stops)), np.zeros((len(stops), pairs.shape[1])), 0
    for group in range(len(stops)):
        whole = np.zeros(pairs.shape[1])
        for window in range(start, stops[group]):
            count[group] += trust[samples[window]]
            for k in range(pairs.shape[1]):
                sums[group, k] += products[pairs[window, k]]
                whole[k] += weights[pairs[window, k]]
        sums[group] *= count[group] / np.maximum(whole, 1e-300)
        start = stops[group]
    return count, sums


def likeliest(found: Windows, samples: int, contrasts: bool = False) -> tuple[float, float, float]:
    """Memory and white share under which the windows of so many samples are likeliest, and the variance of the noise.

    Noise is taken for as many times less likely beforehand as it makes the variance of a mean over many samples larger than white noise
    does, or smaller: a memory that the samples do not show is none.

    contrasts : whether only the differences of samples count, in which what is slow hardly shows; a sample alone has none. A memory may
        then be negative: cut off at nought, that of white noise is found too large on the average.
    """
    told = np.flatnonzero((found.count > 0.0) & ((found.held > 0) | (not contrasts)))
    count, products, new = found.count[told], found.products[told], _newness_of(found.reach, found.held[told].tobytes(), contrasts)
    best, square = _best(count, products.ravel(), new.pairs, new.quadratic, new.log_size, samples, _unlikely(contrasts))
    return float(_memories(contrasts)[best // len(_WHITE)]), float(_WHITE[best % len(_WHITE)]), square


@njit(cache=True, error_model="numpy")
def _best(
    count: Array, products: Array, pairs: NDArray[np.intp], quadratic: Array, log_size: Array, samples: int, unlikely: Array
) -> tuple[int, float]:
    """Which memory and white share is likeliest, and the variance of the noise with it."""
    squares, sizes, whole = np.zeros(len(unlikely)), np.zeros(len(unlikely)), max(np.sum(count), 1e-300)
    for row in range(len(pairs)):
        product = products[pairs[row]] / whole
        for at in range(len(unlikely)):
            squares[at] += product * quadratic[row, at]
    for row in range(len(count)):
        share = count[row] / whole
        for at in range(len(unlikely)):
            sizes[at] += share * log_size[row, at]
    squares = np.maximum(squares, 1e-300)
    best = np.argmin(0.5 * samples * (np.log(squares) + sizes) + unlikely)
    return int(best), squares[best]


def _memories(contrasts: bool) -> Array:
    return _OF_EITHER_SIGN if contrasts else _MEMORIES


@cache
def _unlikely(contrasts: bool) -> Array:
    """Minus the logarithm of the prior of each memory and white share, (g,)."""
    memory, white = _memories(contrasts)[:, None], _WHITE[None, :]
    return np.abs(np.log(white + (1.0 - white) * (1.0 + memory) / (1.0 - memory))).ravel()


@dataclass(frozen=True)
class _Newness:
    """What is new in a sample beside those before it, for each memory and white share (g,), in noise of variance one.

    pairs : (p,) of places, of `Windows`. quadratic : (p, g), whose product with the products of these pairs is the square of what is new
    over its variance. log_size : (g,) of this variance. Of several groups of windows all pairs follow each other, and log_size is (h, g).
    """

    pairs: NDArray[np.intp]
    quadratic: Array
    log_size: Array


@lru_cache(maxsize=16)
def _newness_of(reach: int, held: bytes, contrasts: bool) -> _Newness:
    """Of groups of windows, whose pairs stand in their products (h, k), laid flat."""
    found = [_newness(reach, int(one), contrasts) for one in np.frombuffer(held, dtype=np.intp)]
    wide, none = (reach + 1) * (reach + 2) // 2, np.empty((0, len(_memories(contrasts)) * len(_WHITE)))
    pairs = [one.pairs + wide * row for row, one in enumerate(found)]
    quadratic, log_size = [one.quadratic for one in found], [one.log_size for one in found]
    return _Newness(np.concatenate([np.empty(0, dtype=np.intp), *pairs]), np.vstack([none, *quadratic]), np.vstack([none, *log_size]))


@cache
def _newness(reach: int, held: int, contrasts: bool) -> _Newness:
    """With samples at these places: a sample minus its best linear prediction.

    Of contrasts, the coefficients of the prediction add up to one (ordinary kriging: Cressie 1993); one sample alone tells nothing.
    """
    back = np.array([0, *(place for place in range(1, reach + 1) if held & (1 << (place - 1)))])
    apart = np.abs(back[:, None] - back)
    memory, white = _memories(contrasts)[:, None, None, None], _WHITE[None, :, None, None]
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
