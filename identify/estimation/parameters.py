"""The unknowns of a problem: force law, releases and effects, each a number in units of its own scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identify.campaign.prepared import Film, LoopRun
from measure.common.arrays import Array
from simulate.model.effect import Effect
from simulate.model.model import LEGS, Model, per_leg

BASE = ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "beta_per_m", "initial_force_N")
POSE = (*(f"position_{axis}" for axis in "xyz"), *(f"theta_{axis}" for axis in "xyz"))
_WEAK = 4.0
_CAMERA_DISTANCE_M = 2.0  # a release nearer to the camera by its spread makes every length of the film longer by spread over distance


@dataclass(frozen=True)
class Knob:
    """One unknown: what it is called, its scale in its own unit, its prior spread in scales (inf: none), its bounds in scales."""

    name: str
    scale: float
    spread: float
    low: float
    high: float


def lines_of(model: Model) -> Array:
    """Force law of the actuator on the shaker, (5,) a_l, b_l, a_u, b_u, beta: the mean where the legs differ."""
    return np.array([float(np.mean(per_leg(getattr(model.actuator, name)))) for name in BASE[:5]])


def base_knobs(model: Model, loops: bool) -> list[Knob]:
    """The force law; from films alone its prior is weak but not absent, for it says what kind of spring it is."""
    law = lines_of(model)
    force = float(np.mean(np.abs(per_leg(model.actuator.initial_force_N)))) or 1.0
    stroke = 0.4 if model.geometry is None else model.geometry.deployed_height_m - model.geometry.stowed_height_m
    scales = (0.1 * force / stroke, 0.05 * force, 0.1 * force / stroke, 0.05 * force, 0.2 * law[4], 0.05 * force)
    spread = np.inf if loops else _WEAK
    lows = (-np.inf, -np.inf, -np.inf, -np.inf, -0.99 * law[4] / scales[4], -np.inf)
    spreads = (spread, spread, spread, spread, _WEAK, _WEAK)
    return [Knob(name, scale, s, low, np.inf) for name, scale, s, low in zip(BASE, scales, spreads, lows, strict=True)]


def release_knobs(film: Film) -> list[Knob]:
    """What a film's own release, its first frame and its scale may be off by."""
    spread = film.model.nuisance
    rows = list(zip(POSE, 3 * [spread.release_position_m] + 3 * [spread.release_theta_rad], strict=True))
    rows += [("instant", spread.release_instant_s)]
    rows += [(f"stored_force_{leg}", spread.stored_force_N) for leg in range(LEGS)]
    rows += [(f"datum_{film.channels[i]}", float(np.nanmedian(film.sigma[i]))) for i in np.flatnonzero(film.zeroed)]
    if film.zeroed.any():
        rows += [("scale", spread.release_position_m / _CAMERA_DISTANCE_M)]
    return [Knob(f"{film.run.name}:{name}", sd, 1.0, -np.inf, np.inf) for name, sd in rows if sd > 0]


def zero_knobs(loops: Sequence[LoopRun], model: Model) -> list[Knob]:
    """What a load cell that was set to zero anew may be off by in each loop; behind that, by how much it may drift over the record."""
    off = 0.05 * float(np.mean(np.abs(per_leg(model.actuator.initial_force_N)))) or 0.05
    zeros = [Knob(f"{loop.run.name}:zero_N", off, 1.0, -np.inf, np.inf) for loop in loops]
    drifts = [Knob(f"{loop.run.name}:drift_N_per_s", off / float(np.ptp(loop.data.time_s)), 1.0, -np.inf, np.inf) for loop in loops]
    return zeros + drifts


def effect_knobs(effect: Effect, model: Model, spread: float) -> list[Knob]:
    """The parameters of an effect within their bounds; zero is where the effect has them."""
    rows = zip(effect.flat_names(), effect.flat(), effect.typical(), effect.own_bounds(model).values(), strict=True)
    return [Knob(f"{effect.name}:{name}", t, spread, (low - value) / t, (high - value) / t) for name, value, t, (low, high) in rows]
