"""Films side by side on all cores, and loops only where they can differ: the same numbers to the last bit."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, get_ident

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.estimation import problem as problems
from simulate.dispatch.compiled_code import compiled_once
from simulate.dispatch.threads import others_busy, side_by_side
from simulate.effects import CATALOGUE, StopStiffness
from simulate.files.model_file import read_model


def test_threads_change_no_bit(campaign, monkeypatch):
    folder = campaign(None, 631, hold_out=False)
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    q = 0.1 * np.random.default_rng(1).normal(size=len(problem.parameters))
    threads = problem.gaps(q), *problem.jacobian(q)
    monkeypatch.setattr(problems, "side_by_side", lambda task, count: [task(i) for i in range(count)])
    for many, alone in zip(threads, (problem.gaps(q), *problem.jacobian(q)), strict=True):
        assert np.array_equal(many, alone)


@pytest.mark.parametrize("name", CATALOGUE)
def test_loops_are_seen_to_move_with_an_effect_where_they_do(campaign, prototype, name):
    folder = campaign(None, 632, deployments=(), loops=((1.0, 0.02),), hold_out=False)
    problem = problem_of(prototype, read_campaign([folder / "campaign.toml"])).with_effects((CATALOGUE[name](),))
    here = np.zeros(len(problem.parameters))
    bounds = [(parameter.low, parameter.high) for parameter in problem.parameters[problem.first_effect :]]
    there = here.copy()
    there[problem.first_effect :] = [0.5 if high > 0.5 else -0.5 for _, high in bounds]
    moved = not np.array_equal(problem.gaps(there)[: problem.measured], problem.gaps(here)[: problem.measured])
    assert CATALOGUE[name].acts_on_shaker() or not moved
    assert np.array_equal(problem.gaps_beside([here, there])[1], problem.gaps(there))


def test_threads_that_ask_at_once_are_given_the_same_thing():
    together = Barrier(8)
    made = compiled_once(lambda key: object())

    def ask(_: int) -> object:
        together.wait()
        return made("stage")

    with ThreadPoolExecutor(8) as pool:
        assert len({id(found) for found in pool.map(ask, range(8))}) == 1


def test_a_task_within_a_task_is_done_by_the_same_thread():
    within = side_by_side(lambda _: {get_ident(), *side_by_side(lambda _: get_ident(), 4)}, 4)
    assert all(len(threads) == 1 for threads in within)
    assert not others_busy()


@pytest.mark.parametrize("longer", [False, True])
def test_what_does_not_show_has_no_slope_at_all_though_the_gaps_are_known_before(campaign, longer):
    """Before the stops their stiffness changes nothing: all points are simulated together, for one seen alone is rounded otherwise."""
    folder = campaign(None, 883, loops=(), deployments=({},))
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"])).until(0.3)
    problem = problem.with_effects([StopStiffness()])
    q, stiffness = problem.start, len(problem.start) - 1
    _, slopes = problem.jacobian(q, [0, stiffness], problem.gaps(q), longer=longer)
    assert np.linalg.norm(slopes[: problem.measured, 0]) > 1.0
    assert not slopes[: problem.measured, 1].any()
