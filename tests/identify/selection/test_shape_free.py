"""What an effect promises, its shape counted: an exponent shows once there is some of the effect."""

from __future__ import annotations

import pytest

from identify.estimation.least_squares import solve
from identify.selection.promises import posed, promises
from identify.selection.weighing import weighed
from simulate.effects import CATALOGUE, PowerLawFriction

NAME = "power-law-friction"


@pytest.fixture
def at(campaign, fitted):
    """Loops of a leg whose friction goes with speed to the power of 0.7, without that."""
    return weighed(fitted(campaign(PowerLawFriction(0.005, 0.7), 96, deployments=(), hold_out=False)))


def test_a_promise_moves_the_exponent_and_is_kept_by_the_fit(at):
    (promise,) = (one for one in promises(at, {NAME: CATALOGUE[NAME]}) if one.name == NAME)
    problem, start = posed(at, promise)
    shape = problem.effects_at(start)[0]
    assert isinstance(shape, PowerLawFriction)
    assert shape.exponent == pytest.approx(0.7, abs=0.1)
    assert promise.log_z == pytest.approx(weighed(solve(problem, start)).log_z, abs=4.0)


def test_an_effect_that_shows_whole_is_weighed_once(at, monkeypatch):
    monkeypatch.setattr("identify.selection.promises._with_shape_free", None)
    assert list(promises(at, {"viscous-friction": CATALOGUE["viscous-friction"]}))
