"""The rig as a model for MuJoCo, so that anybody can check a deployment in another engine."""

from __future__ import annotations

from collections.abc import Iterable
from xml.sax.saxutils import quoteattr

import numpy as np

from measure.common.errors import InputError
from simulate.effects.hub_inertia import HubInertia
from simulate.effects.viscous_friction import ViscousFriction
from simulate.kernel.model_rows import quaternion_of
from simulate.model.model import Model
from simulate.model.rig import geometry_of

_EXPRESSED = ("hub-inertia", "viscous-friction")


def mjcf_of(model: Model) -> str:
    """MJCF of the rig at its release: one free body, six legs as tendons, one motor along each.

    Platform, joints, gravity, hub inertia (tendon armature) and viscous friction (tendon damping) are expressed; the force
    law with its memory, the stops and other effects are not, so the user drives the six motors, `leg_1` to `leg_6`, in newtons.
    """
    at = model.adjusted()
    geometry, body = geometry_of(at), at.platform
    factor = at.gravity.mass_factor
    place = np.array([0.0, 0.0, geometry.stowed_height_m]) + at.release.position_m
    inertia, weight = np.array(body.inertia_kg_m2) * factor, at.gravity.acceleration_m_per_s2 / factor
    sites = "\n".join(f'    <site name="base_{i + 1}" pos={_row(p)}/>' for i, p in enumerate(geometry.base_joints_m))
    joints = "\n".join(f'      <site name="joint_{i + 1}" pos={_row(p)}/>' for i, p in enumerate(geometry.platform_joints_m))
    tendons = "\n".join(_tendon(at, leg) for leg in range(1, 7))
    motors = "\n".join(f'    <motor name="leg_{leg}" tendon="leg_{leg}"/>' for leg in range(1, 7))
    return f"""<mujoco model={quoteattr(at.name)}>
  <option integrator="RK4" timestep="0.0001" gravity="0 0 {-weight!r}"/>
  <worldbody>
{sites}
    <body name="platform" pos={_row(place)} quat={_row(quaternion_of(np.asarray(at.release.theta_rad)))}>
      <freejoint/>
      <inertial pos={_row(body.centre_of_mass_m)} mass="{body.mass_kg * factor!r}" diaginertia={_row(inertia)}/>
{joints}
    </body>
  </worldbody>
  <tendon>
{tendons}
  </tendon>
  <actuator>
{motors}
  </actuator>
</mujoco>
"""


def _tendon(model: Model, leg: int) -> str:
    inertia = float(model.effect(HubInertia).flat()[0])
    damping = float(model.effect(ViscousFriction).flat()[0])
    return (
        f'    <spatial name="leg_{leg}" armature="{inertia!r}" damping="{damping!r}">'
        f'<site site="base_{leg}"/><site site="joint_{leg}"/></spatial>'
    )


def _row(numbers: Iterable[float]) -> str:
    return '"' + " ".join(repr(float(v)) for v in numbers) + '"'


def require_expressed(model: Model) -> None:
    """Refuse a model that MuJoCo would refuse, or whose effects it would leave out without a word.

    Raises
    ------
    InputError
        An inertia that no body has, or the first effect that MJCF cannot express.
    """
    least, middle, most = sorted(model.platform.inertia_kg_m2)
    if least + middle < most:
        raise InputError(
            f'model "{model.name}": inertia {most:g} is above the sum of the other two, {least + middle:g} kg m2. '
            "No rigid body is like that and MuJoCo refuses it; change platform.inertia_kg_m2 before the export."
        )
    for effect in model.effects:
        if effect.acts_on not in ("model", "measurement") and effect.name not in _EXPRESSED:
            raise InputError(f'model "{model.name}": MJCF cannot express the effect "{effect.name}"; remove it before the export.')
