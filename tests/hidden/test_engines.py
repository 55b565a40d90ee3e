"""The engines that make the cases, against each other: the project's kernel, scipy's integrators, MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest
from board.bench import Bench, in_run, motions
from board.campaigns import planned
from board.engines import FINE_STEP_S, loop_by, motion_by
from board.platform_ode import SAID, moved_by_ode
from board.rigs import drawn_rig
from board.shaker import stroke_of
from board.shapes import drawn
from board.specs import NOT_IN_MUJOCO, OF_THE_MODEL_FILE, ONLY_IN_THE_KERNEL, OUTSIDE, Spec

from simulate.effects import CATALOGUE, JointFriction
from simulate.model.model import Model


def with_all_of(names: tuple[str, ...], seed: int = 0) -> tuple[Model, Bench]:
    """A rig in which all of these act at once, each by an amount that shows."""
    spec = Spec(("release-pose",), seed=seed)
    chance = spec.chance
    rig = drawn_rig(chance)
    bench = Bench(rig, planned(spec, rig.known, chance))
    model = rig.true
    for name in names:
        hidden = drawn(name, rig.true, 2e-3, chance)
        model = model.with_effect(hidden.at(min(0.5, 0.5 * hidden.most)))
    return model, bench


def apart(first, second, until_s: float = np.inf) -> float:
    """Largest distance of the platform's origin between two motions, m."""
    there = first.time_s <= until_s
    return float(np.max(np.abs(first.place_m - second.place_m)[there]))


@pytest.mark.slow
def test_dop853_on_a_right_hand_side_of_its_own_moves_the_platform_alike_with_all_effects_at_once():
    model, bench = with_all_of((*SAID, *OUTSIDE))
    at = in_run(model, bench.films[0])
    (kernel,) = motions([at], FINE_STEP_S)
    other = moved_by_ode(at, kernel.time_s)
    assert apart(kernel, other, until_s=0.2) < 2e-8
    assert apart(kernel, other) < 1e-6  # a quarter of the finest camera's noise
    (without,) = motions([in_run(bench.rig.true, bench.films[0])], FINE_STEP_S)
    assert apart(kernel, without) > 1e-2, "nothing acted, nothing was tested"


@pytest.mark.slow
def test_mujoco_moves_the_platform_alike_with_all_effects_it_can_express_at_once():
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco")
    model, bench = with_all_of(tuple(name for name in (*SAID, *OUTSIDE) if name not in NOT_IN_MUJOCO))
    at = in_run(model, bench.films[0])
    (kernel,) = motions([at], FINE_STEP_S)
    other = motion_by("mujoco", at)
    assert apart(kernel, other, until_s=0.2) < 2e-8
    assert apart(kernel, other) < 5e-6


def test_lsoda_on_the_differential_law_gives_the_loops_of_the_exact_one():
    model, bench = with_all_of(tuple(name for name in (*SAID, *OUTSIDE) if name != "leg-disparity"))
    for run in bench.loops:
        stroke = stroke_of(run)
        exact = loop_by("kernel", model, stroke, run.start_force_N)
        assert np.max(np.abs(loop_by("ode", model, stroke, run.start_force_N) - exact)) < 1e-5


def test_an_effect_that_is_not_written_a_second_time_is_refused_and_not_left_out():
    model, bench = with_all_of(())
    with pytest.raises(ValueError, match="joint-friction"):
        moved_by_ode(in_run(model.with_effect(JointFriction(1e-3)), bench.films[0]), np.linspace(0.0, 0.1, 11))


def test_what_no_other_engine_says_is_listed():
    measured = {name for name, kind in CATALOGUE.items() if kind.acts_on == "measurement"}
    assert set(CATALOGUE) == {*SAID, *ONLY_IN_THE_KERNEL, *OF_THE_MODEL_FILE, *measured}
