"""A model laid flat for the compiled six-leg kernel: one row of numbers a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from simulate.control.control_loop import control_rows
from simulate.dispatch.formula_table import WITH_POWER, flat_parameters, formula_table
from simulate.dispatch.formulas import FormulaTable
from simulate.kernel.layout import (
    ANGULAR,
    CENTRE,
    INERTIA,
    LAW_SEED,
    LEG,
    LEG_SIZE,
    LEGS,
    MASS,
    PARAMETERS,
    POSITION,
    QUATERNION,
    STOP,
    VELOCITY,
    WEIGHT,
)
from simulate.kernel.speed_polynomials import with_rate_worked_in
from simulate.model.control import SampledController
from simulate.model.effect import Effect
from simulate.model.model import Model
from simulate.model.rig import Geometry, altered, geometry_of, leg_lengths

CONTROLLER = "controller"
"""Name of a controller among the effects whose work is accounted for."""


def row_of(model: Model) -> Array:
    """The row of a model: (PARAMETERS + number of effect parameters,), and behind them those of the controller.

    Effects that change the base model are worked in; of the others the parameters follow behind.

    Raises
    ------
    InputError
        The model has no geometry, or asymptotes that follow a cycling frequency of loops whose stroke is not known.
    """
    with np.errstate(all="ignore"):
        row = _row(with_rate_worked_in(model))
    if not np.all(np.isfinite(row)):
        raise InputError(f'model "{model.name}": some of its numbers are too large, or too small, to be computed with. Check them.')
    return row


def _row(model: Model) -> Array:
    at = model.adjusted()
    geometry = geometry_of(at)
    row = np.zeros(PARAMETERS)
    centre = np.asarray(at.platform.centre_of_mass_m)
    row[MASS : MASS + 3] = at.platform.mass_kg * at.gravity.mass_factor
    row[INERTIA : INERTIA + 3] = np.asarray(at.platform.inertia_kg_m2) * at.gravity.mass_factor
    row[WEIGHT + 2] = -at.platform.mass_kg * at.gravity.acceleration_m_per_s2
    row[CENTRE : CENTRE + 3] = centre
    _put_release(row, at, geometry, centre)
    row[STOP : STOP + 3] = at.end_stop.stiffness_N_per_m, at.end_stop.damping_N_s_per_m, at.end_stop.smoothing_m
    row[LEG:PARAMETERS] = _legs(at, geometry, centre, row).ravel()
    control = () if model.controller is None else (*model.controller.flat(), *model.controller.constants_of(at))
    return np.concatenate([row, flat_parameters(model.effects, at), control])


def without_idle(models: Sequence[Model]) -> list[Model]:
    """The models without the effects that are switched off in all of them, so that these cost nothing."""
    idle = {effect.name for effect in models[0].effects}
    for model in models:
        idle -= {effect.name for effect in model.effects if effect != _switched_off(type(effect))}
    if not idle:
        return list(models)
    return [altered(model, effects=tuple(effect for effect in model.effects if effect.name not in idle)) for model in models]


@cache
def _switched_off(kind: type[Effect]) -> Effect:
    return kind()


def formula_table_of(model: Model) -> FormulaTable:
    """The formulas that the row of this model is read by."""
    effects = with_rate_worked_in(model).effects
    table = formula_table(effects, PARAMETERS)
    if model.controller is None:
        return table
    return table._replace(control=control_rows(type(model.controller), PARAMETERS + len(flat_parameters(effects))))


def effects_with_power(model: Model) -> tuple[str, ...]:
    """Names of the effects whose formulas do work, in the order of the kernel's energy balance; one stands there once a formula."""
    effects = with_rate_worked_in(model).effects
    of_effects = tuple(effect.name for kind in WITH_POWER for effect in effects if getattr(type(effect), kind) is not None)
    return of_effects if model.controller is None else (*of_effects, CONTROLLER)


def seed_column(model: Model) -> int | None:
    """Where a row has the seed of its controller's noise; None where nothing is drawn."""
    controller = model.controller
    drawn = isinstance(controller, SampledController) and (controller.sensor_noise_m or controller.sensor_noise_rad)
    return len(row_of(replace(model, controller=None))) + LAW_SEED if drawn else None


def _put_release(row: Array, model: Model, geometry: Geometry, centre: Array) -> None:
    release = model.release
    quaternion = quaternion_of(np.asarray(release.theta_rad))
    arm = rotation_of(quaternion) @ centre
    angular = np.asarray(release.angular_velocity_rad_per_s)
    row[POSITION : POSITION + 3] = np.array([0.0, 0.0, geometry.stowed_height_m]) + release.position_m + arm
    row[QUATERNION : QUATERNION + 4] = quaternion
    row[VELOCITY : VELOCITY + 3] = release.velocity_m_per_s
    if angular.any():
        row[VELOCITY : VELOCITY + 3] += np.cross(angular, arm)
    row[ANGULAR : ANGULAR + 3] = angular


def _legs(model: Model, geometry: Geometry, centre: Array, row: Array) -> Array:
    base, joints, stowed, full = _drawn(geometry)
    if np.any(stowed <= 0) or np.any(full <= 0):
        leg = int(np.argmin(np.minimum(stowed, full))) + 1
        raise InputError(
            f'model "{model.name}": leg {leg} does not grow between stowed and deployed height. Check the joints and the heights.'
        )
    law, lowest = model.actuator, np.minimum(_lengths_at_release(row, base, joints - centre) - stowed, 0.0)
    made = np.empty((LEGS, LEG_SIZE))
    made[:, :3], made[:, 3:6] = base, joints - centre
    of_leg = (stowed, full, lowest, law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m, law.initial_force_N)
    for place, values in enumerate(of_leg, start=6):
        made[:, place] = values
    return made


@lru_cache(maxsize=64)
def _drawn(geometry: Geometry) -> tuple[Array, Array, Array, Array]:
    """Joints (6, 3) at base and platform, and the legs' lengths (6,) stowed and their strokes; most runs of a fit share them."""
    base, joints = np.asarray(geometry.base_joints_m), np.asarray(geometry.platform_joints_m)
    stowed = leg_lengths(base, joints, geometry.stowed_height_m)
    return base, joints, stowed, leg_lengths(base, joints, geometry.deployed_height_m) - stowed


def _lengths_at_release(row: Array, base: Array, arms: Array) -> Array:
    """Lengths (6,) of the legs at the release; the lower stop of a leg that is shorter than stowed stands where it is held."""
    turned = arms @ rotation_of(row[QUATERNION : QUATERNION + 4]).T
    return np.linalg.norm(row[POSITION : POSITION + 3] + turned - base, axis=1)


def quaternion_of(rotation_vector: Array) -> Array:
    """Unit quaternion (4,), scalar first, of a rotation vector (3,) in rad."""
    angle = float(np.linalg.norm(rotation_vector))
    half_sinc = 0.5 if angle < 1e-12 else math.sin(angle / 2) / angle
    return np.array([math.cos(angle / 2), *(half_sinc * np.asarray(rotation_vector))])


def rotation_of(quaternion: Array) -> Array:
    """Rotation matrix (3, 3), platform axes to world axes, of a unit quaternion (4,), scalar first."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
