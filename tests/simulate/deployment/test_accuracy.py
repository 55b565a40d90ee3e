"""The error that a deployment states for itself, against a step sixteen times as fine."""

import math
from dataclasses import replace

import numpy as np
import pytest

from measure.tables.trajectory import CHANNELS
from simulate.deployment.deploy import deploy, deploy_checked
from simulate.model.model import EndStop, Simulation


def stated(run):
    assert run.step_error is not None
    return run.step_error


def with_step(model, step_s):
    return replace(model, simulation=replace(model.simulation, step_s=step_s))


@pytest.mark.parametrize("forces", [(0.2, -0.1, 0.05, 0.0, 0.1, -0.2), (0.279, -0.279, 0.0, 0.0, 0.0, 0.0)])
def test_the_stated_error_bounds_the_true_one_over_stops_and_rebound(prototype, forces):
    run = deploy_checked(replace(prototype, actuator=prototype.actuator.shifted(forces)))
    exact = deploy(with_step(run.model, run.step_s / 16))
    for name in CHANNELS:
        true = np.max(np.abs(run.channels[name] - exact.channels[name]))
        assert true <= stated(run).whole[name] + 1e-12
        assert stated(run).to_the_stops[name] <= stated(run).whole[name]


def test_the_step_is_halved_where_the_first_one_is_too_coarse_and_kept_where_the_model_gives_it(prototype):
    # every second leg stronger on one side of the rig: the platform tilts, and the tilt grows
    law = prototype.actuator.shifted((0.279, 0.279, 0.0, 0.0, -0.279, -0.279))
    model = replace(prototype, actuator=law, end_stop=replace(prototype.end_stop, smoothing_m=1e-5))
    assert deploy(model).step_s == 5e-4
    assert not stated(deploy_checked(with_step(model, 5e-4))).fine
    run = deploy_checked(model)
    assert run.step_s < 5e-4
    np.testing.assert_array_equal(run.samples, deploy(with_step(model, run.step_s)).samples)


def test_a_run_that_diverges_with_one_step_only_is_off_by_infinity(prototype):
    hard = replace(prototype, end_stop=EndStop(2e6, 1.0), simulation=Simulation(1.0, 250.0, 4e-3))
    run = deploy_checked(hard)
    assert run.diverged_at_s is not None
    assert math.isinf(stated(run).whole["z_m"])
    assert stated(run).to_the_stops["z_m"] < 1e-3
