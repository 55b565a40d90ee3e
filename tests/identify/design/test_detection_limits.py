"""What could have been seen is seen, nine times out of ten."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.selection.explain import explain
from simulate.effects import CurvedAsymptotes, StribeckFriction
from simulate.files.model_file import read_model

LOOPS = ((1.0, 0.02), (3.0, 0.02))


def explained(folder):
    return explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))


def smallest(found, name):
    return next(one for one in found.limits if one.effect.name == name).sizes


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
    sights = {one.effect.name: one for one in explained(campaign(None, 720, loops=LOOPS, deployments=())).limits}
    plain, shaped = sights["viscous-friction"], sights["stribeck-friction"]
    assert plain.easiest == plain.sizes
    assert shaped.easiest["force_N"] < 0.8 * shaped.sizes["force_N"] < 0.8


def test_loops_say_nothing_of_the_platform(campaign):
    sights = {one.effect.name: one.sizes for one in explained(campaign(None, 700, loops=LOOPS, deployments=())).limits}
    assert sights["viscous-friction"]["damping_N_s_per_m"] < 0.02
    assert not any(
        np.isfinite(list(sights[name].values())).any() for name in sights if name in ("pulley-inertia", "air-drag", "camera-roll")
    )
