"""What a controller tells the kernel: limits, friction, and its numbers in their places."""

from __future__ import annotations

import pytest

from simulate.control.eddy_damper import EddyDamper
from simulate.control.one_way import OneWay
from simulate.control.synchronise import Synchronise
from simulate.kernel import layout as at
from simulate.model.control import MOST_PENDING, SampledController, laws_among, require_law


def held(**changed):
    return Synchronise(**{"stiffness_N_per_m": 100.0, "damping_N_s_per_m": 5.0, "force_limit_N": 2.0, **changed})


SAMPLED = {
    "sample_rate_Hz": 500.0, "delay_s": 0.004, "lag_s": 0.003, "sensor_noise_m": 1e-4, "sensor_step_m": 2e-4, "sensor": "camera",
    "sensor_noise_rad": 3e-4, "sensor_step_rad": 4e-4, "observer_Hz": 60.0, "actuator": "motor", "failed_sensor": 1, "seed": 9,
    "failed_brake": 3, "stuck_force_N": 0.7, "failure_s": 0.2, "brake_speed_m_per_s": 0.02,
}  # fmt: skip


def test_every_number_stands_where_the_kernel_reads_it():
    flat = held(**SAMPLED).flat()
    expected = {
        at.LAW_PASSIVE: 0.0, at.LAW_FAILED: 3.0, at.LAW_STUCK: 0.7, at.LAW_FAILS_AT: 0.2, at.LAW_BRAKE_SPEED: 0.02,
        at.LAW_COUPLED_MASS: 0.0, at.LAW_RATE: 500.0, at.LAW_DELAY: 0.004, at.LAW_LAG: 0.003, at.LAW_NOISE: 1e-4, at.LAW_STEP: 2e-4,
        at.LAW_CAMERA: 1.0, at.LAW_NOISE_RAD: 3e-4, at.LAW_STEP_RAD: 4e-4, at.LAW_OBSERVER: 60.0, at.LAW_LIMIT: 2.0, at.LAW_MOTOR: 1.0,
        at.LAW_FAILED_SENSOR: 1.0, at.LAW_SEED: 9.0, at.LAW_GAINS: 100.0, at.LAW_GAINS + 1: 5.0,
    }  # fmt: skip
    assert {place: flat[place] for place in expected} == expected
    assert len(flat) == at.LAW_GAINS + 2


def test_what_is_not_given_is_zero_and_a_passive_law_says_so():
    ideal = held().flat()
    for place in (at.LAW_RATE, at.LAW_DELAY, at.LAW_CAMERA, at.LAW_OBSERVER, at.LAW_MOTOR, at.LAW_FAILED_SENSOR, at.LAW_SEED):
        assert ideal[place] == 0.0
    damper = EddyDamper(damping_N_s_per_m=3.0, critical_speed_m_per_s=0.5, failed_brake=2, failure_s=0.1).flat()
    assert (damper[at.LAW_PASSIVE], damper[at.LAW_FAILED], damper[at.LAW_FAILS_AT]) == (1.0, 2.0, 0.1)
    assert damper[at.LAW_COUPLED_MASS : at.LAW_GAINS].tolist() == [0.0] * (at.LAW_GAINS - at.LAW_COUPLED_MASS)
    assert damper[at.LAW_GAINS : at.LAW_GAINS + 2].tolist() == [3.0, 0.5]


def test_brakes_have_dry_friction_up_to_their_limit_and_motors_have_none(prototype):
    assert held().dry_friction() == (2.0, 0.01)
    assert held(actuator="motor").dry_friction()[0] == 0.0
    assert EddyDamper(damping_N_s_per_m=3.0).dry_friction()[0] == 0.0
    assert held().stiffness(prototype) == (100.0, 5.0)
    assert held(sample_rate_Hz=1000.0).stiffness(prototype) == (0.0, 0.0)


def test_what_only_holds_back_makes_no_spring_and_no_damper_and_couples_no_mass(prototype):
    clutch = OneWay(clutch_force_N=3.0)
    assert clutch.stiffness(prototype) == (0.0, 0.0)
    assert clutch.dry_friction() == (3.0, 0.01)
    assert (clutch.coupled_mass_kg(), clutch.constants_of(prototype)) == (0.0, ())


def test_a_delay_holds_so_many_commands_and_an_observer_half_of_the_rate():
    most = MOST_PENDING / 500.0
    assert held(sample_rate_Hz=500.0, delay_s=most).delay_s == most
    with pytest.raises(ValueError, match=f"delay_s is 61 sample periods; at most {MOST_PENDING} can be"):
        held(sample_rate_Hz=500.0, delay_s=61.0 / 500.0)
    assert held(sample_rate_Hz=500.0, observer_Hz=250.0).observer_Hz == 250.0
    with pytest.raises(ValueError, match="above half of sample_rate_Hz"):
        held(sample_rate_Hz=500.0, observer_Hz=251.0)


def test_a_controller_without_a_rate_names_all_that_needs_one():
    with pytest.raises(ValueError, match="delay_s, sensor_noise_m, failed_sensor: a controller without sample_rate_Hz"):
        held(delay_s=0.01, sensor_noise_m=1e-4, failed_sensor=2)


def test_each_run_has_a_noise_of_its_own():
    assert held(**SAMPLED).reseeded(4) == held(**{**SAMPLED, "seed": 13})
    damper = EddyDamper(damping_N_s_per_m=3.0)
    assert damper.reseeded(4) is damper


def test_the_gains_of_a_law_are_what_it_adds_to_all_controllers():
    assert Synchronise.gains() == ("stiffness_N_per_m", "damping_N_s_per_m")
    assert EddyDamper.gains() == ("damping_N_s_per_m", "critical_speed_m_per_s")
    assert held().table() == {k: v for k, v in held().table().items() if v is not None}
    assert held().table()["law"] == "synchronise"


def test_a_law_has_a_name_of_its_own_and_a_formula():
    found = laws_among({"Synchronise": Synchronise, "SampledController": SampledController, "other": 3, "EddyDamper": EddyDamper})
    assert found == [Synchronise, EddyDamper]
    assert require_law(Synchronise) is Synchronise
