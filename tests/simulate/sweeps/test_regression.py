"""Designs and their regression: exact on functions that are known."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from scipy.linalg import hadamard

from measure.common.errors import InputError
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import factor_of, factors_of, paper_factors
from simulate.sweeps.regression import coefficients_of, formula, predicted, variability_percent, walsh_hadamard

LETTERS = "ABCDEF"


def cubic(coded):
    """A response whose coefficients are known: 3 + 5 A - 2 C + 4 ACE."""
    return 3.0 + 5.0 * coded[:, 0] - 2.0 * coded[:, 2] + 4.0 * coded[:, 0] * coded[:, 2] * coded[:, 4]


def test_fast_transform_is_the_product_with_the_hadamard_matrix():
    values = np.random.default_rng(1).normal(size=64)
    assert walsh_hadamard(values) == pytest.approx(hadamard(64) @ values)


def test_full_design_gives_back_the_coefficients_of_the_response():
    design = design_of("full", 6, None, 0)
    found = coefficients_of(design, LETTERS, lambda: iter([cubic(design.piece(0, 64))]))
    assert len(found) == 64
    assert {name: value for name, value in found.items() if abs(value) > 1e-12} == pytest.approx({"1": 3, "A": 5, "C": -2, "ACE": 4})


def test_shares_of_variability_are_squares_and_add_up():
    shares = variability_percent({"1": 100.0, "A": 3.0, "AB": -4.0})
    assert shares == pytest.approx({"A": 36.0, "AB": 64.0})


@pytest.mark.parametrize("kind", ["latin-hypercube", "sobol", "random"])
def test_sampled_designs_recover_the_same_coefficients_by_least_squares(kind):
    design = design_of(kind, 6, 1024, 3)
    coded = design.piece(0, 1024)
    assert np.all(np.abs(coded) <= 1)
    found = coefficients_of(design, LETTERS, lambda: iter(np.split(cubic(coded), 4)))
    assert max(abs(found[name] - value) for name, value in {"1": 3.0, "A": 5.0, "C": -2.0, "ACE": 4.0, "BD": 0.0}.items()) < 1e-9
    assert predicted(found, LETTERS, coded) == pytest.approx(cubic(coded))


def test_runs_without_a_response_leave_the_coefficients_right():
    design = design_of("full", 6, None, 0)
    values = cubic(design.piece(0, 64))
    values[[3, 40, 41]] = np.nan
    found = coefficients_of(design, LETTERS, lambda: iter([values]))
    assert found["A"] == pytest.approx(5.0)
    assert found["C"] == pytest.approx(-2.0)


@pytest.mark.parametrize("factors", [5, 8, 12])
def test_fractional_design_keeps_main_effects_and_pairs_apart(factors):
    design = design_of("fractional", factors, None, 0)
    coded = design.piece(0, design.runs)
    assert design.runs < 1 << factors
    assert np.all(np.abs(coded) == 1)
    columns = [coded[:, i] for i in range(factors)] + [coded[:, i] * coded[:, j] for i, j in combinations(range(factors), 2)]
    gram = np.array(columns) @ np.array(columns).T / design.runs
    assert np.max(np.abs(gram - np.eye(len(columns)))) < 1e-12
    letters = "ABCDEFGHJKLM"[:factors]
    values = 2.0 + 3.0 * coded[:, -1] - coded[:, 0] * coded[:, -1]
    found = coefficients_of(design, letters, lambda: iter([values]))
    assert found[letters[-1]] == pytest.approx(3.0)
    assert found["A" + letters[-1]] == pytest.approx(-1.0)


@pytest.mark.parametrize("kind", ["full", "fractional", "random", "sobol", "latin-hypercube"])
def test_a_run_has_the_same_levels_whatever_the_pieces(kind):
    runs = None if kind in ("full", "fractional") else 2048
    design = design_of(kind, 11, runs, 5)
    whole = design.piece(0, design.runs)
    cut = np.concatenate([design.piece(0, 7), design.piece(7, 1100), design.piece(1100, design.runs)]) if design.runs > 1100 else whole
    np.testing.assert_array_equal(whole, cut)


def test_latin_hypercube_puts_one_run_in_every_slice_of_every_factor():
    coded = design_of("latin-hypercube", 3, 50, 1).piece(0, 50)
    for column in coded.T:
        assert sorted(np.floor((column + 1) * 25).astype(int)) == list(range(50))


def test_formula_puts_equal_terms_into_a_bracket_with_their_signs():
    found = {"1": 0.0, "A": 86.6, "C": -86.61, "E": 86.59, "ACE": 5.86, "B": 0.001}
    assert formula(found, "theta_z") == "theta_z = 86.6 (A - C + E) + 5.86 ACE + ..."
    assert formula({"1": 2.5, "A": -1.0}, "y") == "y = 2.5 - 1 A"
    assert formula({"1": 0.0, "A": 0.0}, "y") == "y = 0 + ..."


def test_paper_factors_are_stored_force_and_slope_of_each_leg_under_its_letters(prototype):
    factors = paper_factors(prototype)
    assert "".join(factor.letter for factor in factors) == "ABCDEFGHJKLM"
    assert factors[0].key == "actuator.stored_force_N[0]"
    assert (factors[0].low, factors[0].high) == pytest.approx((2.511, 3.069))
    assert factors[3].key == "actuator.a_l_N_per_m[1]"


def test_a_factor_on_the_stored_force_moves_the_whole_band_of_its_leg(prototype):
    factor = factor_of(prototype, "actuator.stored_force_N[2]=+-0.1", "A")
    law: Any = factor.applied(prototype, -1.0).actuator
    assert law.b_l_N[2] == pytest.approx(2.69)
    assert law.b_u_N[2] == pytest.approx(2.79)
    assert law.initial_force_N[2] == pytest.approx(2.887)
    assert law.b_u_N[0] == 2.89


@pytest.mark.parametrize(
    ("word", "named"),
    [
        ("platform.mas_kg=+-10%", "no number of the model"),
        ("platform.mass_kg=about 10", "levels are written"),
        ("platform.mass_kg", "levels are written"),
        ("gravity.acceleration_m_per_s2=+-10%", "two different ones"),
        ("platform.mass_kg=0.9..0.8", "two different ones"),
        ("platform.mass_kg=+-1e", "levels are written"),
    ],
)
def test_a_factor_that_cannot_be_read_is_refused(prototype, word, named):
    with pytest.raises(InputError, match=named):
        factors_of(prototype, [word])


@pytest.mark.parametrize(
    ("kind", "factors", "runs"), [("full", 6, 63), ("full", 25, None), ("fractional", 6, 48), ("sobol", 3, 100), ("random", 3, 0)]
)
def test_a_number_of_runs_that_a_design_cannot_have_is_refused(kind, factors, runs):
    with pytest.raises(InputError, match="runs"):
        design_of(kind, factors, runs, 0)


def test_a_regression_has_at_most_three_factors_in_a_product_and_a_quarter_more_runs_than_terms():
    def longest(runs, kind="random", factors=6):
        design = design_of(kind, factors, runs, 0)
        coded = design.piece(0, design.runs)
        found = coefficients_of(design, "ABCDEFGH"[:factors], lambda: iter([np.prod(coded, axis=1)]))
        return max((len(name.replace("1", "")) for name in found), default=None), len(found)

    # 1, 6, 15 and 20 terms of nought to three factors
    assert longest(1000) == (3, 42)
    assert [longest(runs) for runs in (53, 52, 28, 27, 9, 8, 2, 1)] == [
        (3, 42), (2, 22), (2, 22), (1, 7), (1, 7), (0, 1), (0, 1), (None, 0),
    ]  # fmt: skip
    assert longest(None, "fractional", 8)[0] == 3


@pytest.mark.parametrize(("factors", "runs"), [(3, 8), (4, 16), (5, 16), (6, 32), (7, 64), (10, 128)])
def test_a_fractional_design_has_as_few_runs_as_keep_pairs_apart(factors, runs):
    """Box, Hunter and Hunter's table of resolution V; of eight factors it has 64 runs, where a greedy choice of columns needs 128."""
    assert design_of("fractional", factors, None, 0).runs == runs


@pytest.mark.parametrize(
    ("factors", "runs", "resolution"), [(8, 16, 4), (7, 16, 4), (7, 8, 3), (15, 16, 3), (6, 16, 4), (5, 16, 5), (12, 256, 5)]
)
def test_a_fractional_design_of_given_runs_is_as_clear_as_it_can_be(factors, runs, resolution):
    """The shortest product of factors that is the same in all runs has so many letters, or more."""
    coded = design_of("fractional", factors, runs, 0).piece(0, runs)
    assert coded.shape == (runs, factors)
    same = {
        order
        for order in range(1, resolution + 1)
        for term in combinations(range(factors), order)
        if abs(np.prod(coded[:, list(term)], axis=1).sum()) == runs
    }
    assert not {order for order in same if order < resolution}
    if resolution < 5:
        assert resolution in same


@pytest.mark.parametrize(("factors", "runs"), [(7, 7), (7, 12), (3, 16), (8, 8)])
def test_a_fractional_design_has_a_power_of_two_of_runs_above_its_factors_and_no_more_than_all(factors, runs):
    with pytest.raises(InputError, match=f"a power of two of runs above {factors}"):
        design_of("fractional", factors, runs, 0)


def test_run_zero_of_a_two_level_design_has_every_factor_low_and_the_last_every_factor_high():
    coded = design_of("full", 3, None, 0).piece(0, 8)
    assert coded[0].tolist() == [-1.0, -1.0, -1.0]
    assert coded[1].tolist() == [1.0, -1.0, -1.0]
    assert coded[-1].tolist() == [1.0, 1.0, 1.0]
