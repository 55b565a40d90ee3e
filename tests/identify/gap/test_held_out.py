"""A run that took no part is looked for from the release that it has under the other model as well: either may end in a wrong minimum."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from identify.campaign.runs import read_campaign
from identify.gap import held_out
from identify.gap.comparison import Held
from identify.gap.held_out import carried_over
from identify.gap.size import NoiseOfChannel, gap_left
from identify.noise.noise_model import ChannelNoise
from identify.selection import explain


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
    both = held_out.held_out(run, base, replace(base), ())
    for fit in (both.before, both.after):
        assert gap_left(fit) == pytest.approx(gap_left(right), abs=0.01)


def test_under_one_model_a_run_is_looked_for_once(one, monkeypatch):
    base, run = one
    found = iter([carried_over(base, run)])
    monkeypatch.setattr(held_out, "carried_over", lambda *_: next(found))
    both = held_out.held_out(run, base, base, ())
    assert both.before is both.after


def test_a_worse_release_changes_nothing(one):
    base, run = one
    right = carried_over(base, run)
    assert held_out._with_release_of(right, lost(right)).cost <= right.cost


@pytest.mark.parametrize(("beside", "over"), [(None, 1.0), ((), 1.0), ((1.4,), 1.4)])
def test_gaps_are_measured_by_the_noise_that_a_draft_leaves_if_it_leaves_noise(beside, over):
    def channel(size) -> NoiseOfChannel:
        return NoiseOfChannel("run", "z_m", 1e-3, 0.0, slice(0, 1), size, ChannelNoise(0.5))

    drafted: Any = None if beside is None else SimpleNamespace(noise=tuple(map(channel, beside)))
    assert [one.over for one in explain._noise_beside(drafted, [channel(2.0)])] == [over]


def of_channels(fit, over, memory=0.0) -> list[NoiseOfChannel]:
    """Noise of the same channels in another run: how loud beside what it was taken to be, and its memory."""
    channels = [block.channel for block in fit.problem.blocks]
    return [NoiseOfChannel("other", one, 1e-3, 0.0, slice(0, 1), over, ChannelNoise(memory)) for one in channels]


@pytest.mark.parametrize(
    ("slow", "fast", "over", "memory", "misses"),
    [
        (0.0, 1.0, 1.0, 0.0, False),  # noise
        (2.0, 1.0, 1.0, 0.0, True),  # a gap twice as large as the noise
        (8.0, 1.0, 1.0, 0.0, True),
        (2.0, 1.0, 1.0, 0.7, True),  # noise with a memory is not as slow
        (0.7, 1.0, 1.0, 0.0, False),  # a gap that shows, but smaller than the noise
        (0.0, 3.0, 1.0, 0.0, False),  # a film in worse light
        (2.0, 1.0, 2.0, 0.0, False),  # a gap as large as the noise that the other runs have
    ],
)
def test_a_held_out_run_misses_where_it_is_left_with_a_slow_gap_as_large_as_its_noise(one, slow, fast, over, memory, misses):
    base, run = one
    right = carried_over(base, run)
    gaps, chance = right.gaps.copy(), np.random.default_rng(5)
    for block in right.problem.blocks:
        n = block.rows.stop - block.rows.start
        wave = np.sqrt(2.0) * np.sin(np.linspace(0.0, 6.0 * np.pi, n))
        noise = lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], chance.normal(size=n))
        gaps[block.rows] = slow * wave + fast * noise
    held = Held(right, replace(right, gaps=gaps), noise=of_channels(right, over, memory))
    assert held.misses is misses
    assert held.left == pytest.approx(np.hypot(slow, fast) / over, rel=0.1)


def test_a_channel_that_no_other_run_has_is_taken_to_remember_as_much_as_any(one):
    base, run = one
    right = carried_over(base, run)
    remembers = lfilter([1.0], [1.0, -0.8], np.random.default_rng(6).normal(size=len(right.gaps)))
    held = Held(right, replace(right, gaps=remembers), noise=[replace(noise, channel="other") for noise in of_channels(right, 1.0, 0.8)])
    assert held.left > 1.5
    assert not held.misses
    assert replace(held, noise=()).misses
    runs = [*of_channels(right, 1.0, 0.8), *of_channels(right, 1.0, 0.0)]  # of runs that differ, the one whose noise remembers most
    assert not replace(held, noise=runs).misses


def test_the_noise_of_the_other_runs_stands_beside_a_run_held_out(one):
    base, run = one
    noise = of_channels(carried_over(base, run), 1.7)
    found = held_out.held_out(run, base, base, noise)
    assert found.left == pytest.approx(gap_left(found.after) / 1.7)


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
