"""The joints do not stand where the model file has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from simulate.model.effect import ModelEffect, RigT, parameter
from simulate.model.measures import PROTOTYPE, Measures
from simulate.model.rig import Rig, altered

_HALF = 18
_TOLERANCES = 3.0


@dataclass(frozen=True)
class GeometryError(ModelEffect):
    """Each coordinate of each joint is off by a constant: the six base joints first, then the six of the platform.

        A_i = A_i,model + p_i          B_i = B_i,model + p_(6 + i)

    What 36 coordinates can do to a film is much; what they do within a drawing's tolerance is little, and is what a search allows them.

    A loop does not show it. In a deployment: small smooth drifts of every channel, the largest sideways, other ones in each direction.
    """

    name = "geometry-error"
    position_m: tuple[float, ...] = parameter(
        (0.0,) * (2 * _HALF),
        low=-0.1,
        high=0.1,
        typical=3e-4,
        doc="shift of x, y, z of each base joint, then of each platform joint",
        mirror="joints",
    )

    def prior_spread(self, model: Rig, measures: Measures = PROTOTYPE) -> float:
        """A few tolerances of the drawing: 36 free coordinates would follow anything."""
        usual = float(self.typical(measures)[0])
        return _TOLERANCES * (model.nuisance.joints_m or usual) / usual

    def adjust(self, model: RigT) -> RigT:
        """The model with its joints elsewhere; one without geometry stays as it is."""
        if model.geometry is None or not any(self.position_m):
            return model
        base, platform = self.position_m[:_HALF], self.position_m[_HALF:]
        at = model.geometry
        moved = altered(at, base_joints_m=_moved(at.base_joints_m, base), platform_joints_m=_moved(at.platform_joints_m, platform))
        return altered(model, geometry=moved)


def _moved(joints: Any, shift: tuple[float, ...]) -> Any:
    return tuple(tuple(row) for row in (np.asarray(joints) + np.reshape(shift, (6, 3))).tolist())
