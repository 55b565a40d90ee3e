"""What was put into made measurements comes out of a fit, within three of its standard errors."""

from pathlib import Path

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.estimation.least_squares import solve, to_the_end
from simulate import effects as known
from simulate.files.model_file import read_model

LOOPS = ((0.2, 0.01), (1.0, 0.04), (3.0, 0.02))


def recovered(folder: Path, shape):
    """The effect fitted from a shape, or where it is not linear from a size, its parameters in their units, and their standard errors."""
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    base = solve(problem)
    fit = to_the_end(solve(problem.with_another(shape), np.append(base.q, np.zeros(len(shape.flat())))))
    own = slice(problem.first_effect, None)
    scales = np.array([one.scale for one in fit.problem.parameters[own]])
    covariance = np.linalg.inv(fit.jacobian.T @ fit.jacobian)
    return shape.flat() + scales * fit.q[own], scales * np.sqrt(np.diag(covariance))[own]


@pytest.mark.parametrize(
    ("truth", "shape"),
    [
        (known.SeriesPlay(1.1e-3), known.SeriesPlay()),
        (known.EddyDamping(0.4, 0.12), known.EddyDamping(0.0, 0.1)),
        (known.Ripple(0.01, 0.0235, 0.9), known.Ripple(0.0, 1 / 44)),
    ],
    ids=lambda effect: effect.name,
)
def test_an_effect_in_loops_is_recovered(campaign, truth, shape):
    values, errors = recovered(campaign(truth, 271, loops=LOOPS, deployments=(), loop_steps=12_000), shape)
    assert np.all(np.abs(values - truth.flat()) < 3.0 * errors)
    assert np.all(errors < 0.1 * np.abs(truth.flat()))


@pytest.mark.parametrize(
    ("truth", "shape"),
    [
        (known.SeriesPlay(1.1e-3), known.SeriesPlay()),
        pytest.param(known.EddyDamping(0.4, 0.12), known.EddyDamping(0.0, 0.1), marks=pytest.mark.calibrate),
        pytest.param(known.Ripple(0.01, 0.0235, 0.9), known.Ripple(0.0, 1 / 44), marks=pytest.mark.calibrate),
        (known.SensorFilter((2e-3, 3e-3)), known.SensorFilter((0.005, 0.005))),
        (known.LensDistortion(-0.05, 0.42), known.LensDistortion(0.0, 0.35)),
        (known.FlexibleBase(20.0, 15.0, 0.02), known.FlexibleBase(20.0, 13.5, 0.03)),
    ],
    ids=lambda effect: effect.name,
)
def test_an_effect_in_deployments_is_recovered(campaign, truth, shape):
    values, errors = recovered(campaign(truth, 272, loops=LOOPS, deployments=({}, {"platform.mass_kg": 1.0})), shape)
    assert np.all(np.abs(values - truth.flat()) < 3.0 * errors)
    assert np.all(errors < 0.1 * np.abs(truth.flat()))
