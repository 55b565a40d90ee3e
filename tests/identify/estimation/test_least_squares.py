"""Where a fit begins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.estimation.least_squares import solve
from identify.estimation.problem import Problem
from measure.tables.trajectory import Trajectory
from simulate.effects import HandrailContact
from simulate.model.model import Model


@pytest.fixture
def handrail(prototype: Model) -> Problem:
    """A film that has seen nothing move, with a stiffness of 500 N/m as the scale of its parameter."""
    time = np.arange(6) / 250.0
    height = prototype.geometry.stowed_height_m if prototype.geometry else 0.0
    film = Trajectory(time, {"z_m": np.full(6, height)}, {"z_m": np.full(6, 1e-5)})
    return problem_of(prototype, [Run(film, name="film")]).with_another(HandrailContact(0.001))


@pytest.mark.parametrize("strength", [4e-6, 4e-4, 0.5])
def test_a_fit_begins_where_it_is_told_to_however_small_a_strength_is(handrail: Problem, strength: float):
    """One that began a thousandth of a scale off every bound doubled weak effects and lost the local minimum in which they lay."""
    start = np.zeros(len(handrail.parameters))
    start[-1] = strength
    begun = solve(handrail, start, most_steps=1)
    assert begun.q == pytest.approx(start, abs=1e-12)
    again = solve(handrail, begun.q)
    assert again.cost <= begun.cost


def test_a_parameter_at_a_bound_begins_off_it(handrail: Problem):
    """There its rate of change is nought, and a trust region would not leave it."""
    start = np.zeros(len(handrail.parameters))
    assert handrail.parameters[-1].low == 0.0
    assert 0.0 < solve(handrail, start, most_steps=1).q[-1] <= 1e-3
    stiffest = handrail.effects[0].own_bounds(handrail.model, handrail.measures)["stiffness_N_per_m"][1]
    high = replace(handrail, effects=(replace(handrail.effects[0], stiffness_N_per_m=stiffest),))
    assert high.parameters[-1].high == 0.0
    assert -1e-3 <= solve(high, start, most_steps=1).q[-1] < 0.0
