"""Deployments that cannot be what their columns say: too few rows, another unit of length or time, counted downwards, too sure of itself.

A table is refused before any fit. What is compared with is the model at hand, with wide margins, never one rig.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.tables.checks import require_physical
from measure.tables.trajectory import Trajectory
from simulate.kernel.step_size import step_of, unhurried_step
from simulate.model.model import Model, stroke_of
from simulate.model.rig import per_leg

FEWEST_ROWS = 5  # in which a channel was seen; a fourth difference, from which its noise is read, takes as many
_MOST_STEPS = 300_000  # of the model, to follow a film; a fit follows it some thousand times
_FARTHEST = 20.0  # sizes of the rig, beyond which a length is in another unit
_TURNED = 0.2  # of the stroke, within which heights with the other sign fit the model
_TOO_SURE = 1e-12  # m or rad; nothing is measured so well
_FEWEST_IN_RISE = 0.1  # rows while the platform rises as the model does it


def require_plausible(name: str, table: Trajectory, model: Model) -> None:
    """Refuse a deployment that cannot be one of this model as its columns stand.

    Raises
    ------
    InputError
        All that is wrong, with what to do.
    """
    require_measured(name, table)
    _refuse(name, [*_other_unit(table, model), *_downwards(table, model), *_too_long(table, model)])


def require_measured(name: str, table: Trajectory) -> None:
    """Refuse a deployment that cannot have been measured as its columns stand, of whatever model.

    Raises
    ------
    InputError
        All that is wrong, with what to do.
    """
    require_physical(table.time_s, "time_s", name)
    for channel, values in table.channels.items():
        require_physical(values, channel, name)
    _refuse(name, [*_too_few(table), *_too_sure(table)])


def _refuse(name: str, wrong: Sequence[str]) -> None:
    if wrong:
        raise InputError("\n".join(f"{name}: {sentence}" for sentence in wrong))


def seen_channels(table: Trajectory) -> tuple[str, ...]:
    """Names of the channels in which enough was seen to be used."""
    return tuple(name for name, values in table.channels.items() if np.isfinite(values).sum() >= FEWEST_ROWS)


def _largest(values: Array) -> float:
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))


def _too_few(table: Trajectory) -> Iterator[str]:
    if not seen_channels(table):
        most = max(int(np.isfinite(values).sum()) for values in table.channels.values())
        yield f"{most} rows in which something was seen; a deployment needs at least {FEWEST_ROWS}. Give the whole film."


def _too_sure(table: Trajectory) -> Iterator[str]:
    for channel, sigma in table.sigma.items():
        last_digit = np.finfo(float).eps * _largest(table.channels[channel])
        least = max(_TOO_SURE, last_digit)
        if np.any(sigma < least):
            row = int(np.argmax(sigma < least))
            yield (
                f"line {row + 2}: sigma_{channel} is {sigma[row]:g}, and nothing is measured better than {least:.2g}. "
                "Give the true one, or leave the column away."
            )


def _other_unit(table: Trajectory, model: Model) -> Iterator[str]:
    if model.geometry is None:
        return
    joints = np.concatenate([np.asarray(model.geometry.base_joints_m), np.asarray(model.geometry.platform_joints_m)])
    size = abs(model.geometry.deployed_height_m) + float(np.max(np.abs(joints)))
    for channel in (name for name in seen_channels(table) if name.endswith("_m")):
        farthest = _largest(table.channels[channel])
        if farthest > _FARTHEST * size:
            yield f"{channel} goes to {farthest:.4g} m, and the rig has {size:.2g} m. If it is in mm, divide it by 1000."


def _downwards(table: Trajectory, model: Model) -> Iterator[str]:
    """Whether the heights fit the model with the other sign and not with their own."""
    if model.geometry is None or "z_m" not in seen_channels(table):
        return
    z = table.channels["z_m"][np.isfinite(table.channels["z_m"])]
    low, high = model.geometry.stowed_height_m, model.geometry.deployed_height_m
    near = _TURNED * (high - low)
    if low > near and abs(z[0] + low) < near and float(np.max(z)) < low - near:
        yield f"z_m begins at {z[0]:.4g} m and the model at {low:.4g} m: it is counted downwards. z points up; turn the sign of the column."
    elif abs(z[0]) < near and abs(float(np.min(z)) + high - low) < near and float(np.max(z)) < near:
        yield f"z_m falls by {-np.min(z):.4g} m where the model rises by {high - low:.4g} m. z points up; turn the sign of the column."


def _too_long(table: Trajectory, model: Model) -> Iterator[str]:
    if model.geometry is None:
        return
    time = table.time_s
    lasts, between = float(time[-1] - time[0]), float(np.median(np.diff(time)))
    steps = lasts / min(step_of(model), between)
    rise = _rise_s(model)
    if steps > _MOST_STEPS >= lasts / min(unhurried_step(), between):
        yield (
            f"to follow it the model takes {steps:.2g} steps, so stiff is it. Soften end_stop.stiffness_N_per_m "
            f"({model.end_stop.stiffness_N_per_m:g}) or an effect, or give a longer simulation.step_s."
        )
    elif steps > _MOST_STEPS or between > rise / _FEWEST_IN_RISE:
        yield (
            f"lasts {lasts:.4g} s with {between:.3g} s from row to row, and the model rises within {rise:.2g} s or so; to follow it takes "
            f"{steps:.2g} steps. If time_s is in ms, divide it by 1000; if the film is that long, cut it to the motion."
        )


def _rise_s(model: Model) -> float:
    """How long the legs take to raise the platform by their stroke if nothing holds it back, s; at a constant force s = F t^2 / (2 m)."""
    stroke = stroke_of(model)
    push = float(np.sum(np.abs(per_leg(model.actuator.b_l_N)) * stroke))
    if model.geometry is None or push == 0.0:
        return float("inf")
    rise = model.geometry.deployed_height_m - model.geometry.stowed_height_m
    return float(np.sqrt(2.0 * model.moving_mass_kg * rise**2 / push))
