"""The compiled kernel against the same physics in plain NumPy, on rigs without symmetry, drawn at random, with every effect."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simulate.deployment.deploy import deploy
from simulate.dispatch.formulas import count_with_power, pointers_of
from simulate.effects import CATALOGUE
from simulate.kernel.block import Block, block_memory, fill, first_stage, later_stages, release
from simulate.kernel.layout import ALONE, RATE, TIME
from simulate.kernel.layout import STEP as STEP_ROW
from simulate.kernel.model_rows import formula_table_of, row_of
from simulate.kernel.reference import Reference, carried
from simulate.kernel.runge_kutta import compiled_stage
from simulate.model.model import Release, Simulation

# Off by default and far from linear: drawn between its default and its noticeable size.
IN_THE_KERNEL = [kind for kind in CATALOGUE.values() if kind.acts_on != "measurement"]
STEP = 2.5e-4


def drawn(lopsided, seed, kinds):
    """A rig with its joints, inertias, forces and release drawn anew, and these effects at random sizes."""
    rng = np.random.default_rng(seed)

    def near(values, spread) -> Any:
        moved = np.asarray(values) + rng.uniform(-spread, spread, np.shape(values))
        return tuple(map(tuple, moved)) if moved.ndim > 1 else tuple(moved)

    g, law, body = lopsided.geometry, lopsided.actuator, lopsided.platform
    b = np.asarray(law.b_l_N) + rng.uniform(-0.05, 0.05, 6)
    shares = {kind: rng.uniform(0.2, 1.0) for kind in kinds}
    effects = tuple(kind().with_flat(kind().flat() + share * (kind.typical() - kind().flat())) for kind, share in shares.items())
    return replace(
        lopsided,
        geometry=replace(g, base_joints_m=near(g.base_joints_m, 0.03), platform_joints_m=near(g.platform_joints_m, 0.02)),
        platform=replace(body, inertia_kg_m2=tuple(rng.uniform(0.004, 0.009, 3)), centre_of_mass_m=near(body.centre_of_mass_m, 0.01)),
        actuator=replace(law, b_l_N=tuple(b), b_u_N=tuple(b + 0.1)),
        release=Release(near((0.0,) * 3, 5e-3), near((0.0,) * 3, 0.1), near((0.0,) * 3, 0.2), near((0.0,) * 3, 1.0)),
        effects=effects,
        simulation=Simulation(0.6, 400.0, STEP),
    )


def kernel_block(model):
    table = formula_table_of(model)
    row, count = row_of(model), count_with_power(table)
    block = Block(*block_memory(len(row), ALONE, count, 0), pointers_of(table), compiled_stage(ALONE, True, False).address, ALONE, count)
    release(block, 0, row)
    fill(block, STEP_ROW, STEP)
    return block


def require_same_accelerations(model, steps=4):
    """At the release and at the start of some steps."""
    block, reference = kernel_block(model), Reference(model)
    state, legs = reference.release(), reference.legs_at_release()
    for k in range(steps):
        t = k * STEP
        fill(block, TIME, t)
        first_stage(block)
        first, u, force = reference.rate(state, t, legs, max(t - STEP, 0.0))
        theirs = np.concatenate([first.velocity, first.spin])
        ours = block.w[RATE + 7 : RATE + 13]
        assert np.max(np.abs(ours - theirs)) < 1e-9 * np.max(np.abs(theirs)), (k, ours, theirs)
        legs = carried(legs, u, force, reference.strip(u, legs))
        state = reference.later(state, first, t, STEP, legs)
        later_stages(block)


def test_accelerations_agree_with_all_effects_at_once(lopsided):
    require_same_accelerations(drawn(lopsided, 0, IN_THE_KERNEL), steps=2)


@pytest.mark.calibrate
@pytest.mark.parametrize("kind", IN_THE_KERNEL, ids=lambda kind: kind.name)
def test_accelerations_agree_with_each_effect(lopsided, kind):
    for seed in range(3):
        require_same_accelerations(drawn(lopsided, seed, [kind]))


@pytest.mark.parametrize("seed", [pytest.param(0, marks=pytest.mark.slow), *(pytest.param(k, marks=pytest.mark.calibrate) for k in (1, 2))])
def test_whole_runs_agree_to_a_hundredth_of_a_millimetre_over_stops_and_rebound(lopsided, seed):
    kinds = [IN_THE_KERNEL[i] for i in np.random.default_rng(seed).permutation(len(IN_THE_KERNEL))[:6]]
    model = drawn(lopsided, seed, kinds)
    run = deploy(model)
    place, quaternion = Reference(model).run(STEP, round(0.6 / STEP))
    assert min(run.work_J["by_stops"]) < -1e-4, "no stop was reached, nothing was tested"
    every = round(1 / 400.0 / STEP)
    assert np.max(np.abs(run.samples[:, :3] - place[::every])) < 1e-5
    assert np.max(np.abs(run.samples[:, 3:7] - quaternion[::every])) < 1e-5
