"""How far standard deviations fall short of the marks' misfit to the body, frame by frame, and of the course of the pose.

The misfit of a frame is one draw of few degrees of freedom. Where all frames differ by chance only, they share one factor; where
some are worse (motion, compression, something in front), each has its own, known by its own marks. Where the misfit persists from
frame to frame (error of the reference image), many frames say no more than one. Student's t then takes the place of the normal.

Smyth, Linear models and empirical Bayes methods for assessing differential expression in microarray experiments, Statistical
Applications in Genetics and Molecular Biology 3 (2004) 3: variances of many small samples, moderated by each other. The derivation is
in docs/theory/image-correlation.md.

Noise that the marks share cannot be seen in their misfit. But a platform moves smoothly: high differences of the pose remove the motion
and keep the noise, and from some order on they agree. What compression, pixels' steps along an edge or heated air add to all marks
alike is found so, and no other way.
"""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy.special import digamma, gammaincinv, polygamma, stdtrit

Array = NDArray[np.float64]

_BAR = 0.975
_NORMAL = 1.959963984540054
"""Quantile of the normal distribution at `_BAR`."""

_ALIKE = 1e6
"""Degrees of freedom that stand for infinitely many: all frames share one factor."""

_ORDERS = range(3, 9)
"""Orders of the differences."""

_SMALLEST = 3
"""The orders that count are those with the smallest scatter, because what is left of the motion only adds to it."""

_FEWEST = 24
"""Differences from which their scatter is known to a fifth."""


def widening(whitened: Array, freedom: NDArray[np.int64]) -> tuple[Array, Array]:
    """Factors by which the standard deviations of each frame fall short, and by which 1.96 of them hold 95 %.

        s_t^2 = |w_t|^2 / nu,    v_t = (d f + nu s_t^2) / (d + nu)
        factors: max(1, sqrt(v_t)) and max(1, sqrt(v_t) t_n / 1.96),    1 / n = 1 / (d + nu) + (d / (d + nu))^2 / (nu N)

    f is the factor that the variances of all frames share and d the degrees of freedom that it is worth in one of them
    (`_prior`), N the number of independent frames, t_n Student's quantile. A frame counts as no better than the best of all
    frames would be by chance with the standard deviations as they are.

    Parameters
    ----------
    whitened : (frames, m) array
        Residuals in standard deviations, zero where there is none.
    freedom : (frames,) array of int
        Degrees of freedom nu; zero in a frame that says nothing, which gets the median of the others.

    Returns
    -------
    deviation, bar : (frames,) arrays
        One where nothing is known.
    """
    known = freedom > 0
    if not known.any():
        return np.ones(len(freedom)), np.ones(len(freedom))
    nu = freedom[known].astype(float)
    frames = independent_frames(whitened, known, float(nu.mean()))
    variance, worth = moderated((whitened[known] ** 2).sum(axis=1) / nu, nu, frames)
    certain = 1.0 / (1.0 / (worth + nu) + (worth / (worth + nu)) ** 2 / (nu * frames))
    student = stdtrit(certain, _BAR) / _NORMAL
    return _in_all(np.sqrt(variance), known), _in_all(np.sqrt(variance) * student, known)


def moderated(square: Array, nu: Array, independent: float) -> tuple[Array, float]:
    """Variances of small samples, moderated by each other: (d f + nu s^2) / (d + nu).

    Parameters
    ----------
    square : (n,) array
        Their estimates s^2. One counts as no smaller than the smallest would be by chance if the true ones were one.
    nu : (n,) array
        Their degrees of freedom.
    independent : float
        As how many independent samples they count; infinite where their number does not matter.

    Returns
    -------
    variance : (n,) array
    worth : float
        Degrees of freedom d that the factor f which they share is worth in one of them.
    """
    best = 2.0 * gammaincinv(nu / 2.0, 1.0 / (2.0 * len(nu)))
    square = np.maximum(square, best / nu)
    shared, worth = _prior(square, nu, independent)
    return (worth * shared + nu * square) / (worth + nu), worth


def _in_all(factor: Array, known: NDArray[np.bool_]) -> Array:
    """Factors of one at least, for all frames."""
    wide = np.maximum(1.0, factor)
    found = np.full(len(known), np.median(wide))
    found[known] = wide
    return found


def independent_frames(whitened: Array, known: NDArray[np.bool_], nu: float) -> float:
    """Number of independent frames that say as much about the misfit as all of them.

        N = T^2 / sum_ts rho_ts^2,    rho_l = mean over t of u_t u_(t+l),    u = w / |w|

    The mean of |w_t|^2 over T frames of nu degrees of freedom has the relative variance 2 sum_ts rho_ts^2 / (nu T^2). An estimate
    of rho_l from c pairs scatters by 1 / (nu c), which is taken off its square.

    Parameters
    ----------
    whitened : (frames, m) array
    known : (frames,) array of bool
        Frames that count.
    nu : float
        Degrees of freedom of a frame.

    Returns
    -------
    float
        From 1, where the residuals are the same in all frames, to the number of frames.
    """
    length = np.linalg.norm(whitened, axis=1, keepdims=True)
    unit = np.where(known[:, None] & (length > 0), whitened / np.maximum(length, np.finfo(float).tiny), 0.0)
    pairs = np.rint(_sums_of_products(known[:, None].astype(float))[1:])
    total = _sums_of_products(unit)[1:]
    square = np.where(pairs > 0, total**2 / np.maximum(pairs, 1.0) - 1.0 / nu, 0.0).sum()
    count = float(known.sum())
    return float(count**2 / np.clip(count + 2.0 * square, count, count**2))


def _sums_of_products(values: Array) -> Array:
    """Sum over t of v_t v_(t+l) for every lag l, (frames,); values : (frames, m)."""
    spectrum = np.fft.rfft(values, 2 * len(values), axis=0)
    return np.fft.irfft((np.abs(spectrum) ** 2).sum(axis=1), 2 * len(values))[: len(values)]


def _prior(square: Array, nu: Array, frames: float) -> tuple[float, float]:
    """The factor f that the variances share, and the degrees of freedom d that it is worth, by the moments of log s^2.

        var(log s^2) = psi'(nu / 2) + psi'(d / 2)
        mean(log s^2) = log f + psi(nu / 2) - log(nu / 2) - psi(d / 2) + log(d / 2)

    A misfit that is the same in all frames is one draw, whose logarithm is not averaged: the terms in nu count by 1 - 1 / N.
    """
    of_log = np.log(square)
    excess = float(of_log.var(ddof=1) - polygamma(1, nu / 2.0).mean()) if len(square) > 1 else 0.0
    worth = min(2.0 * _trigamma_inverse(excess), _ALIKE) if excess > 0.0 else _ALIKE
    shift = (1.0 - 1.0 / frames) * (digamma(nu / 2.0) - np.log(nu / 2.0)).mean() - digamma(worth / 2.0) + np.log(worth / 2.0)
    return float(np.exp(of_log.mean() - shift)), worth


def _trigamma_inverse(value: float) -> float:
    """x with psi'(x) = value, by Newton's method on 1 / psi', which is nearly straight and convex."""
    x = 0.5 + 1.0 / value
    for _ in range(50):
        slope = float(polygamma(1, x))
        step = slope * (1.0 - slope / value) / float(polygamma(2, x))
        x += step
        if abs(step) < 1e-8 * x:
            break
    return x


def scatter(values: Array, sigma: Array) -> float:
    """Scatter of a course from frame to frame, over its standard deviations.

        s = mean over the three orders n where it is least of  median |D^n x| / (0.6745 sqrt(sum_i binom(n, i)^2 sigma_i^2))

    Parameters
    ----------
    values, sigma : (frames,) arrays
        At even spacing, NaN where there is none; a difference over a gap is left out.

    Returns
    -------
    float
        One for white noise of the stated standard deviations; less where part of these is common to all frames; NaN
        where the course is too short.
    """
    found = []
    for order in _ORDERS:
        taps = np.array([(-1) ** i * comb(order, i) for i in range(order + 1)], float)
        if len(values) < len(taps) + _FEWEST:
            break
        ratio = np.convolve(values, taps, "valid") / np.sqrt(np.convolve(sigma**2, taps**2, "valid"))
        ratio = np.abs(ratio[np.isfinite(ratio)])
        if len(ratio) >= _FEWEST:
            found.append(float(np.median(ratio)) / 0.6745)
    return float(np.mean(sorted(found)[:_SMALLEST])) if found else np.nan


def roughness(values: Array, sigma: Array) -> float:
    """Factor by which standard deviations fall short of a course's scatter from frame to frame.

        k^2 = max(1, s^2 + (s^2 - 1))

    What is not of the marks' own noise is in the reference image as much as in each frame, therefore twice.

    Parameters
    ----------
    values, sigma
        As in `scatter`.

    Returns
    -------
    float
        One where they do not fall short, or where the course is too short to tell.
    """
    s = scatter(values, sigma)
    return float(np.sqrt(max(1.0, 2.0 * s**2 - 1.0))) if np.isfinite(s) else 1.0
