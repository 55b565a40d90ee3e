"""The platform was not quite where it should have been when it was let go."""

from __future__ import annotations

from dataclasses import dataclass

from simulate.model.effect import ModelEffect, RigT, parameter
from simulate.model.rig import altered


@dataclass(frozen=True)
class ReleasePose(ModelEffect):
    """Position, rotation and velocity at the release differ from the model's, in every run alike.

    What differs from run to run is a nuisance of the model file; this is the part that stays.

    A loop does not show it. In a deployment: channels begin elsewhere or with a slope; what is unstable grows from there.
    """

    name = "release-pose"
    position_m: tuple[float, ...] = parameter(
        (0.0,) * 3, low=-0.1, high=0.1, typical=0.002, doc="shift of the release position, world axes", mirror="shift"
    )
    theta_rad: tuple[float, ...] = parameter(
        (0.0,) * 3, low=-0.5, high=0.5, typical=0.005, doc="rotation vector at the release", mirror="rotation"
    )
    velocity_m_per_s: tuple[float, ...] = parameter(
        (0.0,) * 3, low=-1.0, high=1.0, typical=0.005, doc="velocity at the release", mirror="shift"
    )

    def adjust(self, model: RigT) -> RigT:
        """The model released elsewhere."""
        at = model.release
        moved = altered(
            at,
            position_m=_sum(at.position_m, self.position_m),
            theta_rad=_sum(at.theta_rad, self.theta_rad),
            velocity_m_per_s=_sum(at.velocity_m_per_s, self.velocity_m_per_s),
        )
        return altered(model, release=moved)


def _sum(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(x + y for x, y in zip(a, b, strict=True))
