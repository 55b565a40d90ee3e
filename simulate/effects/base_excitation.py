"""The floor of the rig shakes."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from measure.common.arrays import Array
from simulate.model.effect import PlatformEffect, parameter
from simulate.model.rig import Rig
from simulate.model.wave import Wave

_FREQUENCIES_HZ = (*np.arange(1.0, 30.0, 0.75).tolist(), *np.arange(30.25, 61.0, 1.5).tolist())  # films of 0.6 s tell no closer ones apart


@dataclass(frozen=True)
class BaseExcitation(Wave, PlatformEffect):
    """A harmonic acceleration of the base along an axis; the motion is seen from the base, as by a camera that stands on it.

        F = -m a n sin(2 pi f t + phi)          at the centre of mass, n the axis, m the moving mass

    The axis is used as it stands: a unit vector makes `acceleration_m_per_s2` the amplitude.

    A loop does not show it. In a deployment: a ripple of one frequency lies over the channels along the axis, from the release on.
    """

    name = "base-excitation"
    constants = 1
    directions = ("axis",)
    summed = ("phase_rad", "axis")
    acceleration_m_per_s2: float = parameter(0.0, low=-50.0, high=50.0, typical=0.3, doc="amplitude of the base's acceleration, a")
    frequency_Hz: float = parameter(5.0, low=0.1, high=200.0, typical=5.0, starts=_FREQUENCIES_HZ, doc="frequency of the base's motion, f")
    phase_rad: float = parameter(0.0, low=-7.0, high=7.0, typical=0.5, starts=(0.0, 1.57), doc="phase at the release, phi")
    axis: tuple[float, ...] = parameter(
        (1.0, 0.0, 0.0),
        low=-1.0,
        high=1.0,
        typical=0.5,
        starts=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        doc="direction of the acceleration, n",
        mirror="shift",
    )

    def as_stated(self) -> BaseExcitation:
        """A positive amplitude, an axis of length one whose largest component is positive, and a phase within half a turn."""
        axis = np.asarray(self.axis)
        length = float(np.linalg.norm(axis))
        if length == 0.0:
            return self
        side = float(np.sign(axis[np.argmax(np.abs(axis))]))
        size = side * length * self.acceleration_m_per_s2
        phase = math.remainder(self.phase_rad + (math.pi if size < 0.0 else 0.0), 2.0 * math.pi)
        return replace(self, acceleration_m_per_s2=abs(size), phase_rad=phase, axis=tuple((side * axis / length).tolist()))

    def sum_of(self, shapes: Array, amounts: Array) -> BaseExcitation:
        """The motion along one axis that is nearest to several along different ones, which together may go round in an ellipse."""
        phases, axes = shapes[:, 2], shapes[:, 3:]
        directions, sizes, parts = np.linalg.svd((amounts[:, None] * axes).T @ np.column_stack([np.cos(phases), np.sin(phases)]))
        phase, axis = math.atan2(parts[0, 1], parts[0, 0]), tuple(directions[:, 0].tolist())
        return replace(self, acceleration_m_per_s2=float(sizes[0]), phase_rad=phase, axis=axis)

    def constants_of(self, model: Rig) -> tuple[float, ...]:
        """The moving mass, kg."""
        return (model.moving_mass_kg,)

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the inertia force to the wrench, N; p[6] is the moving mass."""
        force = p[6] * p[0] * math.sin(2.0 * math.pi * p[1] * t + p[2])
        for k in range(3):
            wrench[k] -= force * p[3 + k]
