"""What a film would show: exact to less than any film sees, in long steps in flight and short ones at the stops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.estimation.observation import RunRelease, View, _Pace, observe, observe_beside
from simulate.control.eddy_damper import EddyDamper
from simulate.effects import (
    CameraRoll,
    CentreOfMassOffset,
    GeometryError,
    HubInertia,
    LegDisparity,
    PlatformMass,
    ScaleError,
    SensorFilter,
    StopStiffness,
    ViscousFriction,
)
from simulate.kernel.speed_polynomials import with_rate_worked_in
from simulate.model.model import EndStop
from simulate.model.rig import Rate

FRAMES_S = np.arange(160) / 250.0
RELEASE = RunRelease((1e-3, -2e-3, 5e-4), (3e-3, -2e-3, 4e-3), 0.01)


@pytest.mark.parametrize("stop", [EndStop(1500.0, 3.0), EndStop(5000.0, 15.0), EndStop(4400.0, 45.0), EndStop(20000.0, 20.0)])
@pytest.mark.parametrize("effects", [(), (ViscousFriction(0.8),)])
def test_a_film_is_as_exact_as_steps_of_ten_microseconds(prototype, stop, effects):
    model = replace(prototype, end_stop=stop, effects=effects)
    seen = observe(View(model, FRAMES_S, RELEASE))
    fine = observe(View(replace(model, simulation=replace(model.simulation, step_s=1e-5)), FRAMES_S, RELEASE))
    assert np.max(seen["z_m"]) > 0.98 * model.geometry.deployed_height_m
    for channel in ("x_m", "y_m", "z_m"):
        assert np.max(np.abs(seen[channel] - fine[channel])) < 1e-6
    for channel in ("theta_x_rad", "theta_y_rad", "theta_z_rad"):
        assert np.max(np.abs(seen[channel] - fine[channel])) < 2e-5


def test_models_that_hardly_differ_take_the_steps_of_the_first_one(prototype):
    """So that their differences are those of the models, smooth in how far they are apart."""
    first = View(prototype, FRAMES_S, RELEASE)
    heavier = [
        replace(prototype, platform=replace(prototype.platform, mass_kg=prototype.platform.mass_kg * (1.0 + part)))
        for part in (0.0, 1e-6, 2e-6)
    ]
    same, one, two = observe_beside(first, [replace(first, model=model) for model in heavier])["z_m"]
    assert np.max(np.abs(same - observe(first)["z_m"])) < 1e-11
    assert np.max(np.abs((two - same) - 2.0 * (one - same))) < 0.02 * np.max(np.abs(one - same))


def slopes(model, longer):
    """What a millionth more of the platform's mass changes of a film, over that, (n,) for each channel."""
    first = View(model, FRAMES_S, RELEASE)
    heavier = replace(first, model=replace(model, platform=replace(model.platform, mass_kg=model.platform.mass_kg * (1.0 + 1e-6))))
    return {channel: 1e6 * (there - here) for channel, (here, there) in observe_beside(first, [first, heavier], longer=longer).items()}


@pytest.mark.parametrize("stop", [EndStop(1500.0, 3.0), EndStop(5000.0, 15.0), EndStop(20000.0, 20.0)])
@pytest.mark.parametrize("rate_Hz", [200.0, 500.0, 1000.0, 1900.0])
def test_slopes_in_longer_steps_are_exact_enough_to_go_uphill(prototype, stop, rate_Hz):
    """In flight to a millionth, and behind the stops to some hundredths, whatever the rate at which samples are kept."""
    model = replace(prototype, end_stop=stop, simulation=replace(prototype.simulation, sample_rate_Hz=rate_Hz))
    exact = slopes(replace(model, simulation=replace(model.simulation, sample_rate_Hz=2000.0, step_s=2e-5)), longer=False)
    found = slopes(model, longer=True)
    flight = int(np.argmax(observe(View(model, FRAMES_S, RELEASE))["z_m"] > 0.9 * model.geometry.deployed_height_m))
    assert 40 < flight < 150
    error = {channel: np.abs(values - exact[channel]) for channel, values in found.items()}
    for channel, of_flight in error.items():
        assert np.max(of_flight[:flight]) < 1e-6 * np.max(np.abs(exact[channel][:flight])), channel
    for channel, part in {"z_m": 0.002, "x_m": 0.1, "theta_z_rad": 0.1}.items():
        assert np.linalg.norm(error[channel]) < part * np.linalg.norm(exact[channel])


def test_steps_twice_as_long_are_divided_as_the_finer_of_their_two():
    one = _Pace(1e-3, np.array([1, 1, 1, 4, 7, 2, 3])).longer(1)
    assert (one.step_s, one.division.tolist(), one.fewer) == (2e-3, [1, 4, 7, 3], 2)
    two = _Pace(1e-3, np.array([1, 1, 1, 4])).longer(2)
    assert (two.step_s, two.division.tolist(), two.fewer) == (2e-3, [1, 4], 1)
    three = _Pace(1e-3, np.array([1, 1, 4]))
    assert three.longer(3) is three


@pytest.mark.parametrize("how", ["as stiff as is simulated", "steps given", "controlled"])
def test_no_steps_are_longer_where_they_are_as_long_as_may_be(prototype, how):
    model = {
        "as stiff as is simulated": replace(prototype, end_stop=EndStop(1e6, 20.0)),
        "steps given": replace(prototype, simulation=replace(prototype.simulation, step_s=5e-4)),
        "controlled": replace(prototype, controller=EddyDamper(damping_N_s_per_m=0.5)),
    }[how]
    usual, longer = (slopes(model, one)["z_m"] for one in (False, True))
    assert np.array_equal(usual, longer)
    assert not np.array_equal(slopes(prototype, longer=False)["z_m"], slopes(prototype, longer=True)["z_m"])


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("by_camera", [False, True])
def test_films_side_by_side_are_those_that_are_seen_one_by_one(prototype, turned, by_camera):
    """Whatever is worked in before a run (joints, masses, a stop, legs that differ), and whatever stands before the camera."""
    changes = [
        (GeometryError(tuple(1e-3 * np.sin(np.arange(36.0)))), PlatformMass(0.0)),
        (GeometryError(), PlatformMass(0.02)),
        (GeometryError(), PlatformMass(0.0), StopStiffness(0.5), HubInertia(0.01)),
        (LegDisparity((0.05, -0.03, 0.02, 0.0, -0.04, 0.01)), CentreOfMassOffset((1e-3, -2e-3, 1e-3))),
    ]
    cameras = [(ScaleError(0.01 * k), CameraRoll(0.02 / (k + 1))) if by_camera else () for k in range(len(changes))]
    models = [replace(prototype, effects=(*own, *camera)) for own, camera in zip(changes, cameras, strict=True)]
    views = [View(model, FRAMES_S, RELEASE, turned) for model in models]
    together = observe_beside(views[0], views)
    for k, view in enumerate(views):
        alone = {channel: values[0] for channel, values in observe_beside(views[0], [view]).items()}
        adjusted = replace(view, model=replace(view.model.adjusted(), effects=tuple(e for e in view.model.effects if e.acts_on != "model")))
        for channel, values in observe_beside(views[0], [adjusted]).items():
            assert np.array_equal(together[channel][k], alone[channel])
            assert np.array_equal(values[0], alone[channel])


@pytest.mark.parametrize("tau", [3e-4, 4e-3])
def test_a_slow_camera_sees_a_blow_between_its_frames_and_what_passes_while_frames_are_missing(prototype, tau):
    """The same as a camera of the same time constant with twenty thousand frames a second shows at these instants."""
    slow = replace(prototype, end_stop=EndStop(5000.0, 15.0), effects=(SensorFilter((0.0, tau)),))
    every, chance = np.arange(159 * 80 + 1) / 2e4, np.random.default_rng(3)
    frames = np.concatenate([[0], np.sort(chance.choice(np.arange(1, 160), 90, replace=False)) * 80])
    expected, seen = observe(View(slow, every, RELEASE)), observe(View(slow, every[frames], RELEASE))
    assert np.max(expected["z_m"]) > 0.98 * slow.geometry.deployed_height_m
    for channel in ("x_m", "y_m", "z_m"):
        assert np.max(np.abs(seen[channel] - expected[channel][frames])) < 5e-7


def test_what_changes_the_base_model_does_so_behind_a_table_of_rates(prototype):
    """A table gives every leg its force anew: what makes legs differ must come after it, or it would be lost."""
    law = replace(prototype.actuator, rate=Rate("speed_m_per_s", b_l=(2.79, 0.2)))
    legs, told = LegDisparity((0.3, 0.0, 0.0, 0.0, 0.0, 0.0)), replace(prototype, actuator=law)
    expected = observe(View(with_rate_worked_in(told).with_effect(legs), FRAMES_S, RELEASE))
    seen = observe(View(told.with_effect(legs), FRAMES_S, RELEASE))
    for channel, values in expected.items():
        assert seen[channel] == pytest.approx(values, abs=1e-9)
