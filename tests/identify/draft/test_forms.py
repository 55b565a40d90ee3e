"""The grammar: a table of forces made by one of its formulas is given back as that formula, and noise as none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.draft.choice import chosen_forms
from identify.draft.forms import FORMS, sum_of
from identify.gap.leg_force import ForceAlongElongation, ForceAlongLegSpeed
from identify.gap.platform_force import KNOTS, ForceAlongHeight, ForceAlongTime
from identify.gap.unnamed import Unnamed

SIGMA_N = 0.01
MADE = [
    (ForceAlongLegSpeed.over(-0.5, 0.5), "falling", (-0.4, 0.12)),
    (ForceAlongLegSpeed.over(-0.5, 0.5), "square", (-0.6,)),
    (ForceAlongLegSpeed.over(-0.5, 0.5), "saturating", (-0.2, 0.08)),
    (ForceAlongElongation.over(0.0, 0.4), "bump", (0.3, 0.25, 0.05)),
    (ForceAlongElongation.over(0.0, 0.4), "step", (-0.2, 0.15, 0.012)),
    (ForceAlongElongation.over(0.0, 0.4), "ripple", (0.1, 0.05, 0.09)),
    (ForceAlongElongation.over(0.0, 0.4), "stretch", (0.2, 0.12, 0.28, 0.008)),
    (ForceAlongHeight.over(0.2, 0.7), "constant", (0.15,)),
    (ForceAlongHeight.over(0.2, 0.7), "bump", (-3.0, 0.44, 0.03)),
]


def seen(table, force, seed):
    """A table whose forces were measured with independent noise, its log evidence half of what they gain."""
    places = np.arange(KNOTS)
    noisy = force + np.random.default_rng(seed).normal(0.0, SIGMA_N, KNOTS)
    log_z = 0.5 * float(noisy @ noisy) / SIGMA_N**2
    return Unnamed(table, log_z, places, noisy, np.full(KNOTS, SIGMA_N), 1.0, np.eye(KNOTS) / SIGMA_N**2, noisy / SIGMA_N**2)


@pytest.mark.parametrize(("table", "name", "values"), MADE, ids=lambda one: one if isinstance(one, str) else "")
def test_a_formula_is_found_again_with_its_numbers(table, name, values):
    form = next(one for one in FORMS if one.name == name)
    (found,) = chosen_forms([seen(table, form.force(table.places, values), 3)], 2000.0)
    assert found.form.name == name
    made, again = form.force(table.places, values), form.force(table.places, found.values)
    assert np.sqrt(np.mean((made - again) ** 2)) < SIGMA_N


SUMS = [
    (ForceAlongElongation.over(0.0, 0.4), "bump", "bump", (0.2, -0.15, 0.1, 0.03, 0.25, 0.05)),
    (ForceAlongHeight.over(0.2, 0.7), "constant", "ripple", (0.15, 0.1, 0.1, 0.2)),
]


@pytest.mark.parametrize(("table", "one", "other", "values"), SUMS, ids=lambda one: one if isinstance(one, str) else "")
def test_a_sum_of_two_formulas_is_found_again(table, one, other, values):
    of = {form.name: form for form in FORMS}
    made = sum_of(of[one], of[other]).force(table.places, values)
    (found,) = chosen_forms([seen(table, made, 3)], 2000.0)
    assert np.sqrt(np.mean((made - found.form.force(table.places, found.values)) ** 2)) < SIGMA_N
    assert "and" in found.form.name


@pytest.mark.parametrize("seed", range(3))
def test_what_cannot_come_near_the_best_score_is_left_out_and_nothing_else(seed):
    chance = np.random.default_rng(seed)
    of = {form.name: form for form in FORMS}
    legs, height = ForceAlongElongation.over(0.0, 0.4), ForceAlongHeight.over(0.2, 0.7)
    strong = seen(legs, of["bump"].force(legs.places, (0.3, 0.25, 0.05)), seed)
    tables = [seen(height, of["constant"].force(height.places, (0.02,)), seed), strong, seen(height, chance.normal(0.0, 0.05, KNOTS), seed)]
    every, near = chosen_forms(tables, 2000.0), chosen_forms(tables, 2000.0, 10.0)
    assert len(every) == 3
    assert [(one.form.name, one.score) for one in near] == [(one.form.name, one.score) for one in every[: len(near)]]
    assert all(one.score < every[0].score - 10.0 for one in every[len(near) :])
    assert len(near) < 3


def test_of_two_tables_the_likelier_one_is_drafted_from_though_the_other_gains_more_by_the_noise_that_it_leaves():
    """Of a draught a table over height had a log evidence 190 below that over time, and a gain of 270 000 where that had 11 000."""
    of = {form.name: form for form in FORMS}
    time, height = ForceAlongTime.over(0.0, 0.5), ForceAlongHeight.over(0.2, 0.7)
    likely = seen(time, of["bump"].force(time.places, (0.3, 0.25, 0.05)), 3)
    other = seen(height, of["bump"].force(height.places, (0.3, 0.45, 0.05)), 4)
    louder = replace(other, information=25.0 * other.information, drive=25.0 * other.drive, log_z=likely.log_z - 50.0)
    first, second = chosen_forms([louder, likely], 2000.0)
    assert first.table is likely
    assert second.score > first.score + 1000.0
    (only,) = chosen_forms([louder, likely], 2000.0, 10.0)
    assert only.table is likely


def test_a_sum_adds_its_parts_amplitudes_first():
    of = {form.name: form for form in FORMS}
    x, both = np.linspace(0.1, 0.9, 9), sum_of(of["ripple"], of["bump"])
    parts = of["ripple"].force(x, (0.1, 0.2, 0.3)) + of["bump"].force(x, (-0.5, 0.4, 0.1))
    assert both.force(x, (0.1, 0.2, -0.5, 0.3, 0.4, 0.1)) == pytest.approx(parts)
    assert [name for name, _ in both.amplitudes] == ["sine", "cosine", "second_level"]
    assert [shape.name for shape in both.shapes] == ["period", "second_place", "second_width"]


def test_a_force_to_the_side_is_told_from_one_upwards():
    table, force = ForceAlongHeight.over(0.2, 0.7), 0.3 * np.exp(-(((np.linspace(0.2, 0.7, KNOTS) - 0.4) / 0.05) ** 2))
    up = seen(table, np.zeros(KNOTS), 4)
    side = seen(table, force, 5)
    both = Unnamed(
        table,
        0.0,
        np.arange(2 * KNOTS),
        np.concatenate([up.values, side.values]),
        np.concatenate([up.sigma, side.sigma]),
        1.0,
        np.eye(2 * KNOTS) / SIGMA_N**2,
        np.concatenate([up.drive, side.drive]),
    )
    (found,) = chosen_forms([both], 2000.0)
    assert found.axis == 1
    assert found.form.name == "bump"
    assert chosen_forms([up], 2000.0)[0].axis == 0


ARMS = [(0, 0.05), (1, 0.05), (1, -0.2)]


def of_three_axes(table, force, moment, axis, seed, tie=0.0):
    """A table whose three axes were measured with noise; of a moment and the force along an axis only a mixture is known well."""
    chance, k, made = np.random.default_rng(seed), 3 * KNOTS, np.zeros(3 * KNOTS)
    made[axis * KNOTS : (axis + 1) * KNOTS], made[2 * KNOTS :] = force, moment
    sigma = np.concatenate([np.full(2 * KNOTS, SIGMA_N), np.full(KNOTS, 0.1 * SIGMA_N)])
    ties = np.eye(k)
    ties[2 * KNOTS :, axis * KNOTS : (axis + 1) * KNOTS] = tie * np.eye(KNOTS)
    root = ties / sigma[:, None]
    information, seen_of = root.T @ root, root @ made + chance.normal(size=k)
    return Unnamed(table, 0.0, np.arange(k), np.linalg.solve(root, seen_of), sigma, 1.0, information, root.T @ seen_of)


@pytest.mark.parametrize("tie", [0.0, 0.1])
@pytest.mark.parametrize(("axis", "arm_m"), ARMS)
def test_a_force_off_the_centre_of_mass_is_found_with_its_arm(axis, arm_m, tie):
    table = ForceAlongTime.over(0.0, 0.6)
    force = -0.1 * np.sin(4.0 * np.pi * table.places) ** 2
    found = chosen_forms([of_three_axes(table, force, arm_m * force, axis, 5, tie)], 500.0)[0]
    assert found.axis == axis
    assert found.arm_m == pytest.approx(arm_m, rel=0.25)
    assert np.sqrt(np.mean((force - found.form.force(table.places, found.values)) ** 2)) < SIGMA_N


@pytest.mark.parametrize(("force", "moment", "axis"), [(0.1, 0.0, 1), (0.0, 0.01, 2)])
def test_a_force_without_a_moment_and_a_moment_without_a_force_have_no_arm(force, moment, axis):
    table = ForceAlongTime.over(0.0, 0.6)
    course = np.sin(4.0 * np.pi * table.places) ** 2
    found = chosen_forms([of_three_axes(table, force * course, moment * course, 1, 6)], 500.0)[0]
    assert (found.axis, found.arm_m) == (axis, None)


@pytest.mark.parametrize("seed", range(20))
def test_noise_is_worth_no_formula(seed):
    tables = [seen(table, np.zeros(KNOTS), seed) for table in (ForceAlongLegSpeed.over(-0.5, 0.5), ForceAlongElongation.over(0.0, 0.4))]
    assert all(one.score < 0.0 for one in chosen_forms(tables, 2000.0))


def test_the_price_of_a_parameter_keeps_formulas_short():
    """A straight line is not said by a cubic, though a cubic is never farther from it."""
    table = ForceAlongLegSpeed.over(-0.5, 0.5)
    names = [chosen_forms([seen(table, -0.3 * table.places, seed)], 2000.0)[0].form.name for seed in range(5)]
    assert names.count("line") >= 4
