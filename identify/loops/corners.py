"""Sharp reversals: a shaker in triangles turns between two samples, and a polynomial through both sides rounds the corner off.

The force law depends on the distance from the turning point; one that is rounded off by half a sample is a beta that is as much off.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.polynomial import polyfit, polyroots
from numpy.typing import NDArray

from identify.loops.differentiation import Motion
from measure.common.arrays import Array

SIDE = 6  # samples on each side
_LEAST = 4
_DEGREE = 2  # of the polynomial on either side; one through both has as many coefficients as the two together
_SHARP = 3.0  # noises that one polynomial through both sides leaves at a corner
_FAR_LESS = 0.25  # of its sum of squares, that is left by two of them


@dataclass(frozen=True)
class Corner:
    """Instant and elongation of a sharp turning point, s and m; and how far off it is if both sides are straight lines."""

    time_s: float
    elongation_m: float
    doubt_m: float


def sharpened(time_s: Array, measured_m: Array, smooth: Motion, turns: tuple[int, ...]) -> tuple[Motion, list[Corner]]:
    """The motion with sharp reversals fitted from either side, and where they turn; smooth reversals stay as they are.

    Parameters
    ----------
    measured_m : the elongation as it was measured. turns : indices of the reversals.
    """
    columns = np.stack([smooth.elongation_m, smooth.speed_m_per_s, smooth.acceleration_m_per_s2])
    at = np.array(turns, dtype=np.intp)
    sides = _sides(at, len(time_s))
    corners = []
    for k, side in zip(*_sharp(time_s, measured_m, at, sides, smooth.noise_m), strict=True):
        found = _corner(time_s, measured_m, int(k), int(side), columns)
        corners += [found] if found else []
    doubt = [corner.doubt_m for corner in corners]
    turns_m = float(np.hypot(smooth.noise_m, np.median(doubt))) if doubt else smooth.turns_m
    return replace(smooth, elongation_m=columns[0], speed_m_per_s=columns[1], acceleration_m_per_s2=columns[2], turns_m=turns_m), corners


def _sides(at: NDArray[np.intp], samples: int) -> NDArray[np.intp]:
    """How many samples either side of each turn may have: half of those up to the next turn, none beyond the ends of the record."""
    between = np.diff(at) // 2
    behind, ahead = np.append(SIDE, between)[: len(at)], np.append(between, SIDE)[: len(at)]
    return np.minimum.reduce([np.full(len(at), SIDE), behind, ahead, at, samples - 1 - at])


def _sharp(time_s: Array, u: Array, at: NDArray[np.intp], sides: NDArray[np.intp], noise_m: float) -> tuple[NDArray, NDArray]:
    """The turns at which one polynomial through both sides leaves more than the noise does, and far more than one for each side."""
    kept = np.zeros(len(at), dtype=bool)
    for side in range(_LEAST, SIDE + 1):
        here = np.flatnonzero(sides == side)
        if not len(here):
            continue
        near = at[here, None] + np.arange(-side, side + 1)
        t, values = time_s[near] - time_s[at[here], None], u[near]
        round_ = _left(t, values, 2 * _DEGREE + 1)
        sharp = _left(t[:, :side], values[:, :side], _DEGREE) + _left(t[:, side + 1 :], values[:, side + 1 :], _DEGREE)
        kept[here] = (round_ > (2 * side - 2 * _DEGREE - 1) * (_SHARP * noise_m) ** 2) & (sharp < _FAR_LESS * round_)
    return at[kept], sides[kept]


def _left(t: Array, u: Array, degree: int) -> Array:
    """Sum of squares that a polynomial through the samples of a row leaves, (m,) for t and u (m, samples)."""
    middle, half = (t[:, -1:] + t[:, :1]) / 2.0, (t[:, -1:] - t[:, :1]) / 2.0
    basis, _ = np.linalg.qr(np.stack([((t - middle) / half) ** k for k in range(degree + 1)], axis=2))
    left = u - np.einsum("ijk,ik->ij", basis, np.einsum("ijk,ij->ik", basis, u))
    return np.einsum("ij,ij->i", left, left)


def _corner(time_s: Array, u: Array, k: int, side: int, columns: Array) -> Corner | None:
    """Where polynomials of either side meet between the neighbours of sample k; the motion there is taken from them."""
    here = slice(k - side, k + side + 1)
    t, near = time_s[here] - time_s[k], u[here]
    sides = slice(0, side), slice(side + 1, 2 * side + 1)
    before, after = (_through(t[samples], near[samples], _DEGREE) for samples in sides)
    line_before, line_after = (_through(t[samples], near[samples], 1) for samples in sides)
    instant = _meeting(before, after, t[side - 1], t[side + 1])
    on_lines = _meeting(line_before, line_after, t[side - 1], t[side + 1])
    if instant is None:
        return None
    for i in range(side - side // 2, side + side // 2 + 1):
        columns[:, k - side + i] = _motion(before if t[i] <= instant else after, t[i])
    turn = _motion(before, instant)[0]
    doubt = abs(turn - _motion(line_before, on_lines)[0]) if on_lines is not None else abs(u[k + 1] - u[k - 1])
    return Corner(instant + float(time_s[k]), turn, float(doubt))


def _through(t: Array, u: Array, degree: int) -> Array:
    """Coefficients of the least-squares polynomial, lowest power first, of degree two at most: (3,)."""
    scale = float(np.abs(t).max())
    found = np.zeros(3)
    found[: degree + 1] = polyfit(t / scale, u, degree) / scale ** np.arange(degree + 1)
    return found


def _motion(polynomial: Array, t: float) -> tuple[float, float, float]:
    """Value, first and second derivative."""
    c0, c1, c2 = (float(c) for c in polynomial)
    return c0 + (c1 + c2 * t) * t, c1 + 2.0 * c2 * t, 2.0 * c2


def _meeting(before: Array, after: Array, first: float, last: float) -> float | None:
    """Instant between two others at which both polynomials are equal, the one nearest to zero."""
    apart = np.trim_zeros(before - after, "b")
    roots = polyroots(apart) if len(apart) else []
    inside = [float(x.real) for x in roots if abs(x.imag) < 1e-12 and first <= x.real <= last]
    return min(inside, key=abs) if inside else None
