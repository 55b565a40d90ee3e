"""Numbers are stated as the measurements have them: how large effects usually are serves to compare hypotheses, and draws no number."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.criteria import EFFECT_SPREAD, STATED_SPREAD
from identify.estimation.parameters import sizes_unknown
from identify.estimation.problem import Fit
from identify.selection import findings
from identify.selection.courses import stepped
from identify.selection.evidence import Both
from identify.selection.other_side import all_sides, brought_to
from identify.selection.stand import Stand, Weighed
from simulate.effects import LegDisparity, PlatformInertia, RateDependentAsymptotes, Ripple, TransitionZone
from simulate.files.model_file import read_model


def stand_at(folder, effects, values=None):
    """A stand with the model file and its releases as they are given, the effects with these values."""
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"])).with_effects(effects)
    q = problem.start.copy()
    if values is not None:
        q[problem.first_effect :] = values / problem.scales[problem.first_effect :]
    return Stand.exact(Fit(problem, q, *problem.jacobian(q), True))


@pytest.mark.parametrize(
    ("kind", "free"),
    [
        (TransitionZone, [True, False]),  # a length is no size
        (Ripple, [True, False, False]),
        (LegDisparity, [False] * 6),  # what all legs have in common is the law's
        (PlatformInertia, [True] * 3),
        (RateDependentAsymptotes, [True] * 8),
    ],
)
def test_a_number_is_free_where_only_measurements_tell_how_large_it_is(kind, free):
    assert sizes_unknown(kind) == free


def test_priors_are_wide_where_numbers_are_stated_but_for_shapes_legs_and_what_is_known(campaign):
    stand = stand_at(campaign(None, 881, loops=(), deployments=({},), hold_out=False), [TransitionZone(), LegDisparity()])
    wide = Stand(stand.given, stand.fit, stand.errors, stand.sizes, widely=True)
    assert stand.columns.spread.tolist() == [EFFECT_SPREAD] * 8
    assert wide.columns.spread.tolist() == [STATED_SPREAD, *[EFFECT_SPREAD] * 7]


def eight_numbers(campaign, seed):
    """Numbers of thirty noticeable sizes each, of which two films determine a few directions only; a stand led from them, its evidence."""
    kind = RateDependentAsymptotes()
    true = np.random.default_rng(seed).normal(0.0, 30.0, 8) * kind.typical()
    deployments: tuple = ({}, {"geometry.stowed_height_m": 0.35})
    folder = campaign(kind.with_flat(true), 300 + seed, loops=(), deployments=deployments, hold_out=False)
    start = stand_at(folder, [kind], true)
    return true, *stepped(start, start.weighed())


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_intervals_hold_the_truth_where_films_alone_hardly_tell_the_numbers_apart(campaign, seed):
    true, stand, found = eight_numbers(campaign, seed)
    compared = Weighed(stand, stand, Both(found, None))
    (stated,) = all_sides(compared)
    before, after = (findings._estimated(one, RateDependentAsymptotes.name) for one in (compared, stated))
    assert held(after.ci95, true) == 8
    assert held(before.ci95, true) < 8
    assert np.max(after.stderr / before.stderr) > 2.0
    again = brought_to(compared, stated.stand)
    assert again.fit is stated.fit
    assert again.log_z == pytest.approx(compared.log_z, abs=3.0)  # the same integral, taken from another place
    assert stated.log_z < compared.log_z  # a wider prior


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5, 18])
def test_numbers_are_followed_along_a_bent_line_to_where_they_are_stated(campaign, seed):
    """Straight steps ended 219 and 48 less likely, with 5 and 7 of the eight numbers in their intervals."""
    true, stand, found = eight_numbers(campaign, seed)
    (stated,) = all_sides(Weighed(stand, stand, Both(found, None)))
    assert held(findings._estimated(stated, RateDependentAsymptotes.name).ci95, true) == 8
    assert stated.fit.rms < 1.05


def held(ci95, true):
    """How many numbers lie in their intervals."""
    return int(np.sum((ci95[:, 0] <= true) & (true <= ci95[:, 1])))


@pytest.mark.parametrize("is_exact", [True, False])
def test_a_hypothesis_goes_where_it_is_stated_with_its_likelier_stand_and_its_own_priors(campaign, is_exact):
    stand = stand_at(campaign(None, 882, loops=(), deployments=({},), hold_out=False), [TransitionZone()])
    other, found = replace(stand, is_fresh=False), stand.weighed()
    one = Weighed(stand, other, Both(found, replace(found, log_z=found.log_z + (-50.0 if is_exact else 50.0))))
    there = brought_to(one, stand_at_law(stand, 0.1))
    moved, left = (there.exact, there.within) if is_exact else (there.within, there.exact)
    assert left is (other if is_exact else stand)
    assert moved.fit.q[0] == 0.1
    assert not moved.widely
    assert there.stand is moved
    assert there.evidence.columns.spread.tolist() == [EFFECT_SPREAD] * 2


def stand_at_law(stand, place):
    """The same with another force law, its effects with wide priors."""
    q = stand.fit.q.copy()
    q[0] = place
    return replace(stand.at(stand.fit.problem, q, stand.sizes), widely=True)


def test_what_a_name_brings_is_what_it_was_compared_by(shaken):
    """The wide prior of what is stated costs a log evidence of ln 10 for each number."""
    assert shaken.findings[0].delta_bic == pytest.approx(shaken.ranking[0].delta_bic, abs=2.0)
