"""Profile and bootstrap against the covariance, where all three must agree, and where only one can be right."""

import numpy as np
import pytest

from identify.actuator.fit_actuator import fit_actuator
from identify.estimation.bootstrap import bootstrap
from identify.loops.prepare import prepare
from measure import Loop
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])


def shaken(seed, amplitude=0.05, cycles=8.3, noise=2e-3, lines=LINES):
    rng = np.random.default_rng(seed)
    n = int(cycles * 200)
    t = np.arange(n * 10) / 2000.0
    u = 0.25 + amplitude * np.sin(2 * np.pi * t)
    force = loop_force(lines, t, u, 0 * t, 0 * t, 2.75)[::10]
    return prepare(Loop(t[::10], u[::10], force + noise * rng.standard_normal(n)))


def test_profile_of_beta_agrees_with_the_covariance_where_beta_is_well_known():
    loops = [shaken(1)]
    fit = fit_actuator(loops, suggest=False)
    profile = fit.profile()
    assert profile.rise[len(profile.rise) // 2] == pytest.approx(0.0, abs=1e-3)
    assert np.array(profile.interval) == pytest.approx(np.array(fit.estimates["beta_per_m"].ci95), rel=0.02)


def test_profile_of_beta_is_open_where_the_loop_is_a_rectangle():
    loops = [shaken(2, noise=0.02, lines=np.array([-0.25, 2.79, -0.3, 2.89, 1.5e5]))]
    profile = fit_actuator(loops, suggest=False).profile()
    assert profile.interval[1] / profile.interval[0] > 4.0


def test_bootstrap_by_cycles_is_as_wide_as_the_covariance_for_white_noise():
    loops = [shaken(3), shaken(4, amplitude=0.02)]
    fit = fit_actuator(loops, suggest=False)
    intervals = bootstrap(fit.fit, fit.names, 60, seed=1)
    for name, (low, high) in intervals.items():
        estimate = fit.estimates[name]
        assert (high - low) / (estimate.ci95[1] - estimate.ci95[0]) == pytest.approx(1.0, abs=0.45)


def test_same_seed_gives_the_same_bootstrap():
    loops = [shaken(3)]
    fit = fit_actuator(loops, suggest=False)
    assert bootstrap(fit.fit, fit.names, 5, seed=7) == bootstrap(fit.fit, fit.names, 5, seed=7)
