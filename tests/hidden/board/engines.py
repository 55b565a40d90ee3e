"""What moves the platform and the shaker's actuator: the project's kernel at a fine step, or an engine that is not the project's."""

from __future__ import annotations

import numpy as np

from simulate.model import Model

from .bench import motions
from .camera import Motion
from .shaker import Stroke, kernel_force

Array = np.ndarray

FINE_STEP_S = 2e-5


def motion_by(engine: str, model: Model) -> Motion:
    """A deployment by this engine; the kernel with a step six times finer than that of a fit."""
    (motion,) = motions([model], FINE_STEP_S)
    return motion


def loop_by(engine: str, model: Model, stroke: Stroke, start_force_N: float) -> Array:
    """The force of an actuator on the shaker by this engine."""
    return kernel_force(model, stroke, start_force_N)
