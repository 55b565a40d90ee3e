"""What a film does not show of a release may be to either side of it: where errors of the model file are improbable, both are tried."""

from __future__ import annotations

import numpy as np
import pytest

from identify.selection import weighing
from identify.selection.stand import Stand

SEEN = ("x_m", "z_m", "theta_y_rad")


@pytest.fixture
def loose(campaign, fitted):
    """A right model with two films that are filmed from one side."""
    runs = {"loops": (), "deployments": ({}, {"geometry.stowed_height_m": 0.30}), "hold_out": False, "channels": SEEN}
    return Stand.loose(fitted(campaign(None, 93, **runs)))


def of(problem, index):
    return {problem.parameters[i].key for i in problem.unseen_of_release(index)}


def test_what_lies_across_all_that_a_film_shows_is_unseen(loose):
    problem = loose.fit.problem
    assert of(problem, 0) == of(problem, 1) == {"position_y_m", "theta_x_rad", "theta_z_rad"}
    assert not set(problem.unseen_of_release(0)) & set(problem.unseen_of_release(1))


def led_to(monkeypatch, sizes):
    """Let every way from afar end with these errors, and report the starts."""
    starts = []

    def beside(stand, q, *_):
        starts.append(q)
        return weighing.replace(stand, sizes=np.full(len(stand.sizes), sizes))

    monkeypatch.setattr(weighing, "led_beside", beside)
    return starts


def test_improbable_errors_are_looked_for_from_each_release_turned_to_the_other_side(loose, monkeypatch):
    starts = led_to(monkeypatch, 2.0)
    weighing._from_afar(loose)
    q = loose.fit.q
    assert len(starts) == 3
    for index, start in enumerate(starts[1:]):
        turned = loose.fit.problem.unseen_of_release(index)
        assert start[turned] == pytest.approx(-q[turned])
        assert np.delete(start, turned) == pytest.approx(np.delete(q, turned))


def test_probable_errors_are_not(loose, monkeypatch):
    starts = led_to(monkeypatch, 1.0)
    weighing._from_afar(loose)
    assert len(starts) == 1
