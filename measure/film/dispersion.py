"""Dispersion: how much two deployments of the same rig differ."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from measure.common.errors import InputError
from measure.tables.frames import frame_of
from measure.tables.trajectory import CHANNELS, Trajectory, read_trajectory

if TYPE_CHECKING:
    from pandas import DataFrame

Array = NDArray[np.floating]

_LATEST = 0.25
"""Share of the shorter film by which two cameras may have been started apart."""

_LEAST_COMMON = 8


@dataclass(frozen=True)
class Difference:
    """One channel of two films, first minus second, with the second on the first's clock.

    Attributes
    ----------
    time_s, values : (n,) arrays
        Where both have a value, s and the unit of the channel.
    sigma : (n,) array
        Standard deviation of the difference, from those of the two films.
    span : float
        Range of the channel in the first film.
    """

    time_s: Array
    values: Array
    sigma: Array
    span: float

    def summary(self) -> dict[str, Any]:
        """In numbers: root mean square and largest, in the unit of the channel and in percent of its span.

        Returns
        -------
        dict
            rms, max_abs, rms_percent, max_percent (None where the channel hardly moves, so that they would be of its
            noise), and rms_of_noise, which the noise of both films alone would give.
        """
        rms, largest = float(np.sqrt(np.mean(self.values**2))), float(np.abs(self.values).max())
        noise = float(np.sqrt(np.mean(self.sigma**2)))
        percent = 100.0 / self.span if self.span > max(20.0 * noise, 0.0) else None
        return {
            "rms": rms, "max_abs": largest, "rms_percent": percent and rms * percent, "max_percent": percent and largest * percent,
            "rms_of_noise": noise if np.isfinite(noise) else None,
        }  # fmt: skip


@dataclass(frozen=True, repr=False)
class Dispersion:
    """Two films compared.

    Attributes
    ----------
    name : str
        Of the second film.
    other : Trajectory
        The second film.
    shift_s, sigma_shift_s : float
        By how much the second film's clock is ahead, and its standard deviation (None where nothing moves), s.
    channels : dict of str to Difference
    """

    name: str
    other: Trajectory
    shift_s: float
    sigma_shift_s: float | None
    channels: dict[str, Difference]

    def __repr__(self) -> str:
        rms = ", ".join(f"{name} {difference.summary()['rms']:.3g}" for name, difference in self.channels.items())
        return f"Dispersion(from {self.name}, shift {self.shift_s:.4g} s, rms {rms})"

    def to_frame(self) -> DataFrame:
        """The differences as a pandas frame; units in `frame.attrs["units"]`.

        Returns
        -------
        pandas.DataFrame
            time_s of the first film, each channel (first minus second) followed by its sigma_..., NaN where one of the
            films has no value.
        """
        time_s = np.unique(np.concatenate([difference.time_s for difference in self.channels.values()]))
        columns = {"time_s": time_s}
        for name, difference in self.channels.items():
            at = np.searchsorted(time_s, difference.time_s)
            for column, values in ((name, difference.values), (f"sigma_{name}", difference.sigma)):
                columns[column] = np.full(len(time_s), np.nan)
                columns[column][at] = values
        return frame_of(columns, name=self.name)

    def summary(self) -> dict[str, Any]:
        """The comparison as `--json` writes it."""
        return {
            "file": self.name,
            "shift_s": self.shift_s,
            "sigma_shift_s": self.sigma_shift_s,
            "channels": {name: difference.summary() for name, difference in self.channels.items()},
        }


def compare_trajectories(first: Trajectory, second: Trajectory, name: str) -> Dispersion:
    """Compare two deployments, the second shifted in time so that the elevations agree best.

    Two films seldom begin at the same instant of the deployment; what remains after the shift is dispersion. The second
    film is interpolated linearly between its frames.

    Parameters
    ----------
    first, second : Trajectory
    name : str
        Of the second film.

    Returns
    -------
    Dispersion

    Raises
    ------
    InputError
        They have no common channel, or hardly overlap.
    """
    common = [c for c in CHANNELS if c in first.channels and c in second.channels]
    if not common:
        raise InputError(f"{name}: shares no channel with this film; it has {', '.join(second.channels)}. Name another trajectory.")
    lead = "z_m" if "z_m" in common else common[0]
    shift = _shift(first, second, lead, name)
    channels = {c: _difference(first, second, c, shift) for c in common}
    return Dispersion(name, second, shift, _shift_sigma(channels[lead], first, lead), channels)


def _shift(first: Trajectory, second: Trajectory, channel: str, name: str) -> float:
    """The shift under which a channel differs least, by trying a grid and refining at its best.

    Between two frames the noise of the second film is averaged, so a difference there is less for that alone: squares count in
    units of the variance that white noise would have.
    """
    widest = _LATEST * min(np.ptp(first.time_s), np.ptp(second.time_s))
    frames_s = _seen(second, channel)[0]

    def misfit(shift: float) -> float:
        left = _difference(first, second, channel, shift)
        if len(left.values) < _LEAST_COMMON:
            return np.inf
        part = np.mod(np.interp(left.time_s + shift, frames_s, np.arange(len(frames_s))), 1.0)
        return float(np.mean(left.values**2 / (1.0 + part**2 + (1.0 - part) ** 2)))

    grid = np.linspace(-widest, widest, 201)
    found = np.array([misfit(shift) for shift in grid])
    if not np.isfinite(found).any():
        raise InputError(f"{name}: hardly overlaps with this film in time. Compare films of the same deployment from its release on.")
    best = grid[int(np.argmin(found))]
    return _refined(misfit, best, grid[1] - grid[0])


def _refined(misfit: Callable[[float], float], best: float, step: float) -> float:
    found = minimize_scalar(misfit, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-3 * step})
    return float(found.x) if found.fun < misfit(best) else float(best)  # type: ignore[attr-defined]


def _shift_sigma(left: Difference, first: Trajectory, channel: str) -> float | None:
    """Standard deviation of the shift with correlated differences: their rms over the root of the summed squared velocity v.

    That sum is of the one film's velocity times the other's, whose noise is independent. The misfit is least where the sum of the
    differences times v is nought, and there v has its noise: the rms counts times the root of the sum with noise over that without.
    """
    here = np.interp(left.time_s, *_seen(first, channel)[:2])
    there = here - left.values
    squared = float(np.sum(np.gradient(here, left.time_s) * np.gradient(there, left.time_s)))
    if squared <= 0.0:
        return None
    noisy = max(squared, float(np.sum((np.diff(there) / np.diff(left.time_s)) ** 2)))
    strength = squared / float(np.sqrt(noisy))
    steps = np.diff(left.values)
    alike = max(1.0, 2.0 * float(np.var(left.values)) / max(float(np.mean(steps**2)), 1e-30))
    return float(np.sqrt(np.mean(left.values**2)) / strength * np.sqrt(min(alike, len(left.values))))


def _seen(table: Trajectory, channel: str) -> tuple[Array, Array, Array]:
    good = np.isfinite(table.channels[channel])
    sigma = table.sigma.get(channel, np.full(len(good), np.nan))
    return table.time_s[good], table.channels[channel][good], sigma[good]


def _difference(first: Trajectory, second: Trajectory, channel: str, shift: float) -> Difference:
    (ta, a, sa), (tb, b, sb) = _seen(first, channel), _seen(second, channel)
    both = (ta >= tb[0] - shift) & (ta <= tb[-1] - shift) if len(tb) else np.zeros(len(ta), bool)
    at = ta[both] + shift
    values = a[both] - np.interp(at, tb, b) if both.any() else np.empty(0)
    sigma = np.hypot(sa[both], np.interp(at, tb, sb)) if both.any() else np.empty(0)
    return Difference(ta[both], values, sigma, float(np.ptp(a)) if len(a) else 0.0)


def compare_with_files(first: Trajectory, files: list[Path]) -> list[Dispersion]:
    """Compare a trajectory with those of earlier films, one for each CSV file.

    Parameters
    ----------
    first : Trajectory
    files : list of Path

    Returns
    -------
    list of Dispersion

    Raises
    ------
    InputError
        A file cannot be read, or shares nothing with the first.
    """
    return [compare_trajectories(first, read_trajectory(file), str(file)) for file in files]
