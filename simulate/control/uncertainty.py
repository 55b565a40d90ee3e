"""What differs from one deployment to the next: stored forces, release, joints, stops. Drawn afresh, or at its corners."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from measure.common.arrays import Array
from simulate.model.model import Model
from simulate.model.rig import LEGS, geometry_of, per_leg

STOPS = {"halved": 0.5, "as given": 1.0, "doubled": 2.0}
"""What stiffness and damping of the stops are multiplied by: they decide on the rebound, and are rarely measured."""

_FAR = 2.0  # standard deviations of the release at a corner


@dataclass(frozen=True)
class Uncertainty:
    """How much of each: disparity is the share by which the stored force of a leg may be off, either way, evenly; the others are normal,
    one standard deviation for each axis and for each coordinate of each joint."""

    disparity: float
    release_position_m: float
    release_theta_rad: float
    joints_m: float

    def drawn(self, model: Model, runs: int, seed: int) -> Iterator[Model]:
        """So many rigs, each drawn by itself."""
        rng = np.random.default_rng([seed, 32])
        for _ in range(runs):
            even, normal = rng.uniform(-1.0, 1.0, LEGS), rng.standard_normal(6)
            yield self._changed(model, even, normal, rng.standard_normal((2, LEGS, 3)))

    def corners(self, model: Model, seed: int) -> Iterator[Model]:
        """All 64 combinations of largest and smallest stored force, each let go two standard deviations askew, with joints drawn."""
        rng = np.random.default_rng([seed, 64])
        for signs in product((-1.0, 1.0), repeat=LEGS):
            askew = _FAR * rng.choice((-1.0, 1.0), 6)
            yield self._changed(model, np.array(signs), askew, rng.standard_normal((2, LEGS, 3)))

    def _changed(self, model: Model, forces: Array, release: Array, joints: Array) -> Model:
        law, given, geometry = model.actuator, model.release, geometry_of(model)
        shift = self.disparity * forces * np.abs(per_leg(law.b_l_N))
        place = np.asarray(given.position_m) + self.release_position_m * release[:3]
        turn = np.asarray(given.theta_rad) + self.release_theta_rad * release[3:]
        moved = [_rows(np.asarray(p) + self.joints_m * d) for p, d in zip(_joints(model), joints, strict=True)]
        return replace(
            model,
            actuator=law.shifted(tuple(shift)),
            release=replace(given, position_m=tuple(place), theta_rad=tuple(turn)),
            geometry=replace(geometry, base_joints_m=moved[0], platform_joints_m=moved[1]),
        )


def with_stops(model: Model, factor: float) -> Model:
    """The model with stiffness and damping of its stops times a factor."""
    stop = model.end_stop
    harder = replace(stop, stiffness_N_per_m=factor * stop.stiffness_N_per_m, damping_N_s_per_m=factor * stop.damping_N_s_per_m)
    return replace(model, end_stop=harder)


def _joints(model: Model) -> tuple[Any, Any]:
    geometry = geometry_of(model)
    return geometry.base_joints_m, geometry.platform_joints_m


def _rows(points: Array) -> Any:
    return tuple(map(tuple, points.tolist()))
