"""Where exactly a mark is: sub-pixel refinement of a subset by inverse-compositional Gauss-Newton.

The current image g, seen through the warp W, should be the reference image f times a gain plus an offset:

    g(W(x)) = a f(W(x; dp)) + b  ~  a (f + S dp) + b,      W <- W o W(dp)^-1

S are the slopes of f along each parameter (the steepest-descent images). Gain and offset are eliminated by projecting
S off f and 1, which makes it the least-squares solution of the zero-mean normalised squared difference. The slopes
come from the reference image, so noise of the current image biases nothing. Baker and Matthews, Int. J. Computer
Vision 56 (2004) 221; Pan, Li, Tong, Experimental Mechanics 53 (2013) 1277.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d

from .errors import InputError
from .gauss_newton import solve, solve_robust
from .spline import BLUR, FILTER, NOISE_LEFT, coefficients, slopes

TRANSLATION, EUCLIDEAN, AFFINE = 2, 3, 6
"""Warps by their number of parameters."""

WARP_NAMES = {TRANSLATION: "translation", EUCLIDEAN: "euclidean", AFFINE: "affine"}


@dataclass(frozen=True)
class Reference:
    """A mark as the reference image shows it, ready to be found again.

    column, row : the subset's centre pixel. offset : (2,) from it to the reference point, px.
    values : (n,) blurred grey values f. basis : (m, n) orthonormal images that light can add (1 and f).
    descent : (k, n) slopes along the warp's parameters; free : the same, projected off the basis.
    inverse_hessian : (k, k) of `free`. noise : (k, k), covariance of the parameters for pixel noise of variance one.
    """

    column: int
    row: int
    half: int
    offset: NDArray[np.float64]
    values: NDArray[np.float32]
    basis: NDArray[np.float32]
    descent: NDArray[np.float32]
    free: NDArray[np.float32]
    inverse_hessian: NDArray[np.float64]
    noise: NDArray[np.float64]
    contrast: float

    @property
    def warp(self) -> int:
        """The number of parameters of the warp."""
        return len(self.descent)

    @property
    def start(self) -> NDArray[np.float64]:
        """The warp that leaves the mark where the reference image has it."""
        return np.array([1.0, 0.0, self.column, 0.0, 1.0, self.row])

    def point(self, warp: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where a warp puts the reference point, px."""
        return warp[[2, 5]] + warp.reshape(2, 3)[:, :2] @ self.offset


@dataclass(frozen=True)
class Match:
    """One subset refined: the warp, how sure it is, and how alike the two images are.

    warp : (6,) as in `measure.spline.sample`. covariance : (2, 2) of the reference point, px^2. zncc : correlation of
    the compared pixels. gain : of the light. hidden : share of the pixels that something else covers. settled : whether
    the iteration came to rest.
    """

    warp: NDArray[np.float64]
    covariance: NDArray[np.float64]
    zncc: float
    gain: float
    noise: float
    hidden: float
    settled: bool


def reference(picture: NDArray, x: float, y: float, subset: int, warp: int = AFFINE) -> Reference:
    """Prepare the mark at (x, y) of a reference image.

    picture : (rows, columns). subset : odd, px. warp : the richest allowed; a poorer one is taken where the texture
    cannot tell more (a dot has no rotation).

    Raises
    ------
    InputError
        The subset reaches over the border, or has too little texture to be found again.
    """
    half, column, row = subset // 2, round(x), round(y)
    _require_inside(picture, x, y, half)
    c = coefficients(picture, column - half - 2, row - half - 2, subset + 4, subset + 4, FILTER)
    f, fx, fy = slopes(c)
    _require_texture(float(f.std()), fx, fy, picture.dtype, x, y)
    basis = _orthonormal(np.stack([np.ones(f.size), f.ravel()]))
    offset = np.array([x - column, y - row])
    poorer = [k for k in (AFFINE, EUCLIDEAN, TRANSLATION) if k <= warp]
    made = (_prepared(column, row, half, offset, f, basis, _descent(fx, fy, half, k)) for k in poorer)
    return next(mark for mark in made if mark.warp == TRANSLATION or _tells(mark))


def _prepared(column: int, row: int, half: int, offset: NDArray, f: NDArray, basis: NDArray, descent: NDArray) -> Reference:
    """Project the slopes off what light can do, and keep what each iteration needs."""
    free = descent - (descent @ basis.T) @ basis
    noise, inverse_hessian = _covariance_of_unit_noise(free, 2 * half + 1)
    f32, b32, d32, p32 = (np.ascontiguousarray(a, np.float32) for a in (f.ravel(), basis, descent, free))
    return Reference(column, row, half, offset, f32, b32, d32, p32, inverse_hessian, noise, float(f.std()))


def _require_inside(picture: NDArray, x: float, y: float, half: int) -> None:
    rows, columns = picture.shape
    if not (half <= round(x) < columns - half and half <= round(y) < rows - half):
        raise InputError(
            f"mark at {x:g},{y:g}: its subset of {2 * half + 1} px reaches over the border of the picture of {columns} x {rows} px. "
            "Move the mark inwards or take a smaller --subset."
        )


def _require_texture(contrast: float, fx: NDArray, fy: NDArray, dtype: np.dtype, x: float, y: float) -> None:
    """Refuse a subset whose poorer direction would not be known to 0.1 px at noise of 1.5 steps of 8 bit, or of one step."""
    noise = 1.5 if dtype == np.uint8 else 1.0
    h = np.array([[(fx * fx).sum(), (fx * fy).sum()], [(fx * fy).sum(), (fy * fy).sum()]])
    weakest = float(np.linalg.eigvalsh(h)[0])
    if contrast < 2.0 * noise or weakest < 2.0 * (noise / 0.1) ** 2:
        raise InputError(
            f"mark at {x:g},{y:g}: too little texture in its subset (contrast {contrast:.1f} grey levels, "
            f"slopes in the poorer direction {np.sqrt(max(weakest, 0.0) / fx.size):.2f} per px). "
            "Put the mark on a pattern with edges in two directions, or enlarge --subset."
        )


def _orthonormal(rows: NDArray) -> NDArray:
    return np.ascontiguousarray(np.linalg.qr(rows.T)[0].T)


def _descent(fx: NDArray, fy: NDArray, half: int, warp: int) -> NDArray:
    """Slopes of the reference image along the parameters: shift x, shift y; rotation; or the four of an affine warp."""
    dy, dx = np.mgrid[-half : half + 1, -half : half + 1]
    images = {TRANSLATION: (fx, fy), EUCLIDEAN: (fx, fy, fy * dx - fx * dy), AFFINE: (fx, fy, fx * dx, fx * dy, fy * dx, fy * dy)}[warp]
    return np.stack([image.ravel() for image in images])


def _covariance_of_unit_noise(free: NDArray, subset: int) -> tuple[NDArray, NDArray]:
    """Covariance of the parameters for white noise of variance one, and the inverse Hessian.

    The blur correlates the noise of neighbouring pixels: with B the blur, cov = H^-1 (S B B' S') H^-1, H = S S'.
    """
    images = free.reshape(-1, subset, subset)
    wide = np.pad(images, ((0, 0), (12, 12), (12, 12)))
    blurred = convolve1d(convolve1d(wide, BLUR, axis=1), BLUR, axis=2).reshape(len(free), -1)
    inverse = np.linalg.pinv(free @ free.T)
    return inverse @ (blurred @ blurred.T) @ inverse, inverse


def _tells(mark: Reference) -> bool:
    """Whether pixel noise of 2 % of the contrast leaves rotation and stretch known to 0.1 px at the subset's edge."""
    edge = np.sqrt(np.diag(mark.noise)[2:].max()) * mark.half * 0.02 * mark.contrast
    return bool(edge < 0.1)


def refine(picture: NDArray, mark: Reference, guess: NDArray[np.float64], scale: float | None = None) -> Match | None:
    """Refine a mark in the current image from a first guess of its warp.

    picture : (rows, columns). guess : (6,), within a speckle or so of the truth. scale : None compares all pixels
    alike; a noise level (grey levels, blurred) gives pixels that differ by much more no weight (Tukey), for thin things
    in front of the mark.

    Returns None where the subset leaves the picture or no solution is found.
    """
    box = _window(picture, mark.half, guess)
    if box is None:
        return None
    c = coefficients(picture, *box, FILTER)
    images = (mark.descent, mark.values) if scale is not None else (mark.free, mark.basis)
    if scale is None:
        found = solve(c, box[0], box[1], mark.half, guess, *images, mark.values, mark.inverse_hessian)
    else:
        found = solve_robust(c, box[0], box[1], mark.half, guess, *images, scale)
    warp, gain, residual, explained, hidden, trace, settled = found
    if not (np.isfinite(warp).all() and residual > 0 and gain > 0):
        return None
    widening = 1.0 if scale is None else trace / np.trace(mark.inverse_hessian[:2, :2])
    residual = max(residual, 2.0 * NOISE_LEFT / 12.0)  # both images are rounded to whole grey levels
    jacobian = _point_slopes(mark)
    covariance = jacobian @ mark.noise @ jacobian.T * (residual / NOISE_LEFT / gain**2) * widening
    return Match(warp, covariance, float(np.sqrt(max(explained, 0.0))), gain, float(np.sqrt(residual)), hidden, settled)


def _point_slopes(mark: Reference) -> NDArray:
    """(2, k): how the reference point moves with the parameters."""
    x, y = mark.offset
    slopes = {
        TRANSLATION: [[1, 0], [0, 1]],
        EUCLIDEAN: [[1, 0, -y], [0, 1, x]],
        AFFINE: [[1, 0, x, y, 0, 0], [0, 1, 0, 0, x, y]],
    }
    return np.array(slopes[mark.warp], float)


def _window(picture: NDArray, half: int, warp: NDArray[np.float64]) -> tuple[int, int, int, int] | None:
    """Left, top, width, height of the pixels that refinement may need, or None where the subset leaves the picture."""
    rows, columns = picture.shape
    reach_x, reach_y = half * (abs(warp[0]) + abs(warp[1])), half * (abs(warp[3]) + abs(warp[4]))
    left, right, top, bottom = warp[2] - reach_x, warp[2] + reach_x, warp[5] - reach_y, warp[5] + reach_y
    if not (left > -1 and top > -1 and right < columns and bottom < rows):
        return None
    spare = 6
    x, y = int(np.floor(left)) - spare, int(np.floor(top)) - spare
    return x, y, int(np.ceil(right)) + spare + 1 - x, int(np.ceil(bottom)) + spare + 1 - y
