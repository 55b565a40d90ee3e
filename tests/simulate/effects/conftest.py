"""A platform on which nothing acts but what a test adds."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simulate.model.model import EndStop, Geometry, Simulation


@pytest.fixture
def free(prototype):
    """A platform without forces and stops, its six legs joined at its centre: it flies and spins as it was let go."""
    ring: Any = tuple((0.5 * float(np.cos(a)), 0.5 * float(np.sin(a)), 0.0) for a in np.arange(6) * np.pi / 3)
    none = replace(prototype.actuator, a_l_N_per_m=0.0, b_l_N=0.0, a_u_N_per_m=0.0, b_u_N=0.0, initial_force_N=0.0)
    centre: Any = ((0.0, 0.0, 0.0),) * 6
    geometry = Geometry(ring, centre)
    quiet = replace(prototype, actuator=none, end_stop=EndStop(0.0, 0.0))
    return replace(quiet, geometry=geometry, effects=(), simulation=Simulation(0.3, 200.0))
