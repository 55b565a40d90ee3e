"""The grammar: a table of forces made by one of its formulas is given back as that formula, and noise as none."""

from __future__ import annotations

import numpy as np
import pytest

from identify.draft.choice import chosen_forms
from identify.draft.forms import FORMS
from identify.gap.leg_force import ForceAlongElongation, ForceAlongLegSpeed
from identify.gap.platform_force import KNOTS, ForceAlongHeight
from identify.gap.unnamed import Unnamed

SIGMA_N = 0.01
MADE = [
    (ForceAlongLegSpeed.over(-0.5, 0.5), "falling", (-0.4, 0.12)),
    (ForceAlongLegSpeed.over(-0.5, 0.5), "square", (-0.6,)),
    (ForceAlongLegSpeed.over(-0.5, 0.5), "saturating", (-0.2, 0.08)),
    (ForceAlongElongation.over(0.0, 0.4), "bump", (0.3, 0.25, 0.05)),
    (ForceAlongElongation.over(0.0, 0.4), "step", (-0.2, 0.15, 0.012)),
    (ForceAlongElongation.over(0.0, 0.4), "ripple", (0.1, 0.05, 0.09)),
    (ForceAlongHeight.over(0.2, 0.7), "constant", (0.15,)),
    (ForceAlongHeight.over(0.2, 0.7), "bump", (-3.0, 0.44, 0.03)),
]


def seen(table, force, seed):
    """A table whose forces were measured with independent noise."""
    places = np.arange(KNOTS)
    noisy = force + np.random.default_rng(seed).normal(0.0, SIGMA_N, KNOTS)
    return Unnamed(table, 0.0, places, noisy, np.full(KNOTS, SIGMA_N), 1.0, np.eye(KNOTS) / SIGMA_N**2, noisy / SIGMA_N**2)


@pytest.mark.parametrize(("table", "name", "values"), MADE, ids=lambda one: one if isinstance(one, str) else "")
def test_a_formula_is_found_again_with_its_numbers(table, name, values):
    form = next(one for one in FORMS if one.name == name)
    (found,) = chosen_forms([seen(table, form.force(table.places, values), 3)], 2000.0)
    assert found.form.name == name
    made, again = form.force(table.places, values), form.force(table.places, found.values)
    assert np.sqrt(np.mean((made - again) ** 2)) < SIGMA_N


@pytest.mark.parametrize("seed", range(20))
def test_noise_is_worth_no_formula(seed):
    tables = [seen(table, np.zeros(KNOTS), seed) for table in (ForceAlongLegSpeed.over(-0.5, 0.5), ForceAlongElongation.over(0.0, 0.4))]
    assert all(one.score < 0.0 for one in chosen_forms(tables, 2000.0))


def test_the_price_of_a_parameter_keeps_formulas_short():
    """A straight line is not said by a cubic, though a cubic is never farther from it."""
    table = ForceAlongLegSpeed.over(-0.5, 0.5)
    names = [chosen_forms([seen(table, -0.3 * table.places, seed)], 2000.0)[0].form.name for seed in range(10)]
    assert names.count("line") >= 9
