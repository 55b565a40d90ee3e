"""Controllers in a sweep, computed for all runs of a block at once in long steps, against single deployments in short ones."""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest
from pydantic.dataclasses import dataclass

from simulate.control.catalogue import known_laws
from simulate.control.eddy_damper import EddyDamper
from simulate.control.mechanical_link import MechanicalLink
from simulate.control.one_way import OneWay
from simulate.control.profile import Profile
from simulate.control.synchronise import Synchronise
from simulate.deployment.deploy import deploy
from simulate.dispatch.lane_forms import form_for_all
from simulate.kernel.step_size import pace_of
from simulate.model import responses
from simulate.model.control import Controller, SampledController
from simulate.model.model import Simulation
from simulate.model.rig import CHECKED, NotNegative
from simulate.sweeps.sweep import responses_of

REAL: dict[str, Any] = {"sample_rate_Hz": 1000.0, "delay_s": 0.002, "lag_s": 0.005, "sensor_noise_m": 1e-4, "observer_Hz": 40.0}
IDEAL = Synchronise(stiffness_N_per_m=1000.0, damping_N_s_per_m=20.0, force_limit_N=1.0)
EVERY = {
    "ideal brakes": IDEAL,
    "ideal motors": replace(IDEAL, actuator="motor"),
    "an ideal camera": replace(IDEAL, sensor="camera", stiffness_N_per_m=4000.0),
    "sampled brakes": replace(IDEAL, **REAL),
    "steps and differences": replace(IDEAL, sample_rate_Hz=500.0, sensor_step_m=1e-4, actuator="motor"),
    "a camera": replace(IDEAL, sensor="camera", sample_rate_Hz=250.0, delay_s=0.008, sensor_noise_rad=1e-3, sensor_step_rad=1e-4),
    "a failed brake": replace(IDEAL, failed_brake=2, stuck_force_N=0.8, failure_s=0.05),
    "a failed sensor": replace(IDEAL, **REAL, failed_sensor=5, failure_s=0.08),
    "profile": Profile(duration_s=0.8, stiffness_N_per_m=500.0, damping_N_s_per_m=20.0, force_limit_N=5.0, **REAL),
    "one-way": OneWay(clutch_force_N=3.0),
    "eddy-damper": EddyDamper(damping_N_s_per_m=2.0, critical_speed_m_per_s=0.8),
    "link": MechanicalLink(stiffness_N_per_m=2000.0, damping_N_s_per_m=5.0, shaft_mass_kg=0.3),
}


def disparate(rig, controller, forces=(0.2, -0.1, 0.15, -0.2, 0.1, 0.0), duration=0.8):
    return replace(rig, actuator=rig.actuator.shifted(forces), controller=controller, simulation=Simulation(duration, 1000.0))


@pytest.mark.parametrize("name", EVERY)
def test_long_steps_find_what_short_ones_of_a_single_deployment_find(prototype, name):
    model = disparate(prototype, EVERY[name])
    (found,) = responses_of([model])
    run = deploy(replace(model, simulation=Simulation(0.8, 1000.0, 6.25e-5)))
    theta = run.channels["theta_z_rad"]
    assert np.degrees(found[responses.THETA_Z]) == pytest.approx(np.degrees(theta[np.argmax(np.abs(theta))]), abs=0.01, rel=2e-4)
    assert found[responses.CONTROL_FORCE] == pytest.approx(np.max(np.abs(run.control_force_N)), rel=0.02)
    assert found[responses.CONTROL_ENERGY] == pytest.approx(-run.effects_J["controller"][-1], rel=0.01, abs=1e-3)


@pytest.mark.parametrize("name", ["ideal brakes", "ideal motors", "eddy-damper"])
def test_a_controller_without_sampling_keeps_the_long_steps_of_flight(prototype, name):
    assert pace_of(disparate(prototype, EVERY[name])).frame == pace_of(prototype).frame


@pytest.mark.parametrize(
    "controller",
    [
        OneWay(clutch_force_N=10.0),
        replace(EVERY["profile"], sample_rate_Hz=None, delay_s=0.0, lag_s=0.0, sensor_noise_m=0.0, observer_Hz=None),
    ],
)
def test_dry_friction_shortens_steps_near_rest_only(prototype, controller):
    pace = pace_of(disparate(prototype, controller))
    assert pace.frame == pace_of(prototype).frame
    assert pace.near_rest < 0.5 * pace.frame
    fastest = 1.0
    assert (fastest - pace.slow) * pace.per_braking > pace.frame


@pytest.mark.parametrize(("rate", "stages"), [(250.0, 4), (999.0, 4), (1000.0, 3), (4000.0, 3), (None, 4)])
def test_steps_that_samples_keep_short_have_three_stages(prototype, rate, stages):
    assert pace_of(disparate(prototype, replace(IDEAL, sample_rate_Hz=rate))).stages == stages


@pytest.mark.parametrize("name", ["ideal brakes", "sampled brakes", "a camera", "a failed sensor"])
def test_neighbours_change_no_digit(prototype, name):
    shifts = np.random.default_rng(1).uniform(-0.2, 0.2, (19, 6))
    models = [disparate(prototype, EVERY[name], tuple(row), 0.6) for row in shifts]
    together = responses_of(models)
    np.testing.assert_array_equal(responses_of(models[::-1])[::-1], together)
    np.testing.assert_array_equal(responses_of(models[7:8]), together[7:8])


def test_runs_with_and_without_sampling_stand_side_by_side(prototype):
    models = [
        disparate(prototype, EVERY[name]) for name in ("ideal brakes", "sampled brakes", "ideal motors", "a camera", "an ideal camera")
    ]
    together = responses_of(models)
    for row, model in zip(together, models, strict=True):
        assert row[responses.THETA_Z] == pytest.approx(responses_of([model])[0, responses.THETA_Z], abs=np.radians(0.01))


def test_a_delay_between_two_samples_ends_when_it_ends(prototype):
    """A step of a sweep ends where a command arrives; in a single deployment the command waits for the next step."""
    late = replace(IDEAL, sample_rate_Hz=250.0, delay_s=0.0057)
    model = disparate(prototype, late)
    run = deploy(replace(model, simulation=Simulation(0.8, 1000.0, 1e-5)))
    theta = run.channels["theta_z_rad"]
    found = responses_of([model])[0, responses.THETA_Z]
    assert np.degrees(found) == pytest.approx(np.degrees(theta[np.argmax(np.abs(theta))]), abs=0.01)


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class Integrating(Controller):
    """A law with a branch and a memory of its own: brakes harder the longer a leg has been ahead."""

    law: ClassVar[str] = "integrating"
    passive: ClassVar[bool] = True
    stiffness_N_per_m: NotNegative

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Forces, N; the memory counts the calls."""
        mean = (u[0] + u[1] + u[2] + u[3] + u[4] + u[5]) / 6.0
        memory[0] += 1.0
        for leg in range(6):
            if memory[0] > 100.0 and u[leg] > mean:
                out[leg] = -p[0] * (u[leg] - mean)
            else:
                out[leg] = -0.1 * p[0] * (u[leg] - mean)


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class IntegratingForAll(Integrating):
    """The same without a branch."""

    law: ClassVar[str] = "integrating-for-all"

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Forces, N; the memory counts the calls."""
        mean = (u[0] + u[1] + u[2] + u[3] + u[4] + u[5]) / 6.0
        memory[0] += 1.0
        late = min(max(memory[0] - 100.0, 0.0), 1.0)
        for leg in range(6):
            ahead = max(u[leg] - mean, 0.0) * late
            out[leg] = -p[0] * (ahead + 0.1 * ((u[leg] - mean) - ahead))


def test_a_law_with_a_branch_is_asked_run_by_run_and_finds_the_same(prototype):
    assert form_for_all(Integrating.command, "law") is None
    assert form_for_all(IntegratingForAll.command, "law") is not None
    gains, forces = (
        (300.0, 200.0, 400.0),
        ((0.2, -0.1, 0.15, -0.2, 0.1, 0.0), (0.1, 0.1, -0.2, 0.0, 0.2, -0.1), (-0.2, 0.0, 0.1, 0.2, 0.0, 0.1)),
    )
    branched, plain = (
        responses_of([disparate(prototype, kind(stiffness_N_per_m=k), f, 0.6) for k, f in zip(gains, forces, strict=True)])
        for kind in (Integrating, IntegratingForAll)
    )
    np.testing.assert_allclose(branched, plain, rtol=1e-9)


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class SummingUp(SampledController):
    """Motors against what a leg is ahead by and the sum of that over all samples: a memory for each leg."""

    law: ClassVar[str] = "summing-up"
    stiffness_N_per_m: NotNegative
    per_sample_N_per_m: NotNegative

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Forces, N; the last place of the memory is used too."""
        mean = (u[0] + u[1] + u[2] + u[3] + u[4] + u[5]) / 6.0
        for leg in range(6):
            memory[10 + leg] += u[leg] - mean
            out[leg] = -p[0] * (u[leg] - mean) - p[1] * memory[10 + leg]


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class SummingUpBranched(SummingUp):
    """The same with a branch."""

    law: ClassVar[str] = "summing-up-branched"

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Forces, N."""
        mean = (u[0] + u[1] + u[2] + u[3] + u[4] + u[5]) / 6.0
        for leg in range(6):
            memory[10 + leg] += u[leg] - mean
            if p[1] > 0.0:
                out[leg] = -p[0] * (u[leg] - mean) - p[1] * memory[10 + leg]
            else:
                out[leg] = -p[0] * (u[leg] - mean)


def test_what_a_law_keeps_changes_at_its_own_samples_whatever_the_neighbours_rates(prototype):
    """A run that is not due keeps its sums; twice as many samples of half the share sum up to the same."""

    def rigs(kind):
        rates = ((1000.0, 20.0), (500.0, 40.0), (250.0, 80.0))
        laws = [
            kind(actuator="motor", force_limit_N=2.0, stiffness_N_per_m=100.0, sample_rate_Hz=r, per_sample_N_per_m=k) for r, k in rates
        ]
        return [disparate(prototype, law, duration=0.45) for law in laws]

    together = responses_of(rigs(SummingUp))
    np.testing.assert_allclose(responses_of(rigs(SummingUpBranched)), together, rtol=1e-9)
    turned = np.degrees(together[:, responses.THETA_Z])
    for model, found in zip(rigs(SummingUp), turned, strict=True):
        theta = np.degrees(deploy(replace(model, simulation=Simulation(0.45, 1000.0, 1.25e-4))).channels["theta_z_rad"])
        assert found == pytest.approx(theta[np.argmax(np.abs(theta))], abs=0.01, rel=2e-4)
    assert turned == pytest.approx(np.full(3, turned[0]), rel=0.1)
    unsummed = responses_of([replace(rig, controller=replace(rig.controller, per_sample_N_per_m=0.0)) for rig in rigs(SummingUp)])
    assert np.all(np.abs(np.degrees(unsummed[:, responses.THETA_Z]) / turned - 1.0) > 0.1)


def test_every_law_of_the_catalogue_is_computed_for_all_runs_at_once():
    assert all(form_for_all(kind.command, "law") is not None for kind in known_laws().values() if kind.law in BUILT_IN)


BUILT_IN = {"synchronise", "profile", "one-way", "eddy-damper", "mechanical-link"}
