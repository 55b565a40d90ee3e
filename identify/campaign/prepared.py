"""Measurements made ready for a problem: what counts, how noisy it is, and from where it is counted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identify.campaign.noise import channel_noise, lacking_in_force
from identify.campaign.runs import Run
from identify.loops.loop_data import LoopData, prepare
from measure.common.arrays import Array
from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory
from simulate.model.model import Model

_ZEROED = 3.0  # standard deviations
_UNSET, _LEAST_SPREAD_S = 10.0, 1e-3


@dataclass(frozen=True)
class Film:
    """A deployment made ready: the channels that were seen, their noise, and when they count.

    values, sigma : (channels, n). counts : (channels, n), where there is a measurement. nominal : (channels,) where the
    platform should stand before the release. zeroed : (channels,), counted from the first frame and not from the rig's
    own zero; a tracker does that, so such a channel says nothing about where the platform stood, only how far it went.
    time_s : (n,) on the clock that the release sets, as far as it is known; clock_s more is the table's own clock.
    expected_s : when the release is expected on that clock; a film that counts from its first frame began before it.
    by_onset : whether the onset of the motion says so and nothing else does; then a clock that is late says nothing.
    """

    run: Run
    model: Model
    time_s: Array
    channels: tuple[str, ...]
    values: Array
    sigma: Array
    counts: NDArray[np.bool_]
    nominal: Array
    zeroed: NDArray[np.bool_]
    expected_s: float
    clock_s: float = 0.0
    by_onset: bool = False

    @property
    def turned(self) -> bool:
        """Whether rotations count from the first frame."""
        return any(zeroed and name.startswith("theta") for name, zeroed in zip(self.channels, self.zeroed, strict=True))


@dataclass(frozen=True)
class LoopRun:
    """A loop made ready."""

    run: Run
    model: Model
    data: LoopData


def loop_of(run: Run, model: Model) -> LoopRun:
    """A loop's table made ready; its time counts from its first sample, whatever the recorder's clock showed."""
    assert isinstance(run.table, Loop)
    return loop_run(run, model, prepare(replace(run.table, time_s=run.table.time_s - run.table.time_s[0])))


def loop_run(run: Run, model: Model, data: LoopData) -> LoopRun:
    """A loop that is ready, its force as noisy as a fine load cell's at least."""
    return LoopRun(run, model, replace(data, force_sigma_N=max(data.force_sigma_N, lacking_in_force(data.time_s, data.force_N))))


def film_of(run: Run, model: Model) -> Film:
    """A deployment's table made ready; `model` is the model as it was in this run."""
    table = run.table
    assert isinstance(table, Trajectory)
    channels = tuple(name for name, values in table.channels.items() if np.isfinite(values).sum() > 3)
    values = np.stack([table.channels[name] for name in channels])
    sigma = np.stack([channel_noise(table, name) for name in channels])
    stowed = 0.0 if model.geometry is None else model.geometry.stowed_height_m
    nominal = np.array([stowed if channel == "z_m" else 0.0 for channel in channels])
    from_first_frame = bool(np.all(np.abs(values[:, 0] - nominal) < _ZEROED * sigma[:, 0]))
    zeroed = np.full(len(channels), from_first_frame)
    clock = _clock_s(table.time_s, values[channels.index("z_m")], model) if "z_m" in channels else 0.0
    time = table.time_s - clock
    expected = _onset_s(time, values[channels.index("z_m")]) if zeroed.any() and "z_m" in channels else 0.0
    by_onset = "z_m" in channels and (from_first_frame or clock != 0.0)
    return Film(run, model, time, channels, values, sigma, np.isfinite(values), nominal, zeroed, expected, clock, by_onset)


def _clock_s(time_s: Array, elevation_m: Array, model: Model) -> float:
    """What a clock showed at the release if it was never set by it; zero where it was, to within ten of its spreads."""
    onset = _onset_s(time_s, elevation_m)
    return onset if abs(onset) > _UNSET * max(model.nuisance.release_instant_s, _LEAST_SPREAD_S) else 0.0


def lengths_of(film: Film) -> list[int]:
    """Rows of the zeroed channels that are lengths."""
    names = [channel for channel, zeroed in zip(film.channels, film.zeroed, strict=True) if zeroed]
    return [row for row, channel in enumerate(names) if channel.endswith("_m")]


def _onset_s(time_s: Array, elevation_m: Array) -> float:
    """When a rise from rest began: at a steady acceleration it has gone h at t_1 and 4 h at t_2, so it began at 2 t_1 - t_2."""
    good = np.isfinite(elevation_m)
    rise = elevation_m - elevation_m[good][0]
    gone = 0.01 * float(np.nanmax(rise))
    if gone <= 0.0:
        return 0.0
    time, rise = time_s[good], np.maximum.accumulate(rise[good])
    first, fourth = (float(np.interp(part * gone, rise, time)) for part in (1.0, 4.0))
    return max(2.0 * first - fourth, float(time[0]))
