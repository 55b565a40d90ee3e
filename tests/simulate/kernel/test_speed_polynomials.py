"""Asymptotes that follow the speed: the table of the model file and the effect are one thing."""

from dataclasses import replace

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.deployment.deploy import deploy
from simulate.effects import RateDependentAsymptotes
from simulate.kernel.speed_polynomials import with_rate_worked_in
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
        (Rate("frequency_Hz", b_l=(2.8, 0.01)), r"no cycling frequency .* Add stroke_m"),
        (Rate("speed_m_per_s", b_l=(2.8, 0.0, 0.0, 1.0)), "at most 3"),
    ],
)
def test_a_rate_that_a_deployment_cannot_have_is_refused(prototype, rate, named):
    with pytest.raises(InputError, match=named):
        deploy(replace(prototype, actuator=replace(prototype.actuator, rate=rate)))


LOOPS = {"frequency_Hz": (0.5, 1.0, 3.0), "stroke_m": (0.1, 0.1, 0.1), "mid_stroke_speed_m_per_s": (0.05 * np.pi, 0.1 * np.pi, 0.3 * np.pi)}


def followed(model, abscissa, loops, per=1.0):
    """The model with asymptotes that follow frequency, or speed where `per` is the speed at one hertz."""
    lines = {"a_l": (-0.2, 0.03, -0.01), "b_l": (2.79, 0.04, 0.002), "b_u": (2.89, 0.05, 0.003)}
    scaled = {name: tuple(c / per**k for k, c in enumerate(powers)) for name, powers in lines.items()}
    brief = replace(model, simulation=Simulation(0.3, 200.0))
    return replace(brief, actuator=replace(brief.actuator, rate=Rate(abscissa, **scaled, **loops)))


def test_frequency_and_speed_form_of_one_fit_give_the_same_deployment(lopsided):
    of_frequency = deploy(followed(lopsided, "frequency_Hz", LOOPS))
    of_speed = deploy(followed(lopsided, "speed_m_per_s", LOOPS, per=0.1 * np.pi))
    assert np.max(np.abs(of_frequency.samples - of_speed.samples)) < 1e-9
    assert np.max(np.abs(of_speed.samples - deploy(lopsided).samples[: len(of_speed.samples)])) > 1e-4
    only_strokes = deploy(followed(lopsided, "frequency_Hz", {"stroke_m": (0.1,)}))
    assert np.max(np.abs(of_frequency.samples - only_strokes.samples)) < 1e-9


def test_what_was_assumed_and_where_speeds_leave_the_loops_is_said(lopsided):
    said = deploy(followed(lopsided, "frequency_Hz", LOOPS)).warnings
    assert any("v = 2 pi f A, with 2 A = 100 mm" in text for text in said)
    slow = {**LOOPS, "mid_stroke_speed_m_per_s": (0.01, 0.02, 0.06), "stroke_m": (0.002, 0.01, 0.02)}
    said = deploy(followed(lopsided, "frequency_Hz", slow)).warnings
    assert any("strokes from 2 to 20 mm" in text for text in said)
    assert any("measured at speeds from 0.01 to 0.06 m/s" in text and "extrapolated" in text for text in said)
    fast = {**LOOPS, "mid_stroke_speed_m_per_s": (1.0, 5.0, 20.0)}
    assert not any("extrapolated" in text for text in deploy(followed(lopsided, "speed_m_per_s", fast)).warnings)


def test_once_worked_in_a_change_of_the_level_moves_the_force_and_the_range_is_kept(lopsided):
    model = with_rate_worked_in(followed(lopsided, "frequency_Hz", LOOPS))
    assert model.actuator.b_l_N == 2.79
    assert model.actuator.rate == Rate("frequency_Hz", **LOOPS)
    assert with_rate_worked_in(model) is model
    moved = replace(model, actuator=replace(model.actuator, b_l_N=2.9))
    assert deploy(moved).channels["z_m"][-1] > deploy(model).channels["z_m"][-1] + 1e-3
    assert any("taken against speed" in text for text in deploy(model).warnings)
