"""Asymptotes that follow the speed: the table of the model file and the effect are one thing."""

from dataclasses import replace

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.deployment.deploy import deploy
from simulate.effects import RateDependentAsymptotes
from simulate.loop import loop_force
from simulate.model.model import Rate, Simulation

LINES = np.array([-0.25, 2.79, -0.25, 2.89, 400.0])


def test_force_at_a_steady_speed_settles_on_the_polynomials_value():
    effect = RateDependentAsymptotes(b_l=(0.3, -0.1), a_l=(0.5, 0.0))
    time = np.linspace(0.0, 0.4, 2001)
    speed = 0.7
    force = loop_force(LINES, time, speed * time, np.full_like(time, speed), np.zeros_like(time), 2.8, (effect,))
    u = speed * time[-1]
    slope = -0.25 + 0.5 * speed
    assert force[-1] == pytest.approx(slope * u + 2.79 + 0.3 * speed - 0.1 * speed**2 - slope / 400.0, abs=1e-9)


def test_the_table_replaces_the_value_of_its_name_by_the_polynomial(lopsided):
    brief = replace(lopsided, simulation=Simulation(0.4, 100.0))
    table = Rate("speed_m_per_s", b_l=(2.8, 0.05), b_u=(2.9, 0.05, 0.01))
    by_table = deploy(replace(brief, actuator=replace(brief.actuator, rate=table)))
    by_effect = deploy(
        replace(brief, actuator=replace(brief.actuator, b_l_N=2.8, b_u_N=2.9)).with_effect(
            RateDependentAsymptotes(b_l=(0.05, 0.0), b_u=(0.05, 0.01))
        )
    )
    np.testing.assert_array_equal(by_table.samples, by_effect.samples)
    assert by_table.model.actuator.rate == table


def test_a_faster_deployment_with_more_force_at_speed_arrives_earlier(prototype):
    law = replace(prototype.actuator, rate=Rate("speed_m_per_s", b_l=(2.79, 0.2)))
    arrives = [run.time_s[np.argmax(run.channels["z_m"] > 0.65)] for run in map(deploy, (prototype, replace(prototype, actuator=law)))]
    assert arrives[1] < arrives[0] - 0.002


@pytest.mark.parametrize(
    ("rate", "named"),
    [
        (Rate("frequency_Hz", b_l=(2.8, 0.01)), "no cycling frequency"),
        (Rate("speed_m_per_s", b_l=(2.8, 0.0, 0.0, 1.0)), "at most 3"),
    ],
)
def test_a_rate_that_a_deployment_cannot_have_is_refused(prototype, rate, named):
    with pytest.raises(InputError, match=named):
        deploy(replace(prototype, actuator=replace(prototype.actuator, rate=rate)))
