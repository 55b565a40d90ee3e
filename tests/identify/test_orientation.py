"""An actuator takes energy: its loops run anticlockwise, however a laboratory counted."""

from dataclasses import replace

import numpy as np
import pytest

from identify.loops import area
from identify.orientation import oriented
from measure import Loop
from simulate.law import loop_force


def loop():
    t = np.arange(1500) / 300.0
    w = 2 * np.pi
    u = 0.05 * np.sin(w * t)
    force = loop_force(np.array([-0.25, 2.79, -0.3, 2.89, 400.0]), t, u, 0 * t, 0 * t, 2.8)
    return Loop(t, u, force)


@pytest.mark.parametrize(("elongation", "force", "word"), [(-1, 1, "elongation"), (1, -1, "force"), (1, 1, ""), (-1, -1, "")])
def test_a_sign_that_was_counted_the_other_way_is_turned_and_said(elongation, force, word):
    given = replace(loop(), elongation_m=elongation * loop().elongation_m, force_N=force * loop().force_N)
    data, turned = oriented([given])
    assert area(data[0], data[0].force_N) > 0.0
    assert turned.quantity == word
    assert f"{word}" in turned.sentence


def test_loops_that_disagree_are_left_as_they_are():
    other = replace(loop(), elongation_m=-loop().elongation_m)
    data, turned = oriented([loop(), other])
    assert not turned.sentence
    assert area(data[1], data[1].force_N) < 0.0
