"""Velocity and acceleration from noisy positions, with their uncertainty, and the instants at which a deployment begins and ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from measure.tables.frames import frame_of

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.floating]

_CLEAR_SIGMAS = 4.0


@dataclass(frozen=True, repr=False)
class Smoothed:
    """Position, velocity and acceleration at each instant.

    Attributes
    ----------
    time_s : (n,) array
    value, sigma : (n, 3) arrays
        Position, velocity and acceleration, in the unit of the channel, per s and per s^2; and their standard deviations.
    jerk_density : float
        Spectral density of the jerk, unit^2/s^5; the smaller, the smoother.
    """

    time_s: Array
    value: Array
    sigma: Array
    jerk_density: float

    def __repr__(self) -> str:
        return (
            f"Smoothed({len(self.time_s)} instants from {self.time_s[0]:g} to {self.time_s[-1]:g} s, jerk density {self.jerk_density:.3g})"
        )

    def to_frame(self) -> DataFrame:
        """The table as a pandas frame.

        Returns
        -------
        pandas.DataFrame
            time_s, position, velocity, acceleration, each of the three followed by its standard deviation sigma_...
        """
        columns = {"time_s": self.time_s}
        for k, name in enumerate(("position", "velocity", "acceleration")):
            columns |= {name: self.value[:, k], f"sigma_{name}": self.sigma[:, k]}
        return frame_of(columns, name="smoothed")


def smooth(time_s: Array, position: Array, sigma: Array, jerk_density: float | None = None) -> Smoothed:
    """Smooth a channel: velocity and acceleration of a motion whose jerk is white noise.

        d/dt (x, v, a) = (v, a, jerk),   jerk white with density q;   y = x + noise of the stated sigma

    The estimate is the Kalman filter and its backward pass (Rauch, Tung and Striebel, AIAA Journal 3 (1965) 1445); q is
    the maximum-likelihood estimate. Instants without a position are bridged.

    Parameters
    ----------
    time_s, position, sigma : (n,) arrays
        Instants, a channel and its standard deviation; NaN where nothing was observed.
    jerk_density : float, optional
        q, unit^2/s^5; estimated unless given.

    Returns
    -------
    Smoothed
    """
    density = _likeliest(time_s, position, sigma) if jerk_density is None else jerk_density
    _, means, covariances = _forward(time_s, position, sigma, density)
    return Smoothed(time_s, *_backward(time_s, means, covariances, density), density)


def _likeliest(time_s: Array, position: Array, sigma: Array) -> float:
    scale = _scale(time_s, position)
    best = minimize_scalar(lambda p: -_forward(time_s, position, sigma, scale * 10.0**p)[0], bounds=(-8.0, 4.0), method="bounded")
    return scale * 10.0 ** float(best.x)  # type: ignore[attr-defined]


def _scale(time_s: Array, position: Array) -> float:
    """A jerk density that would cover the whole range in the whole time."""
    return float(np.nanmax(position) - np.nanmin(position) + 1e-12) ** 2 / (time_s[-1] - time_s[0]) ** 5 * 1e4


def _step(dt: float, q: float) -> tuple[Array, Array]:
    move = np.array([[1.0, dt, dt * dt / 2], [0.0, 1.0, dt], [0.0, 0.0, 1.0]])
    spread = np.array([[dt**5 / 20, dt**4 / 8, dt**3 / 6], [dt**4 / 8, dt**3 / 3, dt**2 / 2], [dt**3 / 6, dt**2 / 2, dt]])
    return move, q * spread


def _forward(time_s: Array, position: Array, sigma: Array, q: float) -> tuple[float, Array, Array]:
    """Log likelihood, and the state after each instant: (n, 3), (n, 3, 3)."""
    first = int(np.flatnonzero(np.isfinite(position))[0])
    span = float(np.nanmax(position) - np.nanmin(position)) + 1e-9
    duration = time_s[-1] - time_s[0]
    mean = np.array([position[first], 0.0, 0.0])
    covariance = np.diag([span, 10 * span / duration, 100 * span / duration**2]) ** 2
    means, covariances, likelihood = np.empty((len(time_s), 3)), np.empty((len(time_s), 3, 3)), 0.0
    for i in range(len(time_s)):
        if i:
            move, spread = _step(time_s[i] - time_s[i - 1], q)
            mean, covariance = move @ mean, move @ covariance @ move.T + spread
        if np.isfinite(position[i]) and np.isfinite(sigma[i]):
            variance = covariance[0, 0] + sigma[i] ** 2
            gap, gain = position[i] - mean[0], covariance[:, 0] / variance
            likelihood -= 0.5 * (np.log(variance) + gap**2 / variance)
            mean = mean + gain * gap
            covariance = covariance - np.outer(gain, covariance[0])
        means[i], covariances[i] = mean, covariance
    return likelihood, means, covariances


def _backward(time_s: Array, means: Array, covariances: Array, q: float) -> tuple[Array, Array]:
    value, spread_of = means.copy(), covariances.copy()
    for i in range(len(time_s) - 2, -1, -1):
        move, spread = _step(time_s[i + 1] - time_s[i], q)
        ahead = move @ covariances[i] @ move.T + spread
        gain = np.linalg.solve(ahead, move @ covariances[i]).T
        value[i] += gain @ (value[i + 1] - move @ means[i])
        spread_of[i] += gain @ (spread_of[i + 1] - ahead) @ gain.T
    return value, np.sqrt(np.maximum(np.diagonal(spread_of, axis1=1, axis2=2), 0.0))


@dataclass(frozen=True)
class Instants:
    """Release, highest velocity and end of the stroke, s; None where it cannot be determined."""

    release_s: float | None
    fastest_s: float | None
    end_of_stroke_s: float | None


def instants(elevation: Smoothed) -> Instants:
    """Find release and end of the stroke in a smoothed elevation.

    The release is where a straight line through the velocity between 5 and 30 % of its maximum meets zero; None where
    that is before the film. The end of the stroke is the strongest deceleration after the highest velocity.

    Parameters
    ----------
    elevation : Smoothed

    Returns
    -------
    Instants
    """
    speed, sigma = elevation.value[:, 1], elevation.sigma[:, 1]
    fastest = int(np.argmax(speed))
    if speed[fastest] < _CLEAR_SIGMAS * sigma[fastest]:
        return Instants(None, None, None)
    braked = fastest + int(np.argmin(elevation.value[fastest:, 2]))
    met = braked < len(speed) - 1 and elevation.value[braked, 2] < -_CLEAR_SIGMAS * elevation.sigma[braked, 2]
    end = float(elevation.time_s[braked]) if met else None
    return Instants(_release(elevation.time_s, speed, fastest), float(elevation.time_s[fastest]), end)


def _release(time_s: Array, speed: Array, fastest: int) -> float | None:
    begin = int(np.flatnonzero(speed[: fastest + 1] < 0.05 * speed[fastest])[-1:].sum())
    rising = np.arange(len(speed)) >= begin
    rising &= (np.arange(len(speed)) <= fastest) & (speed > 0.05 * speed[fastest]) & (speed < 0.3 * speed[fastest])
    if rising.sum() < 3:
        return None
    slope, offset = np.polyfit(time_s[rising], speed[rising], 1)
    at = float(-offset / slope) if slope > 0 else -np.inf
    return at if at > time_s[0] - (time_s[1] - time_s[0]) else None
