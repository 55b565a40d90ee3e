"""What every effect of the catalogue must do, whatever its physics."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.deployment.deploy import deploy
from simulate.effects import CATALOGUE
from simulate.loop import loop_force
from simulate.model.effect import ANY_RIG, LegEffect
from simulate.model.model import Simulation

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
TIME = np.linspace(0.0, 2.0, 1501)
OMEGA = 2 * np.pi
U = 0.1 + 0.05 * np.sin(OMEGA * TIME)
V, A = 0.05 * OMEGA * np.cos(OMEGA * TIME), -0.05 * OMEGA**2 * np.sin(OMEGA * TIME)

every_effect = pytest.mark.parametrize("kind", CATALOGUE.values(), ids=CATALOGUE)


def loop(effects):
    force = loop_force(LINES, TIME, U, V, A, 2.9, effects)
    for effect in effects:
        force = effect.observe_force(TIME, U, force)
    return force


def seen(model):
    """Everything that a deployment shows: channels as the measuring effects see them, at the times the clock shows."""
    run = deploy(model)
    channels = dict(run.channels)
    for effect in model.effects:
        channels = dict(effect.observe(run.time_s, channels))
    clock = run.time_s
    for effect in model.effects:
        clock = effect.true_time(clock)
    return np.vstack([np.interp(clock, run.time_s, channels[name]) for name in sorted(channels)] + [run.leg_force_N.T])


@every_effect
def test_defaults_switch_the_effect_off_in_a_loop(kind):
    assert np.max(np.abs(loop((kind(),)) - loop(()))) < 1e-12


@every_effect
def test_defaults_switch_the_effect_off_in_a_deployment(kind, lopsided):
    brief = replace(lopsided, simulation=Simulation(0.5, 100.0))
    without = tuple(effect for effect in brief.effects if effect.name != kind.name)
    off = seen(replace(brief, effects=(*without, kind())))
    assert np.max(np.abs(off - seen(replace(brief, effects=without)))) < 1e-9


@every_effect
def test_a_noticeable_size_is_noticed(kind, lopsided):
    size = kind().with_flat(kind.typical())
    if issubclass(kind, LegEffect) or kind.name in ("sensor-lag", "force-offset"):
        assert np.max(np.abs(loop((size,)) - loop(()))) > 1e-6
        return
    brief = replace(lopsided, simulation=Simulation(0.5, 100.0), effects=())
    assert np.max(np.abs(seen(brief.with_effect(size)) - seen(brief))) > 1e-6


@pytest.mark.parametrize("kind", [kind for kind in CATALOGUE.values() if issubclass(kind, LegEffect)])
def test_a_leg_effect_shows_in_a_deployment_too(kind, lopsided):
    brief = replace(lopsided, simulation=Simulation(0.5, 100.0), effects=())
    assert np.max(np.abs(seen(brief.with_effect(kind().with_flat(kind.typical()))) - seen(brief))) > 1e-6


@every_effect
def test_energy_still_closes_with_the_effect(kind, lopsided):
    brief = replace(lopsided, simulation=Simulation(0.3, 100.0, 1e-4), effects=())
    assert deploy(brief.with_effect(kind().with_flat(kind.typical()))).energy_closure < 1e-5


@every_effect
def test_parameters_go_flat_and_back(kind):
    low, high = np.array(list(kind.bounds().values())).T
    somewhere = kind.typical()
    assert kind().with_flat(somewhere).flat() == pytest.approx(somewhere)
    assert len(kind.flat_names()) == len(somewhere) == len(kind().flat())
    assert np.all(low <= somewhere)
    assert np.all(somewhere <= high)


@every_effect
def test_every_parameter_says_what_it_is_and_where_its_bounds_are(kind):
    assert kind.__doc__
    assert "\n" in kind.__doc__
    for item in fields(kind):
        assert len(item.metadata["doc"]) > 10
        assert item.metadata["low"] < item.metadata["high"]


@every_effect
def test_a_value_beyond_its_bounds_or_not_finite_is_refused_by_name(kind):
    for bad in (kind.bounds()[kind.flat_names()[0]][1] * 2 * ANY_RIG + 1, math.nan):
        vector = kind.typical()
        vector[0] = bad
        with pytest.raises(InputError, match=kind.name):
            kind().with_flat(vector)


def numbers_in(value):
    return value if isinstance(value, tuple) else (value,)


@every_effect
def test_defaults_and_starts_lie_within_the_bounds(kind):
    for item in fields(kind):
        low, high = item.metadata["low"], item.metadata["high"]
        for value in (item.default, *item.metadata["starts"]):
            assert all(low <= entry <= high for entry in numbers_in(value)), item.name
            assert len(numbers_in(value)) == len(numbers_in(item.default))


@every_effect
def test_a_size_has_no_sign_or_goes_as_far_either_way(kind):
    """A shape, a period or an exponent, lies above zero; what takes a share away keeps some of it."""
    for item in fields(kind):
        low, high = item.metadata["low"], item.metadata["high"]
        share = item.name == "fraction" and -1.0 < low < 0.0
        assert low == 0.0 or low == -high or 0.0 < low < high or share, item.name


@every_effect
def test_bounds_and_typical_sizes_are_rough_numbers_of_one_digit(kind):
    """Nobody has measured how large an effect can be on a rig that he has not seen; a share of 95 % is all but all."""
    for item in fields(kind):
        for name in ("low", "high", "typical"):
            value = item.metadata[name]
            assert value == float(f"{value:.0e}") or value == -0.95, (item.name, name)


@every_effect
def test_an_effect_is_off_where_its_size_is_zero_and_has_a_size_where_it_is_tried(kind):
    for item in fields(kind):
        assert item.metadata["typical"] != 0.0
        if not item.metadata["starts"] and item.metadata["linear"]:
            assert set(numbers_in(item.default)) <= {0.0, 1.0}, item.name
