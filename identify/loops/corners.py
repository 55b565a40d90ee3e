"""Sharp reversals: a shaker in triangles turns between two samples, and a polynomial through both sides rounds the corner off.

The law counts the way from the turning point; a corner that is rounded off by half a sample's way is a beta that is wrong by as much.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import Polynomial

from identify.loops.differentiation import Motion
from measure.common.arrays import Array

SIDE = 6  # samples on each side
_LEAST = 4
_DEGREE = 2  # of the polynomial on either side; one through both has as many coefficients as the two together
_SHARP = 3.0  # noises that one polynomial through both sides leaves at a corner
_FAR_LESS = 0.25  # of its sum of squares, that is left by two of them


@dataclass(frozen=True)
class Corner:
    """Instant and elongation of a sharp turning point, s and m; and how far off it is if the sides are straight."""

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
    corners = []
    for k in turns:
        side = min([SIDE, *(abs(other - k) // 2 for other in turns if other != k), k, len(time_s) - 1 - k])
        if side >= _LEAST and _is_sharp(time_s, measured_m, k, side, smooth.noise_m):
            found = _corner(time_s, measured_m, k, side, columns)
            corners += [found] if found else []
    doubt = [corner.doubt_m for corner in corners]
    turns_m = float(np.hypot(smooth.noise_m, np.median(doubt))) if doubt else smooth.turns_m
    return replace(smooth, elongation_m=columns[0], speed_m_per_s=columns[1], acceleration_m_per_s2=columns[2], turns_m=turns_m), corners


def _is_sharp(time_s: Array, u: Array, k: int, side: int, noise_m: float) -> bool:
    """Whether one polynomial through both sides leaves more than the noise does, and far more than one for each side."""
    here, t = slice(k - side, k + side + 1), time_s - time_s[k]
    round_ = _left(t[here], u[here], 2 * _DEGREE + 1)
    sharp = _left(t[k - side : k], u[k - side : k], _DEGREE) + _left(t[k + 1 : k + side + 1], u[k + 1 : k + side + 1], _DEGREE)
    return round_ > (2 * side - 2 * _DEGREE - 1) * (_SHARP * noise_m) ** 2 and sharp < _FAR_LESS * round_


def _left(t: Array, u: Array, degree: int) -> float:
    left = u - Polynomial.fit(t, u, degree)(t)
    return float(left @ left)


def _corner(time_s: Array, u: Array, k: int, side: int, columns: Array) -> Corner | None:
    """Where polynomials of either side meet between the neighbours of sample k; the motion there is taken from them."""
    t = time_s - time_s[k]
    samples = range(k - side, k), range(k + 1, k + side + 1)
    before, after = (_side(t, u, here, _DEGREE) for here in samples)
    straight_before, straight_after = (_side(t, u, here, 1) for here in samples)
    instant = _meeting(before, after, t[k - 1], t[k + 1])
    straight = _meeting(straight_before, straight_after, t[k - 1], t[k + 1])
    if instant is None:
        return None
    for i in range(k - side // 2, k + side // 2 + 1):
        taken = before if t[i] <= instant else after
        columns[:, i] = taken(t[i]), taken.deriv()(t[i]), taken.deriv(2)(t[i])
    doubt = abs(before(instant) - straight_before(straight)) if straight is not None else abs(u[k + 1] - u[k - 1])
    return Corner(instant + float(time_s[k]), float(before(instant)), float(doubt))


def _side(t: Array, u: Array, samples: range, degree: int) -> Polynomial:
    here = np.array(samples)
    return Polynomial.fit(t[here], u[here], degree).convert()


def _meeting(before: Polynomial, after: Polynomial, first: float, last: float) -> float | None:
    """Instant between two others at which both polynomials are equal, the one nearest to zero."""
    roots = (before - after).roots()
    inside = [float(x.real) for x in roots if abs(x.imag) < 1e-12 and first <= x.real <= last]
    return min(inside, key=abs) if inside else None
