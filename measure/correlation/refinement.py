"""Where exactly a mark is: sub-pixel refinement of a subset by inverse-compositional Gauss-Newton.

The current image g, seen through the warp W, should be the reference image f times a gain plus an offset:

    g(W(x)) = a f(W(x; dp)) + b  ~  a (f + S dp) + b,      W <- W o W(dp)^-1

S are the slopes of f along each parameter (the steepest-descent images). Gain and offset, and where needed their
gradient across the mark, are eliminated by projecting S off them, which makes it the least-squares solution of the
zero-mean normalised sum of squared differences (ZNSSD). The slopes come from the reference image, so noise of the
current image biases nothing.

Baker and Matthews, International Journal of Computer Vision 56 (2004) 221; Pan, Li and Tong, Experimental Mechanics 53
(2013) 1277.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from measure.correlation.criteria import LEAST_ZNCC, STRANGE, UNEVEN_LIGHT, UNEXPLAINED
from measure.correlation.gauss_newton import solve
from measure.correlation.reference import Reference
from measure.correlation.robust_gauss_newton import solve_robust
from measure.correlation.spline import FILTER, NOISE_LEFT, coefficients

_ROUNDED = 2.0 * NOISE_LEFT / 12.0
"""Variance of the difference of two images that are rounded to whole grey levels."""

_SPARE_PX = 6
_TUKEY_SHARE = 0.828
"""Weighted mean square of normal residuals under Tukey's weights, over their variance."""


@dataclass(frozen=True)
class Match:
    """One subset refined.

    Attributes
    ----------
    warp : (6,) array
        As in `measure.correlation.spline.sample`.
    covariance : (2, 2) array
        Of the reference point, px^2.
    zncc : float
        Zero-mean normalised cross-correlation of the compared pixels, with the light's gradient taken off where it is fitted.
    gain : float
        Of the light.
    noise : float
        Residual, grey levels.
    hidden : float
        Share of the pixels that something else covers.
    settled : bool
        Whether the iteration converged.
    uneven : float
        What light changing across the mark would explain, over what it would explain of white noise (one).
    uneven_light : bool
        Whether such light is fitted.
    """

    warp: NDArray[np.float64]
    covariance: NDArray[np.float64]
    zncc: float
    gain: float
    noise: float
    hidden: float
    settled: bool
    uneven: float = 0.0
    uneven_light: bool = False

    @property
    def unexplained(self) -> float:
        """Share of the variance that the reference image does not explain."""
        return 1.0 - self.zncc**2


@dataclass(frozen=True)
class Expected:
    """What a mark was like in the frames before; what clearly exceeds it is not noise.

    Attributes
    ----------
    noise : float
        Residual, grey levels.
    unexplained : float
        Share of the variance.
    hidden : float
        Share that was covered a frame ago.
    uneven_light : bool
        Whether the light has changed across the mark.
    lost : bool
        Whether the mark was lost a frame ago. Half a mark behind an edge can look like a badly lit one, so it must look
        as it did to be found again.
    """

    noise: float = 0.0
    unexplained: float = 0.0
    hidden: float = 0.0
    uneven_light: bool = False
    lost: bool = False

    def after(self, lost: bool) -> Expected:
        """The same, with the mark lost a frame ago or not."""
        return replace(self, lost=lost)

    def updated(self, match: Match, first: bool) -> Expected:
        """What to expect of the next frame: a running mean over the frames that nothing covers, the first one left out."""
        if match.hidden > 0.0 or first:
            return replace(self, hidden=match.hidden)
        share = 0.3 if self.noise == 0.0 else 0.1
        return Expected(
            self.noise + share * (match.noise - self.noise),
            self.unexplained + share * (match.unexplained - self.unexplained),
            match.hidden,
            self.uneven_light or match.uneven_light,
        )


def recognise(picture: NDArray, mark: Reference, guess: NDArray[np.float64], expected: Expected) -> Match | None:
    """Refine a mark near a first guess, by the plainest model that explains the picture.

    Tried in turn: even light; light that changes across the mark; something thin in front, whose pixels get no weight.
    Where something was in front a frame ago, it is expected there still.

    Parameters
    ----------
    picture : (rows, columns) array
        The current image.
    mark : Reference
    guess : (6,) array
        First guess of the warp.
    expected : Expected

    Returns
    -------
    Match or None
        None where it is not the mark. Whether too much is covered (`MOST_HIDDEN`) is the caller's to judge.
    """
    window = surface_near(picture, mark.half, guess)
    if window is None:
        return None
    enough = max(4.0 * expected.unexplained, 0.1 * UNEXPLAINED)
    scale = max(expected.noise, 0.02 * mark.contrast)
    model = mark.uneven_light if expected.uneven_light and mark.uneven_light is not None else mark
    if expected.hidden > 0.0:
        robust = _settled(refine(window, model, guess, scale))
        if robust is not None and robust.unexplained <= enough:
            return robust
    best = _settled(refine(window, model, guess))
    if best is not None and best.unexplained <= enough and best.uneven <= UNEVEN_LIGHT:
        return best
    if model is not mark:
        best, model = _settled(refine(window, mark, guess)), mark
    near = best.warp if best is not None and best.zncc >= LEAST_ZNCC else guess
    if mark.uneven_light is not None:
        uneven = _settled(refine(window, mark.uneven_light, near))
        if uneven is not None and (best is None or best.unexplained <= enough or uneven.unexplained < 0.6 * best.unexplained):
            best, model = uneven, mark.uneven_light
    if best is not None and best.unexplained <= enough:
        return best
    robust = _settled(refine(window, model, near, scale))
    if robust is None:
        return best if best is not None and best.unexplained <= UNEXPLAINED else None
    return robust if _is_the_mark(robust, enough, scale, expected.lost) else None


def _is_the_mark(robust: Match, enough: float, scale: float, lost: bool) -> bool:
    """Whether what is left under robust weights is the mark; stricter where it was lost a frame ago."""
    if lost:
        return robust.unexplained <= max(enough, UNEXPLAINED) and robust.noise <= 3.0 * scale and 0.5 < robust.gain < 2.0
    return robust.unexplained <= 1.0 - LEAST_ZNCC**2 and robust.noise <= STRANGE * scale


def _settled(match: Match | None) -> Match | None:
    return match if match is not None and match.settled else None


@dataclass(frozen=True)
class Window:
    """Part of the current image: spline coefficients (rows, columns), the first of them at the pixel (left, top)."""

    surface: NDArray[np.float32]
    left: int
    top: int


def refine(near: Window, mark: Reference, guess: NDArray[np.float64], scale: float | None = None) -> Match | None:
    """Refine a mark in the current image from a first guess of its warp.

    Parameters
    ----------
    near : Window
        From `surface_near`.
    mark : Reference
    guess : (6,) array
        Within a speckle or so of the truth.
    scale : float, optional
        Noise of the blurred images, grey levels: pixels that differ by much more get no weight (Tukey), for thin things
        in front of the mark. Without it all pixels count alike.

    Returns
    -------
    Match or None
        None where no solution is found.
    """
    place = (near.surface, near.left, near.top, mark.half, guess)
    kept = mark.subset.kept
    if scale is None:
        found = solve(*place, mark.projected, mark.light, mark.values, mark.inverse_hessian, mark.bending, mark.uneven, _ROUNDED, kept)
    else:
        found = solve_robust(*place, mark.determined, mark.added, mark.values, scale, kept, mark.basis)
    warp, gain, residual, explained, hidden, extra, settled = found
    if not (np.isfinite(warp).all() and residual > 0 and gain > 0):
        return None
    widening = 1.0
    if scale is not None:
        residual, widening = residual / _TUKEY_SHARE, max(extra / np.trace(mark.inverse_hessian[:2, :2]), 1.0)
    residual = max(residual, _ROUNDED)
    covariance = mark.point_noise * (residual / NOISE_LEFT / gain**2 * widening)
    uneven = 0.0 if scale is not None else extra * NOISE_LEFT
    zncc = math.sqrt(max(explained, 0.0))
    return Match(warp, covariance, zncc, gain, math.sqrt(residual), hidden, settled, uneven, mark.allows_uneven_light)


def surface_near(picture: NDArray, half: int, warp: NDArray[np.float64]) -> Window | None:
    """Prepare the part of the picture that a refinement may need.

    Parameters
    ----------
    picture : (rows, columns) array
    half : int
        The subset is 2 half + 1 px wide.
    warp : (6,) array
        First guess.

    Returns
    -------
    Window or None
        None where the subset leaves the picture.
    """
    rows, columns = picture.shape
    reach_x, reach_y = half * (abs(warp[0]) + abs(warp[1])), half * (abs(warp[3]) + abs(warp[4]))
    left, right, top, bottom = warp[2] - reach_x, warp[2] + reach_x, warp[5] - reach_y, warp[5] + reach_y
    if not (left > -1 and top > -1 and right < columns and bottom < rows):
        return None
    x, y = math.floor(left) - _SPARE_PX, math.floor(top) - _SPARE_PX
    width, height = math.ceil(right) + _SPARE_PX + 1 - x, math.ceil(bottom) + _SPARE_PX + 1 - y
    return Window(coefficients(picture, x, y, width, height, FILTER), x, y)
