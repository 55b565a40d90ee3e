"""What could have been seen is seen, nine times out of ten; and which test would split a class."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.design.next_test import next_tests
from identify.estimation.least_squares import before_the_stops, solve
from identify.estimation.problem import problem_of
from identify.selection.candidate_fits import fit_screened
from identify.selection.detection_limits import sight
from identify.selection.explain import explain
from identify.selection.null_hypothesis import Family, noise_like
from identify.selection.screening import screen
from simulate.effects import CurvedAsymptotes, HubInertia, PulleyInertia, StribeckFriction, ViscousFriction
from simulate.files.model_file import read_model
from simulate.model.effect import LegEffect, parameter

LOOPS = ((1.0, 0.02), (3.0, 0.02))


def explained(folder):
    return explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))


def smallest(found, name):
    return next(one for one in found.sights if one.effect.name == name).sizes


@pytest.mark.calibrate
def test_an_effect_of_the_smallest_size_that_could_be_seen_is_seen_about_nine_times_in_ten(campaign):
    """A bend of both asymptotes: of inertia, what the smoothing of the motion leaves would count too, beside 0.75 kg of it."""
    known = smallest(explained(campaign(None, 600, loops=LOOPS, deployments=())), "curved-asymptotes")["quadratic_N_per_m2"]
    hidden = [CurvedAsymptotes(known), CurvedAsymptotes(0.2 * known)]
    seen = [
        sum(explained(campaign(effect, seed + i, loops=LOOPS, deployments=())).verdict != "no-gap" for i in range(n))
        for effect, seed, n in zip(hidden, (601, 651), (20, 10), strict=True)
    ]
    assert seen[0] >= 15
    assert seen[1] <= 2


@pytest.mark.calibrate
def test_sticking_of_the_smallest_size_that_could_be_seen_is_seen_whatever_its_speed(campaign):
    known = smallest(explained(campaign(None, 660, loops=LOOPS, deployments=())), "stribeck-friction")["force_N"]
    hidden = [replace(shape, force_N=known) for shape in StribeckFriction().starts()] * 2
    seen = sum(explained(campaign(one, 661 + i, loops=LOOPS, deployments=())).verdict != "no-gap" for i, one in enumerate(hidden))
    assert seen >= 7


def test_what_shows_depends_on_the_shape(campaign):
    sights = {one.effect.name: one for one in explained(campaign(None, 720, loops=LOOPS, deployments=())).sights}
    plain, shaped = sights["viscous-friction"], sights["stribeck-friction"]
    assert plain.easiest == plain.sizes
    assert shaped.easiest["force_N"] < 0.8 * shaped.sizes["force_N"] < 0.8


@dataclass(frozen=True)
class Grease(LegEffect):
    """Linear damping that nobody believes to be more than next to nothing."""

    name = "grease"
    damping_N_s_per_m: float = parameter(0.0, low=-1e-5, high=1e-5, typical=0.05, doc="damping")

    @staticmethod
    def leg_force(u, v, t, R, travel, p):
        return -p[0] * v


def test_a_size_beyond_the_bounds_is_none(campaign, fitted):
    fit = fitted(campaign(None, 730, loops=LOOPS, deployments=()))
    free, bound = sight(fit, [fit.problem.model.effect(ViscousFriction), Grease()], noise_like(fit), Family(10.0))
    assert free.sizes["damping_N_s_per_m"] > 1e-5
    assert np.isnan(bound.sizes["damping_N_s_per_m"])
    assert np.isnan(bound.easiest["damping_N_s_per_m"])


def test_loops_say_nothing_of_the_platform(campaign):
    sights = {one.effect.name: one.sizes for one in explained(campaign(None, 700, loops=LOOPS, deployments=())).sights}
    assert sights["viscous-friction"]["damping_N_s_per_m"] < 0.02
    assert not any(
        np.isfinite(list(sights[name].values())).any() for name in sights if name in ("pulley-inertia", "air-drag", "camera-roll")
    )


def test_a_loop_is_foreseen_to_split_what_one_deployment_cannot(campaign):
    """On the platform the inertia of a pulley and of six hubs look much alike; a shaker has no pulley."""
    folder = campaign(HubInertia(0.746 + 0.002), 710, loops=(), deployments=({},), channels=("z_m",))
    runs = read_campaign([folder / "campaign.toml"])
    before = solve(before_the_stops(problem_of(read_model(folder / "model.toml"), runs)))
    hub, pulley = (fit_screened(before, one) for one in screen(before, [before.problem.model.effect(HubInertia), PulleyInertia()]))
    tests = next_tests(before, hub.fit, [pulley])
    chance = {test.condition.words: test.chances[pulley.name] for test in tests}
    by_loop = [value for words, value in chance.items() if words.startswith("a loop")]
    assert max(by_loop) > 0.9
    assert min(tests[0].chances.values()) == max(chance.values())
