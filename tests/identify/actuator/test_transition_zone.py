"""Where the strip's transition zone is complete, against loops whose zone is known."""

import numpy as np
import pytest

from identify.actuator.actuator_fit import transition_of
from identify.actuator.fit_actuator import fit_actuator
from identify.actuator.transition_zone import level_against_length
from identify.loops.prepare import prepare
from identify.report.loop_result import result_of
from measure import Loop
from simulate.effects import HubInertia, TransitionZone, ViscousFriction
from simulate.loop import loop_force
from simulate.model.effect import Effect


def shaken(low, high, frequency=0.2, effects: tuple[Effect, ...] = (), slope=-0.05, seed=0):
    """Loops between two elongations, 0.1 N high, 2 mN and 10 um of noise."""
    t = np.arange(int(3.3 / frequency * 200) * 10) / 2000.0
    w, amplitude = 2 * np.pi * frequency, (high - low) / 2
    u, v, a = (low + high) / 2 + amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)
    force = loop_force(np.array([slope, 2.79, slope, 2.89, 400.0]), t, u, v, a, 2.8, effects)[::10]
    rng = np.random.default_rng(seed)
    n = len(force)
    return prepare(Loop(t[::10], u[::10] + 1e-5 * rng.standard_normal(n), force + 2e-3 * rng.standard_normal(n)))


def test_a_leg_without_a_transition_zone_is_on_one_line_everywhere():
    level = level_against_length([shaken(0.01, 0.39)], 400.0)
    assert level.complete_from_m == pytest.approx(level.elongation_m[0])
    assert level.level_N == pytest.approx(2.84 - 0.05 * level.elongation_m, abs=2e-3)
    assert np.all(np.abs(level.departure_N) < 5 * level.stderr_N + 1e-3)


def test_missing_force_is_seen_where_little_strip_is_out_and_gone_at_a_quarter_of_a_metre():
    level = level_against_length([shaken(0.01, 0.39, effects=(TransitionZone(0.3, 0.08),))], 400.0)
    assert 0.15 < level.complete_from_m < 0.27
    assert level.departure_N[0] == pytest.approx(-0.3 * np.exp(-level.elongation_m[0] / 0.08), abs=0.04)
    assert "--effect transition-zone" in level.sentence


@pytest.mark.parametrize("effects", [(ViscousFriction(0.2),), (HubInertia(0.05),)])
def test_friction_cancels_in_the_mean_of_both_directions_and_inertia_is_subtracted(effects):
    kept = effects if isinstance(effects[0], HubInertia) else ()
    level = level_against_length([shaken(0.2, 0.36, 3.0, effects)], 400.0, kept)
    middle = np.abs(level.elongation_m - 0.28) < 0.03
    assert level.level_N[middle] == pytest.approx(2.84 - 0.05 * level.elongation_m[middle], abs=5e-3)


def test_a_slope_of_the_asymptotes_is_no_transition_zone():
    level = level_against_length([shaken(0.1, 0.35, slope=-0.5)], 400.0)
    assert level.complete_from_m == pytest.approx(level.elongation_m[0])


def test_short_loops_say_that_they_cannot_tell():
    level = level_against_length([shaken(0.2, 0.204)], 400.0)
    assert np.isnan(level.complete_from_m) or level.complete_from_m == level.elongation_m[0]
    ramp = np.linspace(0.0, 1.0, 300)
    half = prepare(Loop(ramp, 0.1 * np.abs(ramp - 0.6), 2.8 + 0.01 * np.sin(9 * ramp)))
    assert level_against_length([half], 400.0).sentence.startswith(("cannot tell", "complete"))


def test_a_zone_that_the_law_cannot_describe_is_still_shown_in_the_result():
    loops = [shaken(0.01, 0.39, effects=(TransitionZone(0.3, 0.08),))]
    fit = fit_actuator(loops)
    assert fit.verdict.word == "model-does-not-apply"
    shown = result_of(fit, loops)["transition"]
    assert 0.15 < shown["complete_from_m"] < 0.27
    assert len(shown["elongation_m"]) == len(shown["level_N"]) == len(shown["stderr_N"])
    assert transition_of(fit, loops).sentence == shown["sentence"]
