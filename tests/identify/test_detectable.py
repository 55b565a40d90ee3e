"""What could have been seen is seen, nine times out of ten; and which test would split a class."""

from __future__ import annotations

import numpy as np
import pytest

from identify.campaign import read_campaign
from identify.candidates import fit_screened
from identify.explain import explain
from identify.fit import before_the_stops, solve
from identify.next_test import next_tests
from identify.problem import problem_of
from identify.screening import screen
from simulate.effects import CurvedAsymptotes, HubInertia, PulleyInertia
from simulate.model_file import read_model

LOOPS = ((1.0, 0.02), (3.0, 0.02))


def explained(folder):
    return explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))


def smallest(found, name):
    return next(one for one in found.sights if one.effect.name == name).sizes


@pytest.mark.slow
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
