"""Runs made ready, and the problem that they pose with a model: what counts, how noisy it is, and from where it is counted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identify.campaign.measures import measures_of
from identify.campaign.noise import channel_noise, loop_run
from identify.campaign.plausible import require_plausible, seen_channels
from identify.campaign.prepared import Film, LoopRun
from identify.campaign.run import Run
from identify.estimation.parameters import Change
from identify.estimation.problem import Problem
from identify.loops.prepare import prepare
from measure.common.arrays import Array
from measure.common.errors import InputError, nearest
from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory
from simulate.kernel.speed_polynomials import with_rate_worked_in
from simulate.model.model import Model

_ZEROED = 3.0  # standard deviations
_UNSET, _LEAST_SPREAD_S = 10.0, 1e-3


def problem_of(
    model: Model, runs: Sequence[Run], covariate: str = "", *, own_zeros: bool = False, changes: Sequence[Change] = ()
) -> Problem:
    """The problem of a campaign; what is held out is left out by the caller.

    own_zeros : whether the load cell was set to zero for each loop anew, from where it may drift.
    changes : which parameters are held, bounded, or begin elsewhere.

    Raises
    ------
    InputError
        A run cannot be used with this model, or a loop has no column of the covariate's name.
    """
    model = with_rate_worked_in(model)
    films = tuple(film_of(run, run.model(model)) for run in runs if not run.is_loop)
    loops = tuple(loop_of(run, run.model(model)) for run in runs if run.is_loop)
    for loop in loops:
        if covariate and covariate not in loop.data.other:
            raise InputError(f'{loop.run.name}: no column "{covariate}" for the covariate; {nearest(covariate, loop.data.other)}')
    measures = measures_of(model, [loop.data for loop in loops], with_films=bool(films))
    return Problem(
        model, films, loops, covariate=covariate if loops else "", own_zeros=own_zeros, changes=tuple(changes), measures=measures
    )


def loop_of(run: Run, model: Model) -> LoopRun:
    """A loop's table made ready; its time counts from its first sample, whatever the recorder's clock showed."""
    assert isinstance(run.table, Loop)
    return loop_run(run, model, prepare(replace(run.table, time_s=run.table.time_s - run.table.time_s[0])))


def film_of(run: Run, model: Model) -> Film:
    """A deployment's table made ready; `model` is the model as it was in this run."""
    table = run.table
    assert isinstance(table, Trajectory)
    require_plausible(run.name, table, model)
    channels = seen_channels(table)
    values = np.stack([table.channels[name] for name in channels])
    sigma = np.stack([channel_noise(table, name) for name in channels])
    stowed = 0.0 if model.geometry is None else model.geometry.stowed_height_m
    nominal = np.array([stowed if channel == "z_m" else 0.0 for channel in channels])
    values = values + _not_counted(values, sigma, nominal)[:, None]
    from_first_frame = bool(np.all(np.abs(values[:, 0] - nominal) < _ZEROED * sigma[:, 0]))
    zeroed = np.full(len(channels), from_first_frame)
    clock = _clock_s(table.time_s, values[channels.index("z_m")], model) if "z_m" in channels else 0.0
    time = table.time_s - clock
    expected = _onset_s(time, values[channels.index("z_m")]) if zeroed.any() and "z_m" in channels else 0.0
    by_onset = "z_m" in channels and (from_first_frame or clock != 0.0)
    return Film(run, model, time, channels, values, sigma, np.isfinite(values), nominal, zeroed, expected, clock, by_onset)


def _not_counted(values: Array, sigma: Array, nominal: Array) -> Array:
    """What a tracker that knows nothing of the rig left out of the elevation: its zero is then the first frame, not the ground."""
    from_zero = np.abs(values[:, 0]) < _ZEROED * sigma[:, 0]
    return np.where(from_zero & (np.abs(nominal) > _UNSET * _ZEROED * sigma[:, 0]), nominal, 0.0)


def _clock_s(time_s: Array, elevation_m: Array, model: Model) -> float:
    """What a clock showed at the release if it was never set by it; zero where it was, to within ten of its spreads."""
    onset = _onset_s(time_s, elevation_m)
    return onset if abs(onset) > _UNSET * max(model.nuisance.release_instant_s, _LEAST_SPREAD_S) else 0.0


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
