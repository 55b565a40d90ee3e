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
POSE = (*(f"position_{axis}_m" for axis in "xyz"), *(f"theta_{axis}_rad" for axis in "xyz"))
_WEAK = 4.0
_CAMERA_DISTANCE_M = 2.0  # a release nearer to the camera by its spread makes every length of the film longer by spread over distance


@dataclass(frozen=True)
class Parameter:
    """One unknown: a number in units of its own scale, zero where the model file has it.

    name : as users see it: `beta_per_m`, `hub-inertia.mass_kg`, `test2.release.theta_z_rad`, `loop-1Hz.zero_N`.
    scale : in its own unit. spread : one standard deviation of its prior, in scales; infinite where there is none.
    low, high : bounds, in scales. run : the run whose own it is, nothing where it is common to all.
    """

    name: str
    scale: float
    spread: float
    low: float
    high: float
    run: str = ""

    @property
    def key(self) -> str:
        """The last part of the name: what it is, without whose."""
        return self.name.rpartition(".")[2]


def lines_of(model: Model) -> Array:
    """Force law of the actuator on the shaker, (5,) a_l, b_l, a_u, b_u, beta: the mean where the legs differ."""
    return np.array([float(np.mean(per_leg(getattr(model.actuator, name)))) for name in BASE[:5]])


def base_parameters(model: Model, loops: bool) -> list[Parameter]:
    """The force law; from films alone its prior is weak but not absent, for it says what kind of spring it is."""
    law = lines_of(model)
    force = float(np.mean(np.abs(per_leg(model.actuator.initial_force_N)))) or 1.0
    stroke = 0.4 if model.geometry is None else model.geometry.deployed_height_m - model.geometry.stowed_height_m
    scales = (0.1 * force / stroke, 0.05 * force, 0.1 * force / stroke, 0.05 * force, 0.2 * law[4], 0.05 * force)
    spread = np.inf if loops else _WEAK
    lows = (-np.inf, -np.inf, -np.inf, -np.inf, -0.99 * law[4] / scales[4], -np.inf)
    spreads = (spread, spread, spread, spread, _WEAK, _WEAK)
    return [Parameter(name, scale, s, low, np.inf) for name, scale, s, low in zip(BASE, scales, spreads, lows, strict=True)]


def release_parameters(film: Film) -> list[Parameter]:
    """What a film's own release, its first frame and its scale may be off by."""
    spread = film.model.nuisance
    rows = list(zip(POSE, 3 * [spread.release_position_m] + 3 * [spread.release_theta_rad], strict=True))
    rows += [("instant_s", spread.release_instant_s)]
    rows += [(f"stored_force_N[{leg}]", spread.stored_force_N) for leg in range(LEGS)]
    rows = [(f"release.{key}", sd) for key, sd in rows]
    rows += [(f"first_frame_{film.channels[i]}", float(np.nanmedian(film.sigma[i]))) for i in np.flatnonzero(film.zeroed)]
    if film.zeroed.any():
        rows += [("length_scale", spread.release_position_m / _CAMERA_DISTANCE_M)]
    return [Parameter(f"{film.run.label}.{name}", sd, 1.0, -np.inf, np.inf, film.run.name) for name, sd in rows if sd > 0]


def zero_parameters(loops: Sequence[LoopRun], model: Model) -> list[Parameter]:
    """What a load cell that was set to zero anew may be off by in each loop; behind that, by how much it may drift over the record."""
    off = 0.05 * float(np.mean(np.abs(per_leg(model.actuator.initial_force_N)))) or 0.05
    drifts = [off / float(np.ptp(loop.data.time_s)) for loop in loops]
    rows = [(loop, "zero_N", off) for loop in loops] + [(loop, "drift_N_per_s", sd) for loop, sd in zip(loops, drifts, strict=True)]
    return [Parameter(f"{loop.run.label}.{key}", sd, 1.0, -np.inf, np.inf, loop.run.name) for loop, key, sd in rows]


def effect_parameters(effect: Effect, model: Model, spread: float) -> list[Parameter]:
    """The parameters of an effect within their bounds; zero is where the effect has them."""
    rows = zip(effect.flat_names(), effect.flat(), effect.typical(), effect.own_bounds(model).values(), strict=True)
    return [Parameter(f"{effect.name}.{name}", t, spread, (low - value) / t, (high - value) / t) for name, value, t, (low, high) in rows]
