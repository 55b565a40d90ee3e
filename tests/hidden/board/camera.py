"""What camera and clock make of a motion, written apart from the project's own way of saying it.

true time = (shown - t_0) / (1 + r) - instant of the release;  then the roll of the picture, its scale, the lens, and a low pass
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from measure.tables.trajectory import CHANNELS, Trajectory
from simulate.model.effect import Effect

from .campaigns import Deployment

Array = np.ndarray


@dataclass(frozen=True)
class Motion:
    """The platform from the release on: time (n,), its origin (n, 3), and its rotation as unit quaternions (n, 4), scalar first."""

    time_s: Array
    place_m: Array
    quaternion: Array

    def at(self, time_s: Array) -> tuple[Array, Rotation]:
        """Origin (k, 3) and rotations at any instants, between samples by cubic spline."""
        pose = CubicSpline(self.time_s, np.hstack([self.place_m, self.quaternion]))(time_s)
        return pose[:, :3], Rotation.from_quat(pose[:, 3:], scalar_first=True)


def values_of(effects: tuple[Effect, ...]) -> dict[str, Array]:
    """The parameters of each effect by its name."""
    return {effect.name: effect.flat() for effect in effects}


def shown(motion: Motion, run: Deployment, effects: tuple[Effect, ...]) -> dict[str, Array]:
    """The channels of a run's table without noise, each (frames,)."""
    acting = values_of(effects)
    offset, rate = acting.get("time-offset", (0.0, 0.0))
    true_s = (run.time_s - offset) / (1.0 + rate) - run.instant_s
    slow_s = float(acting.get("sensor-filter", (0.0, 0.0))[1])
    rows = averaged(lambda late_s: _at_once(motion, np.clip(true_s - late_s, 0.0, motion.time_s[-1]), run, acting), slow_s)
    return dict(zip(CHANNELS, rows, strict=True))


def averaged(shown_late: Callable[[float], Array], tau_s: float) -> Array:
    """A low pass of first order: what was shown, averaged over the time since then with the weight exp(-time / tau), by Laguerre's rule."""
    if tau_s == 0.0:
        return shown_late(0.0)
    places, weights = np.polynomial.laguerre.laggauss(24)
    return np.tensordot(weights, [shown_late(tau_s * place) for place in places], axes=1)


def _at_once(motion: Motion, at: Array, run: Deployment, acting: Mapping[str, Array]) -> Array:
    """Every channel (6, frames) as a camera shows it that does not smooth."""
    place, turn = motion.at(at)
    if run.zeroed:
        turn = turn * motion.at(at[:1])[1].inv()
    x, z = place[:, 0].copy(), place[:, 2].copy()
    roll = float(acting.get("camera-roll", (0.0,))[0])
    place[:, 0], place[:, 2] = np.cos(roll) * x + np.sin(roll) * z, np.cos(roll) * z - np.sin(roll) * x
    place *= 1.0 + float(acting.get("scale-error", (0.0,))[0])
    stretch, height = acting.get("lens-distortion", (0.0, 0.0))
    across = place[:, [0, 2]] - [0.0, height]
    place[:, [0, 2]] += stretch * np.sum(across**2, axis=1)[:, None] * across
    return np.stack([*place.T, *angles_of(turn)])


def angles_of(turn: Rotation) -> tuple[Array, Array, Array]:
    """theta_x, theta_y of the swing's rotation vector and theta_z = 2 atan2(q_z, q_w): the swing is what is left without the twist."""
    w, _, _, z = turn.as_quat(scalar_first=True).T
    theta_z = np.unwrap(2.0 * np.arctan2(z, w))
    twist = Rotation.from_rotvec(np.column_stack([np.zeros_like(theta_z), np.zeros_like(theta_z), theta_z]))
    swing = (turn * twist.inv()).as_rotvec()
    return swing[:, 0], swing[:, 1], theta_z


def table_of(channels: Mapping[str, Array], run: Deployment, start_height_m: float, chance: np.random.Generator) -> Trajectory:
    """The table as it is written: with noise, counted from the first frame where the run is zeroed."""
    noisy = {}
    for name in run.channels:
        values = channels[name] + chance.normal(0.0, run.sigma[name], len(run.time_s))
        if run.zeroed:
            values = values - values[0] + (start_height_m if name == "z_m" else 0.0)
        noisy[name] = np.round(values, 8)
    sigma = {name: np.full(len(run.time_s), run.sigma[name]) for name in run.channels} if run.tells_sigma else {}
    return Trajectory(run.time_s, noisy, sigma)
