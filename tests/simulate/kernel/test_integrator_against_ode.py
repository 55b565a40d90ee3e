"""The compiled platform against a right-hand side written again, in NumPy, with the hysteretic force as a state.

That right-hand side also moves the platform of the hidden cases; with every effect of the catalogue that it knows it is held against the
kernel in `tests/hidden/test_engines.py`.
"""

from dataclasses import replace

import numpy as np
import pytest
from board.platform_ode import PlatformInBodyAxes, moved_by_ode
from scipy.spatial.transform import Rotation

from simulate.deployment.deploy import deploy
from simulate.model.model import Simulation


@pytest.mark.parametrize("moving", [False, True])
def test_deployment_up_to_the_stops_agrees_with_dop853(lopsided, moving):
    # without velocity at the release every leg uncoils throughout; with it some legs reverse, and a fixed step
    # that runs across a reversal is of lower order there
    still = replace(lopsided.release, velocity_m_per_s=(0.0,) * 3, angular_velocity_rad_per_s=(0.0,) * 3)
    model = replace(lopsided, release=lopsided.release if moving else still, simulation=Simulation(0.25, 200.0, 1e-4))
    run = deploy(model)
    platform = PlatformInBodyAxes(model)
    assert np.all(run.elongation_m < platform.full - platform.stowed)
    solved = moved_by_ode(model, run.time_s)
    ours = Rotation.from_quat(run.samples[:, 3:7], scalar_first=True)
    apart = (ours * Rotation.from_quat(solved.quaternion, scalar_first=True).inv()).magnitude()
    ours_place = np.column_stack([run.channels[name] for name in ("x_m", "y_m", "z_m")])
    bound = 1e-6 if moving else 1e-9
    assert np.max(np.abs(ours_place - solved.place_m)) < bound
    assert np.max(apart) < bound
    assert np.max(np.abs(run.channels["theta_z_rad"])) > 0.1, "nothing turned, nothing was tested"
