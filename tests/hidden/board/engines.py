"""What moves the platform and the shaker's actuator: the project's kernel at a fine step, or an engine that is not the project's."""

from __future__ import annotations

import numpy as np

from simulate.model.model import Model

from .bench import DURATION_S, motions
from .camera import Motion
from .shaker import Stroke, kernel_force

Array = np.ndarray

FINE_STEP_S = 2e-5  # 25 times finer than that of a fit


def motion_by(engine: str, model: Model, duration_s: float = DURATION_S) -> Motion:
    """A deployment by this engine: kernel, ode (scipy's DOP853 on a right-hand side of its own) or mujoco."""
    if engine == "kernel":
        (motion,) = motions([model], FINE_STEP_S, duration_s)
        return motion
    times = np.arange(round(duration_s * 1000.0) + 1) / 1000.0
    if engine == "mujoco":
        from .platform_mujoco import moved_by_mujoco

        return moved_by_mujoco(model, times)
    from .platform_ode import moved_by_ode

    return moved_by_ode(model, times)


def loop_by(engine: str, model: Model, stroke: Stroke, start_force_N: float) -> Array:
    """The force of an actuator on the shaker: by the project's law, or by LSODA on its differential form."""
    if engine == "kernel":
        return kernel_force(model, stroke, start_force_N)
    from .leg_law import loop_by_ode

    return loop_by_ode(model, stroke.time_s, stroke.u, stroke.v, stroke.a, start_force_N)
