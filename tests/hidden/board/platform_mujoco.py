"""The six-leg platform in MuJoCo: legs as tendons with armature and damping, everything else driven from outside at every stage of RK4."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from simulate.deployment.mujoco_export import mjcf_of
from simulate.model.model import Model

from .camera import Motion
from .leg_law import Law
from .platform_ode import PlatformInBodyAxes, motion_of, skew

Array = np.ndarray

_STEP_S = 1e-4
_IN_THE_TENDONS = ("hub-inertia", "viscous-friction")


class Driver:
    """Motors of the legs and forces on the platform, from MuJoCo's own positions and speeds.

    The hysteretic force is the exact function of the way since the last whole step, a moving asymptote replaced by its chord.
    """

    def __init__(self, model: Model, data: Any) -> None:
        self.frame, self.law = PlatformInBodyAxes(model), Law(model, without=_IN_THE_TENDONS)
        self.force, self.u, self.v = self.law.first, *self.seen(data)
        self.carried = skew(-self.frame.centre)

    def seen(self, data: Any) -> tuple[Array, Array]:
        """Elongation and its rate, (6,) each."""
        return data.ten_length - self.frame.stowed, data.ten_velocity.copy()

    def stored(self, u: Array, v: Array) -> list[float]:
        """R of each leg at the end of a monotone way from the last whole step."""
        legs = zip(range(6), self.force, self.u.tolist(), self.v.tolist(), u.tolist(), v.tolist(), strict=True)
        return [self._stored(*leg) for leg in legs]

    def _stored(self, leg: int, force: float, u_0: float, v_0: float, u: float, v: float) -> float:
        out = u > u_0
        start, end = self.law.ahead(leg, out, u_0, v_0), self.law.ahead(leg, out, u, v)
        x = self.law.beta[leg] * abs(u - u_0) + 1e-300
        faded = math.exp(-x)
        return end + (force - start) * faded - (end - start) * (1.0 - faded) / x

    def drive(self, _: Any, data: Any) -> None:
        """What MuJoCo calls at every stage."""
        u, v = self.seen(data)
        stored = np.array(self.stored(u, v))
        data.ctrl[:] = stored + self.law.added(u, v, data.time, stored) + self.frame.stops(data.ten_length.tolist(), v.tolist())
        if self.frame.pushes or self.frame.outside:
            data.xfrc_applied[1] = self.frame.wrench(data.time, data.xipos[1], self._speed(data))

    def _speed(self, data: Any) -> Array:
        """Of the centre of mass: a free joint's speed is that of its frame, its rotation in body axes."""
        return data.qvel[:3] + data.xmat[1].reshape(3, 3) @ (self.carried @ data.qvel[3:6])

    def settle(self, data: Any) -> None:
        """A whole step is done."""
        u, v = self.seen(data)
        self.force, self.u, self.v = self.stored(u, v), u, v


def moved_by_mujoco(model: Model, times: Array) -> Motion:
    """A deployment in MuJoCo, RK4 at a tenth of a millisecond."""
    import mujoco

    engine: Any = mujoco
    rig = engine.MjModel.from_xml_string(mjcf_of(model))
    data = engine.MjData(rig)
    rig.opt.timestep = _STEP_S
    release = model.adjusted().release  # MJCF says where a body is, not how fast
    data.qvel[:3] = release.velocity_m_per_s
    engine.mj_forward(rig, data)
    data.qvel[3:] = data.xmat[1].reshape(3, 3).T @ np.asarray(release.angular_velocity_rad_per_s)
    engine.mj_forward(rig, data)
    driver = Driver(model, data)
    every = round((times[1] - times[0]) / _STEP_S)
    poses = np.empty((len(times), 7))
    engine.set_mjcb_control(driver.drive)
    try:
        for i in range(len(times)):
            poses[i] = data.qpos
            for _ in range(every):
                engine.mj_step(rig, data)
                engine.mj_fwdPosition(rig, data)
                engine.mj_fwdVelocity(rig, data)
                driver.settle(data)
    finally:
        engine.set_mjcb_control(None)
    return motion_of(times, poses[:, :3], poses[:, 3:])
