"""Idle seconds, ramps, transients and gaps of a record are told apart, and none of them moves the truth."""

import numpy as np
import pytest

from identify.actuator.fit_actuator import fit_actuator
from identify.loops.prepare import prepare
from identify.loops.segments import sentence
from measure import Loop
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
RATE = 400.0


def moved(u, t=None, keep=None, seed=0):
    """A loop of this motion, its force by the law, 2 mN and 10 um of noise; `keep` are the samples that were recorded."""
    t = np.arange(len(u)) / RATE if t is None else t
    rng = np.random.default_rng(seed)
    force = loop_force(LINES, t, u, 0 * t, 0 * t, 2.8) + 2e-3 * rng.standard_normal(len(t))
    seen = u + 1e-5 * rng.standard_normal(len(t))
    keep = slice(None) if keep is None else keep
    return Loop(t[keep], seen[keep], force[keep])


def wave(cycles, amplitude=0.05, frequency=1.0):
    t = np.arange(int(cycles / frequency * RATE)) / RATE
    return 0.25 + amplitude * np.sin(2 * np.pi * frequency * t)


def kinds(data):
    return [part.kind for part in data.parts]


def test_a_record_is_told_as_idle_ramp_cycles_rest_and_idle():
    still = np.full(200, 0.25)
    data = prepare(moved(np.concatenate([still, wave(4.0), still])))
    assert kinds(data) == ["idle", "ramp", "cycle", "cycle", "cycle", "rest", "idle"]
    edges = [part.from_s for part in data.parts]
    assert edges == pytest.approx([0.0, 0.5, 0.75, 1.75, 2.75, 3.75, 4.5], abs=0.03)
    assert "idle 0 to" in sentence(data.parts)
    assert "nothing moves" in sentence(data.parts)


def test_no_sample_is_missing_from_the_list_and_those_that_count_are_counted():
    data = prepare(moved(np.concatenate([np.full(100, 0.25), wave(3.3)])))
    assert sum(part.samples for part in data.parts) == len(data.time_s)
    assert sum(part.used for part in data.parts) == data.used.sum()


def test_the_first_strokes_of_a_shaker_that_is_still_rising_are_transients_and_count():
    t = np.arange(int(8 * RATE)) / RATE
    u = 0.25 + 0.05 * np.minimum(t / 3.0, 1.0) * np.sin(2 * np.pi * t)
    data = prepare(moved(u))
    assert kinds(data)[:4] == ["idle", "ramp", "transient", "transient"]
    assert kinds(data).count("cycle") >= 4
    assert data.amplitude_m == pytest.approx(0.05, rel=0.01)
    assert fit_actuator([data], suggest=False).estimates["beta_per_m"].value == pytest.approx(400.0, rel=0.06)


def without(n, first, last):
    return np.r_[0:first, last:n]


def test_a_gap_in_the_middle_of_a_stroke_costs_nothing():
    u = wave(4.3)
    data = prepare(moved(u, keep=without(len(u), 380, 420)))
    assert data.used.sum() == len(data.used) - 20
    assert fit_actuator([data], suggest=False).estimates["beta_per_m"].value == pytest.approx(400.0, rel=0.06)


@pytest.mark.parametrize("missing", [(480, 520), (460, 540), (380, 780), (500, 920)])
def test_a_gap_in_which_the_motion_turned_leaves_out_the_stroke_behind_it_and_not_the_truth(missing):
    u = wave(6.3)
    data = prepare(moved(u, keep=without(len(u), *missing)))
    assert "the motion may have turned in a gap" in sentence(data.parts)
    assert 50 < np.sum(~data.used) < 300
    fit = fit_actuator([data], suggest=False)
    assert np.std(fit.residuals[0]) == pytest.approx(2e-3, rel=0.1)
    assert abs(fit.estimates["beta_per_m"].value - 400.0) < 4.0 * fit.estimates["beta_per_m"].stderr
    assert data.frequency_Hz == pytest.approx(1.0, rel=0.01)


def test_a_first_step_of_280_ms_does_not_move_the_truth():
    u = wave(5.3)
    data = prepare(moved(u, keep=np.r_[0:3, 112 : len(u)]))
    assert not np.any(data.used[:3])  # a handful of samples before a gap belongs to nothing
    fit = fit_actuator([data], suggest=False)
    assert fit.verdict.word == "ok"
    assert fit.estimates["beta_per_m"].value == pytest.approx(400.0, rel=0.06)
