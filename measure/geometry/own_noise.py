"""How much each coordinate of each mark scatters from frame to frame by itself, beside its standard deviation.

The residual of a mark is orthogonal to its slopes, and an edge that stands at the wrong place in the picture moves the mark and
leaves no residual. What such an error does from frame to frame shows in the marks together: high differences remove a smooth motion,
and of what is left the body's scatter moves all marks along their slopes, the rest is each coordinate's own. That is factor
analysis with known loadings. The scatter is found for one stretch of the film after the other, because light, speed and the tilt of
edges change.

Rubin and Thayer, EM algorithms for ML factor analysis, Psychometrika 47 (1982) 69. The derivation is in
docs/theory/image-correlation.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc

from measure.correlation.marks import Marks
from measure.geometry.rigid_body import Fit
from measure.geometry.widening import moderated

Array = NDArray[np.float64]

_TAPS = np.array([(-1) ** i * comb(3, i) for i in range(4)], float)
"""Third differences remove a constant acceleration; what they leave of the motion is the body's, and no mark's own."""

_ALIKE = np.convolve(_TAPS, _TAPS[::-1]) / (_TAPS @ _TAPS)
"""Correlation of such differences of white noise."""

_FEWEST = 24
"""Differences in a stretch of the film at least; the scatter of a coordinate counts where it is seen in half of them."""

_FALSE_ALARM = 0.05
"""Probability that white noise of the stated size widens anything in a film."""

_STEPS, _SETTLED = 100, 1e-2
_LEAST = 1e-9


@dataclass(frozen=True)
class OwnNoise:
    """The scatter of n marks in t frames over their standard deviations.

    Attributes
    ----------
    variance : (t, n, 2) array
        Factor of the variance of each coordinate, one at least.
    reference_px2 : (n, 2) array
        Variance of each coordinate's error in the reference image beyond the stated one, px^2.
    """

    variance: Array
    reference_px2: Array

    def on(self, marks: Marks) -> Marks:
        """The marks with standard deviations that hold it."""
        factor = np.sqrt(self.variance)
        return replace(marks, covariance_px2=marks.covariance_px2 * factor[..., :, None] * factor[..., None, :])

    def slow(self, share: float) -> OwnNoise:
        """The same with errors that change too slowly to be seen from frame to frame, as much as a share of those that are seen."""
        return replace(self, variance=self.variance + share * (self.variance - 1.0))


def own_noise(marks: Marks, fit: Fit, moved: NDArray[np.bool_]) -> OwnNoise | None:
    """Each coordinate's own scatter from frame to frame in every stretch of the film.

    In the reference image it is that of the first stretch in which the marks move: there the edges still stand as they stood.

    Parameters
    ----------
    marks : Marks
    fit : Fit
        Of the body to these marks; a sighting that took no part in it does not count.
    moved : (frames,) array of bool
        Frames in which the marks have left their first places; before, they err as the reference image does.

    Returns
    -------
    OwnNoise or None
        None where no coordinate scatters more than chance would have it, the film is too short to tell, or there is a
        single mark.
    """
    differences = _differences(marks, fit)
    if len(marks.names) < 2 or len(differences.values) < _FEWEST:
        return None
    parts = _stretches(moved[1 : 1 + len(differences.values)])
    factors = [_factors(differences.of(part), _FALSE_ALARM / len(parts)) for part in parts]
    found = [factor for factor in factors if factor is not None]
    if not found:
        return None
    rows = np.array([np.ones_like(found[0]) if factor is None else factor for factor in factors])
    frames = np.arange(len(marks.time_s))
    ends = np.array([part[-1] + 1 for part in parts])
    variance = rows[np.minimum(np.searchsorted(ends, frames), len(parts) - 1)].reshape(len(frames), -1, 2)
    return OwnNoise(variance, _stated_px2(marks) * (rows[0].reshape(-1, 2) - 1.0))


def _stated_px2(marks: Marks) -> Array:
    """Median variance of each coordinate, (marks, 2) px^2; zero for a mark that is never seen."""
    variance = np.diagonal(marks.covariance_px2, axis1=2, axis2=3)
    seen = zip(np.swapaxes(variance, 0, 1), marks.observed.T, strict=True)
    return np.array([np.median(own[at], axis=0) if at.any() else np.zeros(2) for own, at in seen])


def _stretches(moved: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """Differences of the moving marks in stretches of equal length; of all where those are too few."""
    at = np.flatnonzero(moved)
    at = at if len(at) >= _FEWEST else np.arange(len(moved))
    return np.array_split(at, len(at) // _FEWEST)


def _factors(differences: Differences, false_alarm: float) -> Array | None:
    """Factors of the variances in one stretch, (m,), or None where they are as stated."""
    known = differences.seen.sum(axis=0) >= _FEWEST // 2
    if not known.any():
        return None
    variance, freedom = own_variances(differences.only(known))
    if not (gammaincc(freedom / 2.0, freedom * variance / 2.0) < false_alarm / len(variance)).any():
        return None
    found = np.ones(len(known))
    found[known] = np.maximum(moderated(variance, freedom, np.inf)[0], 1.0)
    found[~known] = np.median(found[known])
    return found


@dataclass(frozen=True)
class Differences:
    """High differences of m coordinates in T frames, in their standard deviations.

    Attributes
    ----------
    values : (T, m) array
        Zero where a coordinate is not seen.
    slopes : (T, m, k) array
        The same with each channel of the pose, zero where it is not seen.
    seen : (T, m) array of bool
    """

    values: Array
    slopes: Array
    seen: NDArray[np.bool_]

    def of(self, frames: NDArray[np.int64]) -> Differences:
        """The same for some of the frames."""
        return Differences(self.values[frames], self.slopes[frames], self.seen[frames])

    def only(self, kept: NDArray[np.bool_]) -> Differences:
        """The same for some of the coordinates; kept : (m,) array of bool."""
        return Differences(self.values[:, kept], self.slopes[:, kept], self.seen[:, kept])


def _differences(marks: Marks, fit: Fit) -> Differences:
    """Of the x and y of every mark, in the frames where none of the frames of a difference lacks it."""
    frames = len(marks.x_px)
    places = np.stack([marks.x_px, marks.y_px], axis=-1).reshape(frames, -1)
    variance = np.diagonal(marks.covariance_px2, axis1=2, axis2=3).reshape(frames, -1)
    used = np.repeat(fit.used, 2, axis=1)
    seen = _over(used.astype(float), np.ones(len(_TAPS))) > len(_TAPS) - 0.5
    sigma = np.sqrt(np.where(seen, _over(np.where(used, variance, 0.0), _TAPS**2), 1.0))
    values = np.where(seen, _over(np.where(used, places, 0.0), _TAPS), 0.0) / sigma
    middle = fit.slopes.reshape(frames, used.shape[1], -1)[len(_TAPS) // 2 :][: len(values)]
    return Differences(values, np.where(seen[..., None], middle, 0.0) / sigma[..., None], seen)


def _over(values: Array, taps: Array) -> Array:
    """Sum of each column (frames, m) under taps, (frames - taps + 1, m); empty where the film is shorter."""
    count = max(len(values) - len(taps) + 1, 0)
    return np.asarray(sum(tap * values[i : i + count] for i, tap in enumerate(taps)), float)


def own_variances(differences: Differences) -> tuple[Array, Array]:
    """Variances of each coordinate's own scatter, by maximum likelihood, and their degrees of freedom.

        d_t = L_t phi_t + e_t,    phi_t ~ N(0, diag(tau)),    e_t ~ N(0, diag(v))

    d are the differences, L the slopes, phi the scatter of the pose. By the EM algorithm: with V = diag(v) and Q = diag(tau),
    phi given d has the covariance P = (L' V^-1 L + Q^-1)^-1 and the mean P L' V^-1 d; v and tau are the mean squares of e and
    phi under it.

    Parameters
    ----------
    differences : Differences

    Returns
    -------
    variance : (m,) array
        Of e; one where the standard deviations are right.
    freedom : (m,) array
        The number of independent differences, less the share of each coordinate that the pose takes.
    """
    d, counts = differences.values, differences.seen.sum(axis=0)
    slopes = differences.slopes / np.sqrt((differences.slopes**2).mean(axis=(0, 1)) + np.finfo(float).tiny)
    own, body, taken = np.ones(d.shape[1]), np.ones(slopes.shape[2]), np.zeros_like(d)
    for _ in range(_STEPS):
        weighted = np.swapaxes(slopes / own[:, None], 1, 2)
        spread = np.linalg.inv(weighted @ slopes + np.diag(1.0 / body))
        scatter = (spread @ (weighted @ d[..., None]))[..., 0]
        taken = ((slopes @ spread) * slopes).sum(axis=2)
        left = (d - (slopes @ scatter[..., None])[..., 0]) ** 2
        before, own = own, np.maximum((left + taken).sum(axis=0) / counts, _LEAST)
        body = np.maximum((scatter**2 + np.diagonal(spread, axis1=1, axis2=2)).mean(axis=0), _LEAST)
        if np.abs(np.log(own / before)).max() < _SETTLED:
            break
    share = 1.0 - taken.sum(axis=0) / counts / own
    return own, counts / (_ALIKE**2).sum() * np.clip(share, 0.05, 1.0)
