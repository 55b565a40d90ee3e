"""What noise in the elongation does to a loop's motion, and through its inertia to the force, is reckoned with."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from identify.actuator.fit_actuator import fit_actuator
from identify.campaign.noise import whitened
from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.estimation.least_squares import solve
from identify.estimation.parameters import lines_of
from identify.loops.harmonics import harmonic_motion
from identify.loops.prepare import prepare
from measure import Loop
from simulate.effects import HubInertia, ViscousFriction
from simulate.loop import loop_force
from simulate.model.model import Model

HUB, GREASE, LASER_M, CELL_N, FINE = HubInertia(0.57), ViscousFriction(0.3), 1e-5, 1e-3, 20
SEEDS = range(25)


def shaken(model, frequency_Hz, amplitude_m, chance):
    t = np.arange(1000 * FINE + 1) * (3.0 / frequency_Hz / 1000 / FINE)
    w = 2 * np.pi * frequency_Hz
    u, v, a = (0.1 + amplitude_m * np.sin(w * t), amplitude_m * w * np.cos(w * t), -amplitude_m * w**2 * np.sin(w * t))
    force = loop_force(lines_of(model), t, u, v, a, 2.84, model.effects)[::FINE]
    seen = u[::FINE] + chance.normal(0.0, LASER_M, 1001)
    return Loop(t[::FINE], seen, force + chance.normal(0.0, CELL_N, 1001), name=f"{frequency_Hz:g} Hz, {amplitude_m:g} m")


def sets_of_loops(model):
    for seed in SEEDS:
        chance = np.random.default_rng(seed)
        yield [shaken(model, f, a, chance) for f in (0.4, 3.0) for a in (0.01, 0.04)]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.fixture
def bare(prototype: Model) -> Model:
    return replace(prototype, effects=())


def test_errors_of_a_sine_are_those_that_many_noises_make():
    t = np.linspace(0.0, 3.0, 600)
    u = 0.1 + 0.002 * t + 0.02 * np.sin(2 * np.pi * t + 0.4)
    found = [harmonic_motion(t, u + np.random.default_rng(seed).normal(0.0, LASER_M, 600), LASER_M) for seed in range(200)]
    seen = [one for one in found if one is not None]
    assert len(seen) == len(found)
    low, high = np.percentile([moved for moved, _ in seen], [15.87, 84.13], axis=0)  # a second harmonic is taken along now and then
    made = (high - low) / 2.0
    said = np.sqrt(np.sum(seen[0][1] ** 2, axis=0))
    assert np.allclose(np.sqrt(np.mean(made**2, axis=1)), np.sqrt(np.mean(said**2, axis=1)), rtol=0.1)
    assert np.allclose(made[:, ::50], said[:, ::50], rtol=0.3)


@given(st.integers(0, 5), st.floats(1e-3, 1e3), st.integers(0, 2**32 - 1))
def test_whitened_gaps_cost_what_the_best_errors_leave(ways, size, seed):
    chance = np.random.default_rng(seed)
    gaps, columns = chance.normal(size=30), size * chance.normal(size=(30, ways))
    both = np.vstack([columns, np.eye(ways)])
    left = np.concatenate([gaps, np.zeros(ways)]) - both @ np.linalg.lstsq(both, np.concatenate([gaps, np.zeros(ways)]))[0]
    assert np.isclose(np.sum(whitened(gaps, columns) ** 2), left @ left, rtol=1e-6)


@pytest.mark.calibrate
def test_a_heavy_hub_that_is_known_does_not_make_a_friction_too_sure(bare):
    truth = bare.with_effect(HUB).with_effect(GREASE)
    off, were_it_exact = [], []
    for loops in sets_of_loops(truth):
        problem = problem_of(bare.with_effect(HUB), [Run(loop) for loop in loops]).with_effects([ViscousFriction()])
        off.append(errors_off(problem))
        were_it_exact.append(errors_off(problem.with_exact_motion()))
    print(f"error over standard error: {rms(off):.2f}; were the motion exact: {rms(were_it_exact):.2f}")
    assert 0.6 < rms(off) < 1.4 < rms(were_it_exact)


def errors_off(problem):
    """How far the fitted friction is off, in standard errors."""
    fit = solve(problem)
    error = float(problem.effects_at(fit.q)[0].flat()[0]) - GREASE.damping_N_s_per_m
    return error / (np.sqrt(fit.covariance[-1, -1]) * problem.scales[-1])


@pytest.mark.calibrate
def test_inertia_and_friction_of_an_actuator_are_as_sure_as_they_say(bare):
    off, were_it_exact = [], []
    for loops in sets_of_loops(bare.with_effect(HUB).with_effect(GREASE)):
        data = [prepare(loop) for loop in loops]
        off.append(actuator_off(data))
        were_it_exact.append(actuator_off([replace(one, motion_errors=one.motion_errors[:0]) for one in data]))
    now, exact = ([rms(column) for column in zip(*rows, strict=True)] for rows in (off, were_it_exact))
    print(f"error over standard error of mass and friction: {now}; were the motion exact: {exact}")
    assert all(0.6 < value < 1.4 for value in now), now
    assert all(value > 1.4 for value in exact), exact


def actuator_off(data):
    """How far mass and friction are off, in standard errors."""
    estimates = fit_actuator(data, (HubInertia, ViscousFriction)).estimates
    mass, damping = estimates["hub-inertia.mass_kg"], estimates["viscous-friction.damping_N_s_per_m"]
    return (mass.value - HUB.mass_kg) / mass.stderr, (damping.value - GREASE.damping_N_s_per_m) / damping.stderr
