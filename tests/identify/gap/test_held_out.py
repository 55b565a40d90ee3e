"""A run that took no part is looked for from the release that it has under the other model as well: either may end in a wrong minimum."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.gap import held_out
from identify.gap.held_out import carried_over
from identify.gap.size import NoiseOfChannel, gap_left
from identify.selection import explain
from identify.selection.explanation import Held


@pytest.fixture
def one(campaign, fitted):
    """A right model, fitted to two deployments, and the run that was held out."""
    folder = campaign(None, 97, loops=())
    (run,) = (run for run in read_campaign([folder / "campaign.toml"]) if run.hold_out)
    return fitted(folder), run


def lost(fit):
    """The same with its release far off, as a fit that ends in a wrong minimum has it."""
    q = fit.q.copy()
    q[fit.problem.first_nuisance : fit.problem.first_effect] += 2.0
    return replace(fit, q=q, gaps=fit.problem.gaps(q))


def test_the_release_of_the_other_model_is_tried(one, monkeypatch):
    base, run = one
    right = carried_over(base, run)
    monkeypatch.setattr(held_out, "solve_from_afar", lambda *_, **__: lost(right))
    monkeypatch.setattr(held_out, "released_again", lambda fit, _: fit)
    assert gap_left(carried_over(base, run)) > 3.0
    assert gap_left(carried_over(base, run, (right,))) == pytest.approx(gap_left(right), abs=0.01)
    assert held_out._with_release_of(lost(right), right).cost < right.cost + 0.1


@pytest.mark.parametrize("astray", ["before", "after"])
def test_under_each_of_two_models_the_run_is_tried_from_its_release_under_the_other(one, monkeypatch, astray):
    base, run = one
    right = carried_over(base, run)
    found = iter([lost(right), right] if astray == "before" else [right, lost(right)])
    monkeypatch.setattr(held_out, "solve_from_afar", lambda *_, **__: next(found))
    monkeypatch.setattr(held_out, "released_again", lambda fit, _: fit)
    for fit in held_out.held_out(run, base, base):
        assert gap_left(fit) == pytest.approx(gap_left(right), abs=0.01)


def test_a_worse_release_changes_nothing(one):
    base, run = one
    right = carried_over(base, run)
    assert held_out._with_release_of(right, lost(right)).cost <= right.cost


@pytest.mark.parametrize(("beside", "over"), [(None, 1.0), ((), 1.0), ((1.4,), 1.4)])
def test_gaps_are_measured_by_the_noise_that_a_draft_leaves_if_it_leaves_noise(beside, over):
    def channel(size) -> NoiseOfChannel:
        return NoiseOfChannel("run", "z_m", 1e-3, 0.5, 0.0, slice(0, 1), size)

    drafted: Any = None if beside is None else SimpleNamespace(noise=tuple(map(channel, beside)))
    assert [one.over for one in explain._noise_beside(drafted, [channel(2.0)])] == [over]


def leaving(size) -> Any:
    """A fit that leaves so many times the noise."""
    gaps = size * np.random.default_rng(1).normal(size=200)
    return SimpleNamespace(problem=SimpleNamespace(blocks=["z_m"]), part=lambda block: gaps)


@pytest.mark.parametrize(("before", "after", "grows"), [(3.0, 1.0, False), (1.0, 1.01, False), (1.0, 1.05, True), (1.0, 3.0, True)])
def test_names_make_a_held_out_run_worse_where_its_gap_grows_by_more_than_a_trifle(before, after, grows):
    assert Held(leaving(before), leaving(after)).grows is grows


@pytest.mark.parametrize(
    ("after", "lead", "contradicts"), [(1.05, -6.0, False), (1.05, -8.0, True), (1.0, -8.0, False), (1.05, np.nan, False)]
)
def test_names_are_contradicted_where_a_run_is_a_thousand_times_less_probable_with_them_and_its_gap_larger(after, lead, contradicts):
    assert bool(Held(leaving(1.0), leaving(after), lead).contradicts) is contradicts
