"""The verdict follows from the probabilities by one rule."""

from __future__ import annotations

import numpy as np
import pytest

from identify.selection.hypotheses import log_prior
from identify.selection.verdict import after_a_veto, credible_set, doing_without, in_a_class, verdict_of
from simulate.effects import CATALOGUE

HUB, PULLEY, PAIR = ("hub-inertia",), ("pulley-inertia",), ("hub-inertia", "viscous-friction")
TABLE = ("missing-force-along-time",)


@pytest.mark.parametrize(
    ("weights", "word", "names"),
    [
        ({(): 0.9, HUB: 0.1}, "no-gap", ()),
        ({(): 0.06, HUB: 0.94}, "class", HUB),  # nothing missing cannot be excluded
        ({(): 0.49, HUB: 0.26, PULLEY: 0.25}, "no-gap", ()),
        ({(): 0.45, HUB: 0.48, PULLEY: 0.07}, "no-gap", ()),  # of two that are as likely the one with fewer names
        ({(): 0.4, HUB: 0.53, PULLEY: 0.07}, "class", HUB),
        ({(): 0.51, HUB: 0.49}, "no-gap", ()),
        ({(): 0.4, HUB: 0.3, PULLEY: 0.3}, "no-gap", ()),
        ({(): 0.06, PAIR: 0.94}, "no-gap", ()),  # two names at once are much to say beside it
        ({(): 0.06, HUB: 0.86, TABLE: 0.08}, "no-gap", ()),
        ({(): 0.01, HUB: 0.99}, "named", HUB),
        ({HUB: 0.6, PULLEY: 0.39, (): 0.01}, "class", HUB),
        ({PAIR: 0.97, HUB: 0.03}, "several", PAIR),
        ({HUB: 0.7, PAIR: 0.29, (): 0.01}, "named", HUB),  # the friction is in doubt, the inertia is not
        ({TABLE: 0.98, HUB: 0.02}, "unknown", ()),
    ],
)
def test_the_word_and_the_names(weights, word, names):
    found = verdict_of(weights, closes_most=True)
    assert (found.word, found.names) == (word, names)


@pytest.mark.parametrize(
    ("weights", "word", "names"),
    [
        ({("stop-stiffness",): 0.99, (): 0.01}, "no-gap", ()),
        ({("hub-inertia", "stop-stiffness"): 0.99, (): 0.01}, "named", HUB),
        ({("stop-stiffness",): 0.6, ("series-play",): 0.39, (): 0.01}, "class", ("stop-stiffness",)),  # the play may be one
        ({HUB: 0.99, (): 0.01}, "named", HUB),
        ({("stop-stiffness",): 0.8, (): 0.2}, "no-gap", ()),
        ({HUB: 0.8, (): 0.2}, "class", HUB),
    ],
)
def test_an_error_hardly_beyond_its_tolerance_is_no_name(weights, word, names):
    found = doing_without(verdict_of(weights, closes_most=True), ["stop-stiffness"])
    assert (found.word, found.names) == (word, names)


def test_where_nothing_is_likelier_in_the_end_than_the_name_that_was_fitted_it_is_the_answer():
    assert verdict_of({(): 0.6, HUB: 0.4}, foremost=HUB, closes_most=True).word == "no-gap"
    assert verdict_of({(): 0.3, HUB: 0.7}, foremost=HUB, closes_most=True).word == "class"


@pytest.mark.parametrize("more", [0.001, -0.001])
def test_of_two_that_cannot_be_told_apart_rounding_does_not_choose(more):
    weights = {("leg-mass",): 0.495 + more, HUB: 0.495 - more, (): 0.01}
    assert verdict_of(weights, closes_most=True).names == HUB
    assert verdict_of({("leg-mass",): 0.7, HUB: 0.29, (): 0.01}, closes_most=True).names == ("leg-mass",)


def test_names_beside_a_force_without_a_name_are_partly_or_nothing():
    weights = {("hub-inertia", *TABLE): 0.97, HUB: 0.03}
    assert verdict_of(weights, closes_most=True).word == "partly"
    assert verdict_of(weights, closes_most=False).word == "unknown"


def test_names_that_leave_more_than_noise_do_not_explain_the_gap():
    """Whatever their weight beside each other: all hypotheses may be wrong."""
    assert verdict_of({HUB: 1.0}, closes_most=True, leaves_noise=False).word == "partly"
    assert verdict_of({HUB: 1.0}, closes_most=False, leaves_noise=False).word == "unknown"
    assert verdict_of({(): 1.0}, closes_most=False, leaves_noise=False).word == "unknown"


def test_what_may_stand_in_the_place_of_a_name_is_said():
    found = verdict_of({HUB: 0.5, PULLEY: 0.3, ("viscous-friction",): 0.18, (): 0.02}, closes_most=True)
    assert found.equivalents == {"hub-inertia": ("pulley-inertia", "viscous-friction")}


def test_the_credible_set_is_the_smallest_that_holds_its_share():
    assert credible_set({HUB: 0.5, PULLEY: 0.3, PAIR: 0.15, (): 0.05}) == [HUB, PULLEY, PAIR]


def test_listed_probabilities_add_up_to_one_and_tables_count_together():
    found = verdict_of({HUB: 0.5, TABLE: 0.3, ("missing-force-along-height",): 0.2}, closes_most=True)
    assert sum(found.weights.values()) == pytest.approx(1.0)
    assert found.weights["unknown"] == pytest.approx(0.5)


def test_most_of_the_prior_is_for_a_right_model_and_a_wrong_drawing_is_likelier_than_new_physics():
    prior = log_prior(CATALOGUE)
    assert prior(()) == pytest.approx(np.log(0.6))
    assert prior(("platform-mass",)) > prior(("hub-inertia",)) > prior(PAIR)
    assert prior(("hub-inertia",)) > prior(TABLE)


@pytest.mark.parametrize(
    ("weights", "leaves_noise", "word", "vetoed"),
    [
        ({HUB: 0.97, (): 0.02}, True, "unknown", HUB),
        ({HUB: 0.90, (): 0.08}, True, "no-gap", HUB),
        ({HUB: 0.90, (): 0.08}, False, "unknown", HUB),
        ({TABLE: 0.97, HUB: 0.02}, False, "unknown", ()),  # what was not to be said is not vetoed
    ],
)
def test_names_that_make_a_held_out_gap_larger_are_not_said_but_kept_as_vetoed(weights, leaves_noise, word, vetoed):
    before = verdict_of(weights, foremost=HUB, closes_most=TABLE not in weights, leaves_noise=TABLE not in weights)
    after = after_a_veto(before, leaves_noise=leaves_noise)
    assert (after.word, after.names, after.vetoed) == (word, (), vetoed)


def test_a_name_that_is_not_to_be_said_alone_stands_beside_the_most_probable_other_one():
    weights = {HUB: 0.97, ("leg-mass",): 0.02, (): 0.01}
    alone = in_a_class(verdict_of(weights, closes_most=True))
    assert (alone.word, alone.names, alone.equivalents) == ("class", HUB, {HUB[0]: ("leg-mass",)})
    two = verdict_of({(*HUB, "leg-mass"): 0.99, (): 0.01}, closes_most=True)
    assert in_a_class(two) == two
