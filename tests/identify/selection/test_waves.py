"""Waves of one frequency are weighed together, whatever their phase and axis; and a fit of one is taken to where all of it is near."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from identify.estimation.least_squares import solve
from identify.selection.courses import stepped
from identify.selection.promises import posed, promises
from identify.selection.weighing import weighed
from simulate.effects import CATALOGUE, BaseExcitation, Ripple

SHAKES = BaseExcitation(acceleration_m_per_s2=0.05, frequency_Hz=15.8, phase_rad=0.73, axis=(0.74, 0.31, 0.6))
NAME = SHAKES.name


def wrench_of(effect, time_s):
    """Force of an excitation on a platform of 2 kg, (3,)."""
    wrench = np.zeros(6)
    BaseExcitation.platform_wrench(time_s, None, None, np.array([*effect.flat(), 2.0]), wrench)
    return wrench[:3]


def flat(parts):
    """Parameters of effects laid flat, (k, n), and the amount of each, (k,)."""
    return np.array([one.flat() for one in parts]), np.array(list(parts.values()))


@pytest.mark.parametrize("seed", range(5))
def test_one_excitation_does_what_its_parts_along_all_axes_do(seed):
    chance = np.random.default_rng(seed)
    size, phase, axis = chance.uniform(0.1, 2.0), chance.uniform(-3.0, 3.0), chance.normal(size=3)
    parts = {
        BaseExcitation(1.0, 7.0, at, tuple(np.eye(3)[k].tolist())): size * axis[k] * turned
        for k in range(3)
        for at, turned in ((0.0, math.cos(phase)), (0.5 * math.pi, math.sin(phase)))
    }
    whole = BaseExcitation(0.0, 7.0).sum_of(*flat(parts))
    assert np.linalg.norm(whole.axis) == pytest.approx(1.0)
    for time in np.linspace(0.0, 0.3, 7):
        assert wrench_of(whole, time) == pytest.approx(sum(a * wrench_of(one, time) for one, a in parts.items()), abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_one_ripple_does_what_its_parts_do(seed):
    chance = np.random.default_rng(seed)
    parts = {Ripple(0.0, 0.05, phase): amount for phase, amount in zip(chance.uniform(-3.0, 3.0, 4), chance.normal(size=4), strict=True)}
    whole = Ripple(0.0, 0.05).sum_of(*flat(parts))
    for u in np.linspace(0.0, 0.1, 9):
        force = sum(amount * Ripple.leg_force(u, 0, 0, 0, 0, replace(one, force_N=1.0).flat()) for one, amount in parts.items())
        assert Ripple.leg_force(u, 0, 0, 0, 0, whole.flat()) == pytest.approx(force, abs=1e-12)


@pytest.fixture
def shaken(campaign, fitted):
    """A film on a floor that shakes, explained without that."""
    return weighed(fitted(campaign(SHAKES, 97, loops=(), deployments=({},), hold_out=False)))


@pytest.mark.slow
def test_an_excitation_along_no_axis_of_the_rig_is_found_from_one_of_its_promises(shaken):
    (promise,) = (one for one in promises(shaken, {NAME: CATALOGUE[NAME]}) if one.name == NAME)
    assert len(promise.others) == 2
    starts = (posed(shaken, one) for one in (promise, *promise.others))
    found = max((weighed(solve(problem, start, loosely=True)) for problem, start in starts), key=lambda one: one.log_z)
    (effect,) = found.fit.problem.effects_at(found.fit.q)
    assert isinstance(effect, BaseExcitation)
    assert effect.as_stated().frequency_Hz == pytest.approx(15.8, abs=0.2)
    assert found.log_z > promise.log_z + 3.0


def test_what_shakes_along_several_axes_is_promised_along_one_between_them(shaken, monkeypatch):
    monkeypatch.setattr("identify.selection.promises._with_shape_free", lambda at, effect, sizes: (-np.inf, None, sizes))
    (promise,) = (one for one in promises(shaken, {NAME: CATALOGUE[NAME]}) if one.name == NAME)
    problem, start = posed(shaken, promise)
    (effect,) = problem.effects_at(start)
    assert isinstance(effect, BaseExcitation)
    assert np.linalg.norm(effect.axis) == pytest.approx(1.0)
    seen = np.abs(np.delete(effect.axis, 1))  # of what shakes along y the film shows hardly anything, so that it may be any amount
    assert seen.min() > 0.2 * seen.max()


def test_a_place_is_left_that_is_near_in_each_parameter_and_far_in_all(shaken):
    problem = shaken.exact.given.with_another(SHAKES)
    there = weighed(solve(problem, np.concatenate([shaken.exact.fit.q, np.zeros(6)]), loosely=True)).exact
    found, q = there.weighed(), there.fit.q.copy()
    first = problem.first_effect
    q[first] += 0.09 * math.sqrt(found.covariance[first, first])
    away = there.at(there.fit.problem, q, there.sizes)
    lost = there.log_probability(found.noise) - away.log_probability(found.noise)
    again, _ = stepped(away, away.weighed(found.noise))
    assert lost > 100.0
    assert again.log_probability(found.noise) > there.log_probability(found.noise) - 2.0
