"""Steps that are divided where a leg runs into a stop."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from simulate.deployment.deploy import deploy, deploy_many, deploy_with_division
from simulate.files.model_file import read_model
from simulate.kernel.step_division import MOST_PARTS
from simulate.model.model import Simulation

PROTOTYPE = Path(__file__).resolve().parents[3] / "datasets" / "prototype.toml"


@pytest.fixture
def model():
    return replace(read_model(PROTOTYPE), simulation=Simulation(0.6, 1000.0, 5e-4))


def with_step(model, step_s):
    return replace(model, simulation=replace(model.simulation, step_s=step_s))


def worst_m(run, exact):
    return np.max(np.abs(run.channels["z_m"] - exact.channels["z_m"]))


def test_divided_steps_are_as_exact_as_steps_many_times_finer(model):
    """The other engine's part is taken by the same one with even steps of 5 us."""
    exact = deploy(with_step(model, 5e-6))
    divided, pace = deploy_with_division(model)
    assert worst_m(divided, exact) < 0.2 * worst_m(deploy(model), exact)
    assert worst_m(divided, exact) < worst_m(deploy(with_step(model, 1.25e-4)), exact)
    assert pace.sum() < 1.1 * len(pace)


def test_only_steps_into_a_stop_are_divided(model):
    run, pace = deploy_with_division(model)
    full = model.geometry.deployed_height_m
    before = np.flatnonzero(run.channels["z_m"] < 0.9 * full)
    rising = before[(before > 50) & (before < np.argmax(run.channels["z_m"] > 0.95 * full))]
    assert np.all(pace.reshape(-1, 2)[rising] == 1)
    assert 1 < pace.max() <= MOST_PARTS


def test_a_run_that_follows_itself_is_the_same_to_the_last_digit_alone_and_among_others(model):
    ahead, pace = deploy_with_division(model)
    others = [replace(model, platform=replace(model.platform, mass_kg=1.0 + 0.01 * k)) for k in range(20)]
    for crowd in ([model], [model, *others]):
        assert np.array_equal(deploy_many(crowd, pace)[0].samples, ahead.samples, equal_nan=True)


def test_behind_the_end_of_a_pace_steps_are_whole(model):
    ahead, pace = deploy_with_division(model)
    longer = replace(model, simulation=replace(model.simulation, duration_s=0.65))
    assert np.array_equal(deploy_many([longer], pace)[0].samples[: len(ahead.samples)], ahead.samples)
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(deploy_many([model], pace[:400])[0].samples, ahead.samples, rtol=0, atol=1e-12)
