"""A model laid flat for the compiled six-leg kernel: one row of numbers a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from simulate.control.control_loop import control_rows
from simulate.dispatch.formula_table import WITH_POWER, flat_parameters, formula_table
from simulate.dispatch.formulas import FormulaTable
from simulate.kernel.layout import (
    ANGULAR,
    CENTRE,
    FULL,
    INERTIA,
    LAW_SEED,
    LEG,
    LEG_SIZE,
    LEGS,
    LINE,
    LOWEST,
    MASS,
    PARAMETERS,
    POSITION,
    QUATERNION,
    STOP,
    STOWED,
    VELOCITY,
    WEIGHT,
)
from simulate.kernel.speed_polynomials import with_rate_worked_in
from simulate.model.control import SampledController
from simulate.model.effect import Effect
from simulate.model.model import Model
from simulate.model.rig import Geometry, Release, altered, geometry_of, leg_lengths

_OF_LAW = ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "beta_per_m", "initial_force_N")

CONTROLLER = "controller"
"""Name of a controller among the effects whose work is accounted for."""


def row_of(model: Model) -> Array:
    """The row of a model: (PARAMETERS + number of effect parameters,), and behind them those of the controller.

    Effects that change the base model are worked in; of the others the parameters follow behind.

    Raises
    ------
    InputError
        As `rows_of`.
    """
    return rows_of([model])[0]


def rows_of(models: Sequence[Model]) -> Array:
    """The rows of models that share effects and controller, one below the other.

    Raises
    ------
    InputError
        A model has no geometry, or asymptotes that follow a cycling frequency of loops whose stroke is not known.
    """
    with np.errstate(all="ignore"):
        rows = _rows([with_rate_worked_in(model) for model in models])
    finite = np.isfinite(rows).all(axis=1)
    if not finite.all():
        name = models[int(np.argmin(finite))].name
        raise InputError(f'model "{name}": some of its numbers are too large, or too small, to be computed with. Check them.')
    return rows


def _rows(models: Sequence[Model]) -> Array:
    at = [model.adjusted() for model in models]
    geometries, masses = [geometry_of(one) for one in at], np.array([[one.platform.mass_kg, one.gravity.mass_factor] for one in at])
    rows, centre = np.zeros((len(at), PARAMETERS)), np.array([one.platform.centre_of_mass_m for one in at])
    rows[:, MASS : MASS + 3] = np.prod(masses, axis=1, keepdims=True)
    rows[:, INERTIA : INERTIA + 3] = np.array([one.platform.inertia_kg_m2 for one in at]) * masses[:, 1:]
    rows[:, WEIGHT + 2] = -masses[:, 0] * np.array([one.gravity.acceleration_m_per_s2 for one in at])
    rows[:, CENTRE : CENTRE + 3] = centre
    _put_releases(rows, [one.release for one in at], np.array([one.stowed_height_m for one in geometries]), centre)
    stops = [one.end_stop for one in at]
    rows[:, STOP : STOP + 3] = [[stop.stiffness_N_per_m, stop.damping_N_s_per_m, stop.smoothing_m] for stop in stops]
    rows[:, LEG:PARAMETERS] = _legs(at, geometries, centre, rows).reshape(len(at), -1)
    return np.hstack([rows, np.array([_behind(model, one) for model, one in zip(models, at, strict=True)])])


def _behind(model: Model, at: Model) -> Array:
    """Parameters of the effects of a model, and of its controller, with the base model as the effects change it."""
    control = () if model.controller is None else (*model.controller.flat(), *model.controller.constants_of(at))
    return np.concatenate([flat_parameters(model.effects, at), control])


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


def _put_releases(rows: Array, releases: Sequence[Release], stowed_height: Array, centre: Array) -> None:
    # one by one: sines of arrays may differ in the last digit by where they stand
    quaternion = np.array([quaternion_of(np.asarray(release.theta_rad)) for release in releases])
    arm = np.einsum("nij,nj->ni", rotation_of(quaternion), centre)
    angular = np.array([release.angular_velocity_rad_per_s for release in releases])
    rows[:, POSITION : POSITION + 3] = np.array([release.position_m for release in releases]) + arm
    rows[:, POSITION + 2] += stowed_height
    rows[:, QUATERNION : QUATERNION + 4] = quaternion
    rows[:, VELOCITY : VELOCITY + 3] = np.array([release.velocity_m_per_s for release in releases])
    if angular.any():
        rows[:, VELOCITY : VELOCITY + 3] += np.cross(angular, arm)
    rows[:, ANGULAR : ANGULAR + 3] = angular


def _legs(models: Sequence[Model], geometries: Sequence[Geometry], centre: Array, rows: Array) -> Array:
    """The legs of models, (n, 6, LEG_SIZE)."""
    base, joints = (np.array([getattr(one, name) for one in geometries]) for name in ("base_joints_m", "platform_joints_m"))
    heights = (np.array([getattr(one, name) for one in geometries]) for name in ("stowed_height_m", "deployed_height_m"))
    stowed, deployed = (leg_lengths(base, joints, height) for height in heights)
    full, arms = deployed - stowed, joints - centre[:, None]
    if np.any(stowed <= 0) or np.any(full <= 0):
        first, leg = np.argwhere(np.minimum(stowed, full) <= 0)[0]
        raise InputError(
            f'model "{models[first].name}": leg {leg + 1} does not grow between stowed and deployed height. '
            "Check the joints and the heights."
        )
    made = np.empty((len(models), LEGS, LEG_SIZE))
    made[..., :3], made[..., 3:6], made[..., STOWED], made[..., FULL] = base, arms, stowed, full
    # The lower stop of a leg that is shorter than stowed at the release stands where it is held.
    turned = np.einsum("nij,nlj->nli", rotation_of(rows[:, QUATERNION : QUATERNION + 4]), arms)
    at_release = np.linalg.norm(rows[:, None, POSITION : POSITION + 3] + turned - base, axis=-1)
    made[..., LOWEST] = np.minimum(at_release - stowed, 0.0)
    for place, name in enumerate(_OF_LAW, start=LINE):
        values = [getattr(model.actuator, name) for model in models]
        made[..., place] = np.array([value if isinstance(value, tuple) else (value,) * LEGS for value in values])
    return made


def quaternion_of(rotation_vector: Array) -> Array:
    """Unit quaternion (4,), scalar first, of a rotation vector (3,) in rad."""
    angle = math.hypot(*rotation_vector)
    half_sinc = 0.5 if angle < 1e-12 else math.sin(angle / 2) / angle
    return np.array([math.cos(angle / 2), *(half_sinc * np.asarray(rotation_vector))])


def rotation_of(quaternion: Array) -> Array:
    """Rotation matrices (n, 3, 3), platform axes to world axes, of unit quaternions (n, 4), scalar first."""
    w, x, y, z = quaternion.T
    first = (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y))
    second = (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x))
    third = (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
    return np.array([first, second, third]).transpose(2, 0, 1)
