"""A loop made ready, and what the law predicts for it, against loops whose truth is known."""

import numpy as np
import pytest

from identify.loops.loop_data import free_start, gap, predict
from identify.loops.prepare import prepare
from identify.noise.effective_number import effective_number
from measure import InputError, Loop
from simulate.effects import HubInertia, ViscousFriction
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])


def made(frequency=1.0, amplitude=0.05, rate=400.0, noise=0.0, cycles=3.2, effects=(), seed=1):
    fine = 20
    t = np.arange(int(cycles / frequency * rate) * fine) / (rate * fine)
    w = 2 * np.pi * frequency
    u, v, a = 0.25 + amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)
    force = loop_force(LINES, t, u, v, a, 2.72, effects)[::fine]
    rng = np.random.default_rng(seed)
    return Loop(t[::fine], u[::fine], force + noise * rng.standard_normal(len(force)), "made")


@pytest.mark.parametrize("effects", [(), (HubInertia(0.05), ViscousFriction(0.3))])
def test_prediction_at_samples_is_the_law_on_a_path_sampled_twenty_times_finer(effects):
    loop = made(effects=effects)
    data = prepare(loop)
    _, force = free_start(LINES, data, effects)
    assert np.max(np.abs(force - loop.force_N)[data.used]) < 2e-3  # the loop is 0.1 N high


def test_start_force_is_found_from_the_loop_itself():
    start, _ = free_start(LINES, prepare(made()))
    assert start == pytest.approx(2.72, abs=2e-3)


def test_gap_of_the_true_law_is_the_noise_that_was_estimated_beforehand():
    data = prepare(made(noise=0.01, rate=1000.0))
    residual = gap(LINES, data)
    assert np.std(residual) == pytest.approx(0.01, rel=0.06)
    assert data.force_sigma_N == pytest.approx(0.01, rel=0.1)
    assert effective_number(residual) > 0.7 * len(residual)


def test_a_start_force_fades_and_is_forgotten_after_one_stroke():
    data = prepare(made())
    change = predict(LINES, data, 3.0) - predict(LINES, data, 2.0)
    assert change[0] == pytest.approx(1.0)
    assert np.max(np.abs(change[100:])) < 1e-8


def test_idle_seconds_before_the_motion_do_not_count():
    loop = made(noise=0.001)
    idle = 300
    t = np.concatenate([loop.time_s[0] - np.arange(idle, 0, -1) / 400.0, loop.time_s])
    u = np.concatenate([np.full(idle, loop.elongation_m[0]), loop.elongation_m])
    f = np.concatenate([np.full(idle, loop.force_N[0]), loop.force_N])
    data = prepare(Loop(t, u, f))
    assert 0 < np.argmax(data.used) - idle + 10 < 12


def test_a_force_that_never_changes_is_refused():
    t = np.linspace(0, 1, 100)
    with pytest.raises(InputError, match="force_N is 3 in every row"):
        prepare(Loop(t, np.sin(9 * t), np.full(100, 3.0)))
