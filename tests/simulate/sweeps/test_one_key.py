"""A key of the model means the same wherever it is named: set by hand, as a factor, in a list of runs."""

import time
from dataclasses import replace

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.files.model_file import document_of, model_from, with_changes
from simulate.files.settings import with_settings
from simulate.model.model import value_of, with_value
from simulate.sweeps.factors import factor_of
from simulate.sweeps.sweep import responses_of

KEYS = {
    "actuator.b_l_N[0]": 2.85,
    "actuator.b_u_N[3]": 2.95,
    "actuator.initial_force_N[1]": 2.7,
    "actuator.stored_force_N[0]": 2.85,
    "actuator.stored_force_N": 2.85,
    "actuator.b_l_N": 2.85,
    "platform.mass_kg": 0.9,
    "release.theta_rad[2]": 0.01,
}


@pytest.mark.parametrize("key", KEYS)
def test_set_by_hand_and_as_a_factor_a_key_gives_the_same_model(prototype, key):
    by_hand = with_settings(prototype, [f"{key}={KEYS[key]}"])
    low = 2 * value_of(prototype, key) - KEYS[key]
    span = sorted((low, KEYS[key]))
    factor = factor_of(prototype, f"{key}={span[0]}..{span[1]}", "A")
    as_factor = factor.applied(prototype, 1.0 if span[1] == KEYS[key] else -1.0)
    assert as_factor == by_hand == with_value(prototype, key, KEYS[key])
    assert model_from(document_of(by_hand), "file") == by_hand


def test_b_l_moves_alone_and_the_stored_force_with_the_whole_band(prototype):
    alone = with_settings(prototype, ["actuator.b_l_N[0]=2.85"])
    assert alone.actuator == with_value(prototype, "actuator.b_l_N[0]", 2.85).actuator
    assert value_of(alone, "actuator.b_u_N[0]") == value_of(prototype, "actuator.b_u_N[0]")
    together = with_settings(prototype, ["actuator.stored_force_N[0]=2.85"])
    assert together.actuator == prototype.actuator.shifted((2.85 - 2.79, 0, 0, 0, 0, 0))
    turned = np.degrees(responses_of([alone, together])[:, 0])
    assert turned[1] - turned[0] > 2.0  # the initial force and the upper asymptote turn it as well


def test_the_stored_force_of_all_legs_keeps_what_they_differ_by(prototype):
    uneven = with_value(prototype, "actuator.initial_force_N", (2.7, 2.8, 2.9, 3.0, 3.1, 3.2))
    law = with_settings(uneven, ["actuator.stored_force_N=2.89"]).actuator
    assert law.b_l_N == 2.89
    assert law.initial_force_N == pytest.approx((2.8, 2.9, 3.0, 3.1, 3.2, 3.3))
    six = with_settings(prototype, ["actuator.stored_force_N=[2.7, 2.8, 2.9, 2.7, 2.8, 2.9]"]).actuator
    assert np.ptp(np.subtract(six.b_u_N, six.b_l_N)) == pytest.approx(0.0, abs=1e-12)


def test_a_run_of_a_list_may_name_the_stored_force(prototype):
    changed = with_changes(prototype, {"actuator": {"stored_force_N": 2.85}, "platform": {"mass_kg": 0.9}}, "run 1")
    assert changed == replace(
        with_settings(prototype, ["platform.mass_kg=0.9", "actuator.stored_force_N=2.85"]),
    )
    with pytest.raises(InputError, match="list of six"):
        with_changes(prototype, {"actuator": {"stored_force_N": "2.85"}}, "run 1")


@pytest.mark.parametrize(
    ("word", "named"),
    [
        ("actuator.stored_force_N[6]=2.8", "not one of the six legs"),
        ("actuator.stored_force_N[x]=2.8", "not one of the six legs"),
        ("actuator.stored_force_N=true", "number in N"),
        ("actuator.stored_force_N[0]=[1,2,3,4,5,6]", "number in N"),
        ("actuator.stored_force_N=[1,2]", "number in N"),
        ("actuator.stored_force_N=nan", "number in N"),
    ],
)
def test_a_stored_force_that_cannot_be_is_refused_in_a_sentence(prototype, word, named):
    with pytest.raises(InputError, match=named):
        with_settings(prototype, [word])


@pytest.mark.parametrize("levels", ["1" * 100_000 + "x", "." * 100_000 + "x", "1.." * 30_000])
def test_levels_of_a_hundred_thousand_signs_do_not_take_the_square_of_them(prototype, levels):
    begun = time.process_time()
    with pytest.raises(InputError):
        factor_of(prototype, f"platform.mass_kg={levels}", "A")
    assert time.process_time() - begun < 2.0
