"""What probabilities allow one to say, prior probabilities, and the likeliest step within bounds, on numbers that one can add up."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.criteria import ANOTHER, NOTHING, UNNAMED, WITHIN, WRONG_DRAWING
from identify.estimation.covariance import within_bounds
from identify.gap.size import halves
from identify.selection.hypotheses import log_prior
from identify.selection.model_errors import MODEL_ERRORS, as_wide
from identify.selection.verdict import credible_set, doing_without, foremost_of, verdict_of

EFFECTS = ("hub-inertia", "viscous-friction", "series-play", "gravity-imbalance")
A, B = ("hub-inertia",), ("viscous-friction",)
TABLE = ("missing-force-along-time",)


def said(weights, **more):
    return verdict_of(weights, **{"closes_most": True, **more})


def test_the_prior_of_all_single_names_and_of_nothing_adds_up_to_one():
    of = log_prior((*EFFECTS, *MODEL_ERRORS))
    singles = [of((name,)) for name in (*EFFECTS, *MODEL_ERRORS)]
    tables = 5.0 * np.exp(of(TABLE))
    assert np.exp(of(())) == pytest.approx(NOTHING + WITHIN)
    assert tables == pytest.approx(UNNAMED)
    assert np.exp(of(())) + np.sum(np.exp(singles)) + tables == pytest.approx(1.0)
    assert np.sum(np.exp([of((name,)) for name in MODEL_ERRORS])) == pytest.approx(WRONG_DRAWING)


def test_a_second_name_has_a_quarter_of_the_probability_of_a_first_one_and_a_third_of_a_second():
    of = log_prior(EFFECTS)
    first = np.exp(of(A))
    rest = 1.0 - NOTHING - WITHIN
    assert np.exp(of(A + B)) == pytest.approx(first**2 * ANOTHER / rest)
    assert np.exp(of((*A, *B, "series-play"))) == pytest.approx(first**3 * (ANOTHER / rest) ** 2)


@pytest.mark.parametrize(("after", "is_half"), [(2.23, True), (2.24, False), (0.9, True)])
def test_a_fit_halves_a_gap_by_the_squares_beyond_the_noise(after, is_half):
    """3^2 - 1 = 8, and 2.236^2 - 1 = 4."""
    fits: list[Any] = [SimpleNamespace(rms=rms) for rms in (3.0, after)]
    assert halves(*fits) == is_half


def test_five_per_cent_for_nothing_make_a_name_unsure_and_one_half_takes_it_away_if_noise_is_left():
    assert said({A: 0.94, (): 0.06}).word == "class"
    assert said({A: 0.49, (): 0.51}).word == "no-gap"
    assert said({A: 0.96, (): 0.04}).word == "named"
    assert said({A: 0.94, (): 0.06}, leaves_noise=False).word == "partly"


def test_five_per_cent_for_a_force_without_a_name_make_names_uncertain():
    assert said({A: 0.94, TABLE: 0.06}).word == "partly"
    assert said({A: 0.94, TABLE: 0.06}, closes_most=False).word == "unknown"
    assert said({A: 0.96, TABLE: 0.04}).word == "named"
    assert said({TABLE: 1.0}).word == "unknown"


def test_a_name_shares_its_place_with_those_of_the_set_that_holds_95_per_cent():
    both = said({A: 0.6, B: 0.4})
    assert both.word == "class"
    assert both.names == A
    assert both.equivalents == {A[0]: B}
    assert said({A: 0.96, B: 0.04}).equivalents == {A[0]: ()}
    two = said({A + B: 0.97, A: 0.03})
    assert two.word == "several"
    assert two.names == A + B


def test_probabilities_are_listed_by_words_the_largest_first_and_tables_together():
    listed = said({(): 0.1, A + B: 0.2, TABLE: 0.3, ("missing-force-along-height",): 0.4}).weights
    assert list(listed.items()) == [("unknown", pytest.approx(0.7)), ("hub-inertia + viscous-friction", 0.2), ("no-gap", 0.1)]


def test_the_credible_set_is_the_smallest_that_holds_95_per_cent():
    assert credible_set({(): 0.3, A: 0.66, B: 0.04}) == [A, ()]
    assert credible_set({(): 0.3, A: 0.6, B: 0.1}) == [A, (), B]


def test_of_two_that_are_hardly_less_probable_the_one_with_fewer_names_is_foremost():
    assert foremost_of({A + B: 0.5, A: 0.46}) == A
    assert foremost_of({A + B: 0.52, A: 0.46}) == A + B
    assert foremost_of({B: 0.5, A: 0.5}) == A


@pytest.mark.parametrize(
    ("weights", "slight", "word", "names"),
    [
        ({A: 1.0}, A, "no-gap", ()),
        ({A: 1.0}, B, "named", A),
        ({A + B: 1.0}, B, "named", A),
        ({A: 0.6, B: 0.4}, A, "class", A),
        ({(*A, *B, "series-play"): 1.0}, A, "several", (*B, "series-play")),
    ],
)
def test_a_slight_error_of_the_drawing_is_no_finding_unless_something_else_may_be_one(weights, slight, word, names):
    left = doing_without(said(weights), slight)
    assert (left.word, left.names) == (word, names)


def test_an_uncertain_verdict_keeps_its_slight_names():
    partly = said({A: 0.5, TABLE: 0.5})
    assert doing_without(partly, A) == partly


def test_a_prior_is_as_wide_as_the_effect_is_surely_large_but_for_what_it_knows_of_itself():
    known = np.array([np.inf, np.inf, np.inf, 3.0, 20.0])
    assert as_wide(known, np.array([1.0, -50.0, 50.0, 90.0, 90.0])).tolist() == [10.0, 10.0, 50.0, 3.0, 10.0]


COVARIANCE = np.array([[1.0, 0.8, 0.0], [0.8, 1.0, 0.0], [0.0, 0.0, 4.0]])
WIDE = np.full(3, 1e9)


def test_a_step_inside_its_bounds_stays_as_it_is():
    step = np.array([0.3, -0.4, 2.0])
    assert within_bounds(step, COVARIANCE, -WIDE, WIDE) == pytest.approx(step)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_is_held_at_its_bound_takes_along_what_is_correlated_with_it(side):
    ends = np.array([0.5, 1e9, 1e9])
    low, high = (-WIDE, ends) if side > 0 else (-ends, WIDE)
    found = within_bounds(side * np.array([1.5, 1.0, 2.0]), COVARIANCE, low, high)
    assert found == pytest.approx(side * np.array([0.5, 0.2, 2.0]))


def test_a_step_within_bounds_is_the_likeliest_one_there():
    """Compared with a search over the whole box."""
    step, low, high = np.array([2.0, -1.0, 3.0]), np.array([-1.0, -0.2, -1.0]), np.array([1.0, 1.0, 9.0])
    found = within_bounds(step, COVARIANCE, low, high)
    inverse = np.linalg.inv(COVARIANCE)
    grid = np.stack(np.meshgrid(np.linspace(-1.0, 1.0, 41), np.linspace(-0.2, 1.0, 25), [3.0], indexing="ij"), axis=-1).reshape(-1, 3)
    costs = np.einsum("ij,jk,ik->i", grid - step, inverse, grid - step)
    assert (found - step) @ inverse @ (found - step) <= costs.min() + 1e-9
