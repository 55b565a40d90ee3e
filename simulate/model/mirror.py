"""An effect in a mirror: a film taken square to the mirror hardly tells a rig that is its own mirror image from what is seen there."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.model.effect import Effect, EffectT
from simulate.model.rig import Geometry


def mirrored_effect(effect: EffectT, axis: int, geometry: Geometry) -> EffectT:
    """The effect as it acts in a mirror across an axis (0 for x, 1 for y); one without directions or legs of its own stays as it is."""
    return effect.with_flat(mirrored_values(type(effect), effect.flat(), axis, geometry))


def mirrored_values(kind: type[Effect], values: Array, axis: int, geometry: Geometry) -> Array:
    """Parameters of an effect laid flat, (n,), or what is off in each of them, in a mirror across an axis.

    What each parameter becomes is said where it is declared, see `parameter`: a shift changes its sign along the axis, a rotation about
    the two others, and what belongs to a leg belongs to the leg that stands where its image is.
    """
    place, made = 0, values.copy()
    for item in fields(kind):
        own = slice(place, place + (len(item.default) if isinstance(item.default, tuple) else 1))
        made[own], place = _turned(values[own], item.metadata.get("mirror", ""), axis, geometry), own.stop
    return made


def _turned(values: Array, how: str, axis: int, geometry: Geometry) -> Array:
    if how == "legs":
        return values[legs_in_mirror(geometry, axis)]
    if how == "joints":
        return (values.reshape(2, -1, 3)[:, legs_in_mirror(geometry, axis)] * _signs(axis)).ravel()
    return values * {"shift": _signs(axis), "rotation": -_signs(axis)}.get(how, 1.0)


def legs_in_mirror(geometry: Geometry, axis: int) -> NDArray[np.intp]:
    """For each leg the one that stands nearest to its image in a mirror across an axis, (6,)."""
    joints = np.hstack([geometry.base_joints_m, geometry.platform_joints_m])
    images = joints * np.tile(_signs(axis), 2)
    return np.argmin(np.linalg.norm(images[:, None] - joints, axis=2), axis=1)


def _signs(axis: int) -> Array:
    """What becomes of a shift, (3,)."""
    return np.where(np.arange(3) == axis, -1.0, 1.0)
