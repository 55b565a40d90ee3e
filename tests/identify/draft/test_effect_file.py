"""The file of a drafted effect: an effect like any other, on a rig of any size."""

from __future__ import annotations

import numpy as np
import pytest

from identify.draft.effect_file import Origin, Variable, effect_from, formula_text, free_name, source_of
from identify.draft.forms import FORMS, sum_of
from simulate.files.own_effects import catalogue_with
from simulate.model.measures import Measures

VARIABLES = [
    Variable("elongation", True),
    Variable("leg speed", True),
    Variable("height", False),
    Variable("time", False),
    Variable("speed", False),
    Variable("height", False, 1),
    Variable("time", False, 2),
    Variable("time", False, 1, has_arm=True),
    Variable("height", False, 0, has_arm=True),
]
ALL_FORMS = [*FORMS, sum_of(FORMS[-1], FORMS[-3]), sum_of(FORMS[0], FORMS[5])]
LARGE = Measures(force=50.0, length=3.0, time=2.0)


ARM_M = -0.07


def values_of(form, variable):
    """Some numbers for a form: amplitudes of both signs, shapes within the variable's range, an arm behind them where it has one."""
    arm = [ARM_M] if variable.has_arm else []
    return [*_of(form), *arm]


def _of(form):
    return [*(0.3 * (-1.0) ** i for i in range(len(form.amplitudes))), *([0.5] if form.shapes else []), *([0.1] * (len(form.shapes) - 1))]


@pytest.mark.parametrize("variable", VARIABLES, ids=lambda one: f"{one.kind} {one.name}")
@pytest.mark.parametrize("form", ALL_FORMS, ids=lambda one: one.name)
def test_the_file_holds_the_formula_and_its_method_computes_it(form, variable):
    values = values_of(form, variable)
    kind = effect_from(source_of(form, values, variable, (0.1, 0.9), Origin("drafted", "Made for a test.", LARGE)))
    effect = kind().with_flat(np.array(values))
    assert formula_text(form, values, variable) in (kind.__doc__ or "")
    for x in (0.15, 0.5, 0.8):
        expected = float(form.force(np.array([x]), values)[0])
        assert force_of(effect, variable, x) == pytest.approx(expected, rel=1e-12)


def force_of(effect, variable, x):
    """The force that the effect's own method gives where its variable is x."""
    p = effect.flat()
    if variable.in_legs:
        u, v = (x, 0.0) if variable.name == "elongation" else (0.0, x)
        return effect.leg_force(u, v, 0.0, 0.1, 0.0, p)
    wrench, pose, twist = np.zeros(6), np.zeros(6), np.zeros(6)
    pose[2] = x if variable.name == "height" else 0.0
    twist[2] = x if variable.name == "speed" else 0.0
    effect.platform_wrench(x if variable.name == "time" else 0.0, pose, twist, p, wrench)
    force = wrench[(2, 0, 4)[variable.axis]]
    if variable.has_arm:
        assert wrench[4] == pytest.approx(ARM_M * force)
    assert np.count_nonzero(wrench) <= 1 + variable.has_arm
    return force


@pytest.mark.parametrize("form", FORMS, ids=lambda one: one.name)
def test_bounds_hold_what_was_drafted_on_a_rig_of_any_size(form):
    values = np.array(values_of(form, Variable("elongation", True)))
    kind = effect_from(source_of(form, values, Variable("elongation", True), (0.1, 0.9), Origin("drafted", "", LARGE)))
    low, high = np.array(list(kind.bounds(None, LARGE).values())).T
    assert (low < values).all()
    assert (values < high).all()
    assert (kind.typical(LARGE) < high - low).all()
    count = len(form.amplitudes)
    assert high[:count] == pytest.approx(100.0 * np.abs(values[:count]), rel=1e-4)  # on this rig, whatever stands in the file
    assert [(low[k], high[k]) for k, shape in enumerate(form.shapes, count)] == [
        pytest.approx(shape.bounds(0.1, 0.9), rel=1e-4) for shape in form.shapes
    ]


def test_the_arm_of_a_force_stands_in_its_formula_and_is_where_the_effect_begins():
    form = next(one for one in FORMS if one.name == "bump")
    variable, values = Variable("time", False, 1, has_arm=True), [0.3, 0.2, 0.05, ARM_M]
    assert formula_text(form, values, variable).endswith(" N at an arm of -0.07 m")
    kind = effect_from(source_of(form, values, variable, (0.0, 0.6), Origin("drafted", "", LARGE)))
    assert kind().flat().tolist() == [0.0, 0.2, 0.05, ARM_M]
    low, high = list(kind.bounds(None, LARGE).values())[-1]
    assert low < ARM_M < high


def test_a_drafted_effect_is_off_by_default_and_read_by_every_command(tmp_path):
    form = next(one for one in FORMS if one.name == "falling")
    file = tmp_path / "drafted_effect.py"
    file.write_text(source_of(form, [-0.4, 0.12], Variable("leg speed", True), (-0.5, 0.5), Origin("drafted", "", Measures())))
    kind = catalogue_with([file])["drafted"]
    assert force_of(kind(), Variable("leg speed", True), 0.3) == 0.0


def test_a_second_draft_has_another_name():
    assert free_name({"hub-inertia"}) == "drafted"
    assert free_name({"drafted", "drafted-2"}) == "drafted-3"
