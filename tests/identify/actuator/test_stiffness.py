"""Dry or viscous: what the effective stiffness says, on actuators whose friction is known."""

import numpy as np
import pytest

from identify.actuator.stiffness import effective_stiffness, friction_of
from identify.loops.prepare import prepare
from measure import Loop
from simulate.effects import HubInertia, ViscousFriction
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])


def shaken(frequency, amplitude=0.05, effects=()):
    rng = np.random.default_rng(int(10 * frequency))
    n = int(5.3 / frequency * 400)
    t = np.arange(n * 10) / 4000.0
    w = 2 * np.pi * frequency
    u = 0.25 + amplitude * np.sin(w * t)
    force = loop_force(LINES, t, u, amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t), 2.75, effects)[::10]
    return prepare(Loop(t[::10], u[::10], force + 5e-4 * rng.standard_normal(n)))


def test_effective_stiffness_is_force_range_over_stroke():
    height = 2.89 - 2.79 - 0.05 * 0.25  # upper minus lower asymptote in the middle
    assert effective_stiffness(shaken(1.0)) == pytest.approx((height + 0.55 * 0.05) / 0.1, rel=0.05)


def test_dry_friction_is_said_to_be_dry():
    assert friction_of([shaken(f) for f in (0.4, 1.0, 3.0)]).word == "dry"


def test_viscous_friction_is_said_to_be_viscous():
    friction = friction_of([shaken(f, effects=(ViscousFriction(0.1),)) for f in (0.4, 1.0, 3.0)])
    assert friction.word == "viscous"


def test_inertia_is_subtracted_before_it_can_pass_for_something_else():
    loops = [shaken(f, effects=(HubInertia(0.05),)) for f in (0.4, 1.0, 3.0)]
    assert friction_of(loops).word != "dry"
    assert friction_of(loops, (HubInertia(0.05),)).word == "dry"


def test_frequencies_at_different_strokes_tell_nothing():
    friction = friction_of([shaken(0.4, 0.05), shaken(1.0, 0.03), shaken(3.0, 0.01)])
    assert friction.word == "cannot tell"
    assert "same stroke" in friction.sentence
