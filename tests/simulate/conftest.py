"""Rigs that the tests of the forward problem share."""

from math import cos, radians, sin
from typing import Any

import pytest

from simulate.effects import HubInertia, ViscousFriction
from simulate.model.model import (
    Actuator,
    EndStop,
    Geometry,
    Model,
    Platform,
    Release,
    Simulation,
)


def _ring(radius, angles_deg) -> Any:
    return tuple((radius * cos(radians(angle)), radius * sin(radians(angle)), 0.0) for angle in angles_deg)


def prototype_model(**changes):
    """The rig inferred from the paper's printed numbers."""
    base = _ring(0.5396, [angle for k in range(3) for angle in (120 * k + 57.0, 120 * (k + 1) - 57.0)])
    joints = _ring(0.030, [angle for k in range(3) for angle in (120 * k + 60 - 54.3, 120 * k + 60 + 54.3)])
    quantities: dict[str, Any] = {
        "actuator": Actuator(-0.0374, 2.79, -0.0374, 2.89, 400.0, 2.987),
        "name": "prototype",
        "platform": Platform(0.8, (0.0054, 0.0054, 0.00297)),
        "geometry": Geometry(base, joints),
        "end_stop": EndStop(3500.0, 22.6, 1e-3),
        "effects": (HubInertia(0.487), ViscousFriction(0.513)),
    }
    return Model(**{**quantities, **changes})


def lopsided_model(**changes):
    """A rig without any symmetry, turned and let go askew: every term of the mechanics has something to do."""
    base = ((0.41, 0.33, 0.01), (-0.02, 0.52, 0.0), (-0.47, 0.28, -0.02), (-0.40, -0.31, 0.0), (0.05, -0.55, 0.02), (0.49, -0.22, 0.0))
    joints = (
        (0.11, 0.02, 0.01),
        (0.06, 0.10, 0.0),
        (-0.08, 0.09, 0.0),
        (-0.12, -0.01, -0.01),
        (-0.04, -0.11, 0.0),
        (0.07, -0.08, 0.02),
    )
    quantities: dict[str, Any] = {
        "actuator": Actuator(
            a_l_N_per_m=(-0.1, -0.2, -0.05, 0.0, -0.3, -0.15),
            b_l_N=(2.7, 2.8, 2.75, 2.85, 2.9, 2.65),
            a_u_N_per_m=(-0.1, -0.25, -0.05, 0.1, -0.3, -0.15),
            b_u_N=(2.8, 2.9, 2.9, 2.95, 3.0, 2.75),
            beta_per_m=(300.0, 400.0, 350.0, 500.0, 450.0, 380.0),
            initial_force_N=(2.9, 2.85, 2.8, 2.95, 3.0, 2.7),
        ),
        "name": "lopsided",
        "platform": Platform(0.8, (0.004, 0.007, 0.009), (0.01, -0.006, 0.02)),
        "geometry": Geometry(base, joints),
        "end_stop": EndStop(2000.0, 3.0, 1e-3),
        "release": Release((0.004, -0.003, 0.002), (0.05, -0.03, 0.1), (0.02, 0.01, -0.03), (0.3, -0.2, 0.4)),
        "effects": (HubInertia(0.2), ViscousFriction(0.05)),
    }
    return Model(**{**quantities, **changes})


@pytest.fixture
def prototype():
    return prototype_model()


@pytest.fixture
def lopsided():
    return lopsided_model()


@pytest.fixture
def brief():
    """Long enough to start, too short for the stops."""
    return Simulation(duration_s=0.12)


@pytest.fixture(scope="session")
def prototype_once():
    return prototype_model()
