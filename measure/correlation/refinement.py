"""Where exactly a mark is: sub-pixel refinement of a subset by inverse-compositional Gauss-Newton.

The current image g, seen through the warp W, should be the reference image f times a gain plus an offset:

    g(W(x)) = a f(W(x; dp)) + b  ~  a (f + S dp) + b,      W <- W o W(dp)^-1

S are the slopes of f along each parameter (the steepest-descent images). Gain and offset, and where needed their
gradient across the mark, are eliminated by projecting S off them, which makes it the least-squares solution of the
zero-mean normalised squared difference. The slopes come from the reference image, so noise of the current image biases nothing. Baker
and Matthews, Int. J. Computer Vision 56 (2004) 221; Pan, Li, Tong, Experimental Mechanics 53 (2013) 1277.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from measure.correlation.gauss_newton import solve
from measure.correlation.reference_image import Reference
from measure.correlation.robust import solve_robust
from measure.correlation.spline import FILTER, NOISE_LEFT, coefficients

ALIKE = 0.80
"""Correlation below which two images are not of the same mark."""

MOST_HIDDEN = 0.25
"""Share of a subset that may be covered before the mark counts as occluded."""

_UNEXPLAINED = 0.02
_UNEVEN = 3.0
"""Times white noise that light changing across the mark must explain: a few in a hundred even frames do by chance."""

_STRANGE = 10.0
"""Times the usual noise that may be left under robust weights; more is another picture, of which a few pixels agree."""

_ROUNDED = 2.0 * NOISE_LEFT / 12.0
"""Variance of the difference of two images that are rounded to whole grey levels."""

_SPARE_PX = 6
_TUKEY_SHARE = 0.828
"""Weighted mean square of normal residuals under Tukey's weights, over their variance."""


@dataclass(frozen=True)
class Match:
    """One subset refined: the warp, how sure it is, and how alike the two images are.

    warp : (6,) as in `measure.correlation.spline.sample`. covariance : (2, 2) of the reference point, px^2. zncc : correlation of
    the compared pixels, after the light's gradient where that was needed. gain : of the light. noise : what is left,
    grey levels. hidden : share of the pixels that something else covers. settled : whether the iteration came to rest.
    uneven : what light that changes across the mark would explain, over what it would of white noise (one). altered :
    whether such light is allowed for.
    """

    warp: NDArray[np.float64]
    covariance: NDArray[np.float64]
    zncc: float
    gain: float
    noise: float
    hidden: float
    settled: bool
    uneven: float = 0.0
    altered: bool = False

    @property
    def unexplained(self) -> float:
        """Share of the variance that the reference does not explain."""
        return 1.0 - self.zncc**2


@dataclass(frozen=True)
class Usual:
    """What a mark was like in the frames before; what clearly exceeds it is not noise.

    noise : left over, grey levels. unexplained : share of the variance. hidden : share that was covered a frame ago.
    altered : whether the light has changed across it. out_of_sight : whether it was lost a frame ago; half a mark behind an
    edge can look like a badly lit one, so it must look as it did to be taken for found.
    """

    noise: float = 0.0
    unexplained: float = 0.0
    hidden: float = 0.0
    altered: bool = False
    out_of_sight: bool = False


def recognise(picture: NDArray, mark: Reference, guess: NDArray[np.float64], usual: Usual) -> Match | None:
    """The mark near a first guess, by the plainest model that explains the picture; None where it is not the mark.

    Tried in turn: even light; light that changes across the mark; something thin in front, whose pixels get no
    weight. Where something was in front a frame ago, it is expected there still. How much may be covered before the mark
    counts as occluded (`MOST_HIDDEN`) is the caller's to judge.
    """
    window = surface_near(picture, mark.half, guess)
    if window is None:
        return None
    enough = max(4.0 * usual.unexplained, 0.1 * _UNEXPLAINED)
    scale = max(usual.noise, 0.02 * mark.contrast)
    under = mark.altered if usual.altered and mark.altered is not None else mark
    if usual.hidden > 0.0:
        robust = _settled(refine(window, under, guess, scale))
        if robust is not None and robust.unexplained <= enough:
            return robust
    best = _settled(refine(window, under, guess))
    if best is not None and best.unexplained <= enough and best.uneven <= _UNEVEN:
        return best
    if under is not mark:
        best, under = _settled(refine(window, mark, guess)), mark
    near = best.warp if best is not None and best.zncc >= ALIKE else guess
    if mark.altered is not None:
        altered = _settled(refine(window, mark.altered, near))
        if altered is not None and (best is None or best.unexplained <= enough or altered.unexplained < 0.6 * best.unexplained):
            best, under = altered, mark.altered
    if best is not None and best.unexplained <= enough:
        return best
    robust = _settled(refine(window, under, near, scale))
    if robust is None:
        return best if best is not None and best.unexplained <= _UNEXPLAINED else None
    if usual.out_of_sight:
        alike = robust.unexplained <= max(enough, _UNEXPLAINED) and robust.noise <= 3.0 * scale and 0.5 < robust.gain < 2.0
    else:
        alike = robust.unexplained <= 1.0 - ALIKE**2 and robust.noise <= _STRANGE * scale
    return robust if alike else None


def _settled(match: Match | None) -> Match | None:
    return match if match is not None and match.settled else None


@dataclass(frozen=True)
class Window:
    """The current image near a guess: spline coefficients, the first of them at (left, top)."""

    surface: NDArray[np.float32]
    left: int
    top: int


def refine(near: Window, mark: Reference, guess: NDArray[np.float64], scale: float | None = None) -> Match | None:
    """Refine a mark in the current image from a first guess of its warp.

    near : from `surface_near`. guess : (6,), within a speckle or so of the truth. scale : None compares all pixels
    alike; a noise level (grey levels, blurred) gives pixels that differ by much more no weight (Tukey), for thin things
    in front of the mark.

    Returns None where no solution is found.
    """
    place = (near.surface, near.left, near.top, mark.half, guess)
    if scale is None:
        found = solve(*place, mark.free, mark.light, mark.values, mark.inverse_hessian, mark.look, mark.uneven, _ROUNDED, mark.kept)
    else:
        found = solve_robust(*place, mark.descent, mark.added, mark.values, scale, mark.kept)
    warp, gain, residual, explained, hidden, extra, settled = found
    if not (np.isfinite(warp).all() and residual > 0 and gain > 0):
        return None
    widening = 1.0
    if scale is not None:
        residual, widening = residual / _TUKEY_SHARE, max(extra / np.trace(mark.inverse_hessian[:2, :2]), 1.0)
    residual = max(residual, _ROUNDED)
    covariance = mark.point_noise * (residual / NOISE_LEFT / gain**2 * widening)
    uneven = 0.0 if scale is not None else extra * NOISE_LEFT
    return Match(warp, covariance, math.sqrt(max(explained, 0.0)), gain, math.sqrt(residual), hidden, settled, uneven, mark.is_altered)


def surface_near(picture: NDArray, half: int, warp: NDArray[np.float64]) -> Window | None:
    """The part of the picture that refinement from `warp` may need, or None where the subset leaves the picture."""
    rows, columns = picture.shape
    reach_x, reach_y = half * (abs(warp[0]) + abs(warp[1])), half * (abs(warp[3]) + abs(warp[4]))
    left, right, top, bottom = warp[2] - reach_x, warp[2] + reach_x, warp[5] - reach_y, warp[5] + reach_y
    if not (left > -1 and top > -1 and right < columns and bottom < rows):
        return None
    x, y = math.floor(left) - _SPARE_PX, math.floor(top) - _SPARE_PX
    width, height = math.ceil(right) + _SPARE_PX + 1 - x, math.ceil(bottom) + _SPARE_PX + 1 - y
    return Window(coefficients(picture, x, y, width, height, FILTER), x, y)
