"""Measurements along a line of the picture: the pitch of the graduation of a rule, and the direction of a plumb line."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.footage.footage import Picture

Array = NDArray[np.float64]
Line = tuple[float, float, float, float]

_WIDTH_PX = 5
_FEWEST_DIVISIONS = 8
_FINEST_PX = 3.0
_CLEAR = 6.0
"""Height of a peak over the median of the spectrum from which it is a graduation, and of a line over its surroundings, in their spread."""

_IRREGULAR = 0.01
"""Relative uncertainty of the pitch from which a pattern is not a graduation."""

_REACH_PX = 8
_HALF_LINE_PX = 4
_CENTROID_PX = 0.04
"""Common error of the centroids of a line that slowly crosses the pixels."""


def _profile(picture: Picture, line: Line, width: int) -> tuple[Array, Array, Array]:
    """Grey values along a line, (n, width), a pixel apart; the unit vectors along it and across it."""
    x1, y1, x2, y2 = line
    rows, columns = picture.shape
    if not all(0 <= x <= columns - 1 and 0 <= y <= rows - 1 for x, y in ((x1, y1), (x2, y2))):
        raise InputError(f"line {x1:g},{y1:g} to {x2:g},{y2:g}: reaches out of the picture of {columns} x {rows} px. Correct the points.")
    length = math.hypot(x2 - x1, y2 - y1)
    if length < 16:
        raise InputError(f"line {x1:g},{y1:g} to {x2:g},{y2:g}: is {length:.3g} px long; give points at least 16 px apart.")
    along = np.array([x2 - x1, y2 - y1]) / length
    across = np.array([-along[1], along[0]])
    steps, sides = np.arange(math.floor(length) + 1), np.arange(width) - (width - 1) / 2
    at = np.array([x1, y1]) + steps[:, None, None] * along + sides[None, :, None] * across
    values = cv2.remap(
        picture.astype(np.float32), at[..., 0].astype(np.float32), at[..., 1].astype(np.float32), cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
    return values.astype(np.float64), along, across


def pitch_along(picture: Picture, line: Line) -> tuple[float, float]:
    """Measure the pitch of the graduation of a rule.

    The strongest period of the grey values along the line is the graduation, or a longer one nearly as strong, because
    thin marks have overtones. Its phase in windows along the line is fitted by a straight line: the slope gives the pitch,
    the scatter its standard deviation.

    Parameters
    ----------
    picture : (height, width) array
    line : (x1, y1, x2, y2)
        Across the graduation, px.

    Returns
    -------
    pitch, sigma : float
        Distance of the divisions and its standard deviation, px.

    Raises
    ------
    InputError
        No clear period, fewer than eight divisions, divisions finer than three pixels.
    """
    profile = _profile(picture, line, _WIDTH_PX)[0].mean(axis=1)
    place = np.arange(len(profile), dtype=float)
    flat = profile - np.polyval(np.polyfit(place, profile, 3), place)
    frequency = _ground_frequency(flat * np.hanning(len(flat)))
    window = math.ceil(3.0 / frequency)
    centres = np.arange(window / 2, len(flat) - window / 2 + 0.5, window / 2)
    turns = np.array([_turn(flat, frequency, centre, window) for centre in centres])
    phase = np.unwrap(np.angle(turns))
    if len(centres) < 4:
        raise _no_graduation(line, "it crosses too few divisions")
    (slope, _), covariance = np.polyfit(centres, phase, 1, cov=True)
    frequency += slope / (2.0 * np.pi)
    # Windows overlap by half, so that neighbouring phases are not independent.
    sigma = math.sqrt(2.0 * covariance[0, 0]) / (2.0 * np.pi) / frequency**2
    if not sigma * frequency < _IRREGULAR:
        raise _no_graduation(line, f"its divisions would be {1.0 / frequency:.2f} +- {sigma:.2f} px, which is not regular")
    return 1.0 / frequency, sigma


def _ground_frequency(profile: Array) -> float:
    """The lowest strong frequency of a profile, per px."""
    power = np.abs(np.fft.rfft(profile, 8 * len(profile))) ** 2
    frequency = np.fft.rfftfreq(8 * len(profile))
    usable = (frequency > _FEWEST_DIVISIONS / len(profile)) & (frequency < 1.0 / _FINEST_PX)
    power = np.where(usable, power, 0.0)
    if not usable.any() or power.max() < _CLEAR**2 * np.median(power[usable]):
        raise _no_graduation(None, "the grey values along it show no clear period")
    peaks = np.flatnonzero((power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:]) & (power[1:-1] > 0.25 * power.max())) + 1
    return float(frequency[peaks[0]])


def _no_graduation(line: Line | None, why: str) -> InputError:
    where = "" if line is None else f" {line[0]:g},{line[1]:g} to {line[2]:g},{line[3]:g}"
    return InputError(
        f"--rule: no graduation on the line{where}: {why}. Draw it along the rule through all its marks, over {_FEWEST_DIVISIONS} "
        f"divisions at least, each {_FINEST_PX:g} px or more."
    )


def _turn(profile: Array, frequency: float, centre: float, window: int) -> complex:
    """Phase of a frequency around a place."""
    place = np.arange(len(profile))
    weight = np.where(np.abs(place - centre) < window / 2, np.cos(np.pi * (place - centre) / window) ** 2, 0.0)
    return complex(np.sum(weight * profile * np.exp(-2j * np.pi * frequency * place)))


def plumb_line(picture: Picture, line: Line) -> tuple[float, float]:
    """Measure the direction of up from a thin line that hangs.

    At every pixel along it the position of the line is the centroid of what differs most from its surroundings; a
    straight line is fitted, and outliers are left out.

    Parameters
    ----------
    picture : (height, width) array
    line : (x1, y1, x2, y2)
        Two points near the plumb line, px.

    Returns
    -------
    up, sigma : float
        Direction of up, clockwise from the picture's own, and its standard deviation, deg.

    Raises
    ------
    InputError
        Nothing there stands out as a line.
    """
    values, along, across = _profile(picture, line, 2 * _REACH_PX + 1)
    off = np.abs(values - np.median(values, axis=1, keepdims=True))
    clear = off.max(axis=1) > _CLEAR * np.maximum(np.median(off, axis=1), 0.5)
    if clear.mean() < 0.5:
        raise InputError(
            f"--plumb: no thin line within {_REACH_PX} px of {line[0]:g},{line[1]:g} to {line[2]:g},{line[3]:g}. "
            "Give two points on the plumb line."
        )
    place = np.flatnonzero(clear).astype(float)
    slope, sigma = _straight(place, _centroids(off[clear]))
    sigma = math.hypot(sigma, _CENTROID_PX / len(values))
    direction = along + slope * across
    direction *= -np.sign(direction[1]) or 1.0
    return math.degrees(math.atan2(direction[0], -direction[1])), math.degrees(sigma)


def _centroids(off: Array) -> Array:
    """Place of the line across, px from the middle, one for each row of `off`; only what is near the strongest pixel counts."""
    sides = np.arange(off.shape[1]) - (off.shape[1] - 1) / 2
    near = np.abs(sides - sides[off.argmax(axis=1)][:, None]) <= _HALF_LINE_PX
    strong = np.where(near, np.maximum(off - np.median(off, axis=1, keepdims=True), 0.0), 0.0)
    return strong @ sides / strong.sum(axis=1)


def _straight(place: Array, side: Array) -> tuple[float, float]:
    """Slope of a straight line and its standard deviation, far-off places left out.

    Neighbouring places err alike (a line that crosses the pixels slowly), which widens the sigma by how slowly they change.
    """
    kept = np.ones(len(place), bool)
    for _ in range(5):
        fitted = np.polyval(np.polyfit(place[kept], side[kept], 1), place)
        kept = np.abs(side - fitted) <= 3.0 * 1.4826 * np.median(np.abs(side - fitted)[kept]) + 1e-6
    coefficients, covariance = np.polyfit(place[kept], side[kept], 1, cov=True)
    left = (side - np.polyval(coefficients, place))[kept]
    alike = max(2.0 * float(np.var(left)) / max(float(np.mean(np.diff(left) ** 2)), 1e-12), 1.0)
    return float(coefficients[0]), float(np.sqrt(covariance[0, 0] * alike))
