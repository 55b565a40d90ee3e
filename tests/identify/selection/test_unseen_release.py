"""What a film does not show of a release may be to either side of it: where errors of the model file are improbable, both are tried."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.criteria import UNUSUAL_P
from identify.selection import weighing
from identify.selection.evidence import Evidence
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


def led_to(monkeypatch, prior_p):
    """Let every way from afar end with law, releases and errors that are so probable, and report the starts."""
    starts = []

    def beside(stand, q, *_):
        starts.append(q)
        return stand

    monkeypatch.setattr(weighing, "led_beside", beside)
    monkeypatch.setattr(Evidence, "prior_p", property(lambda found: prior_p))
    return starts


def test_what_is_improbable_is_looked_for_from_each_release_turned_to_the_other_side(loose, monkeypatch):
    starts = led_to(monkeypatch, 0.9 * UNUSUAL_P)
    weighing._from_afar(loose)
    q = loose.fit.q
    assert len(starts) == 3
    for index, start in enumerate(starts[1:]):
        turned = loose.fit.problem.unseen_of_release(index)
        assert start[turned] == pytest.approx(-q[turned])
        assert np.delete(start, turned) == pytest.approx(np.delete(q, turned))


def test_what_is_probable_is_not(loose, monkeypatch):
    starts = led_to(monkeypatch, 1.1 * UNUSUAL_P)
    weighing._from_afar(loose)
    assert len(starts) == 1


def test_errors_and_a_release_that_are_far_off_are_improbable_alike(loose):
    found = loose.weighed()
    mass = loose.errors.names.index("platform-mass")
    tilt = next(i for i, one in enumerate(loose.fit.problem.parameters) if one.key == "theta_y_rad")
    far = [replace(found, errors=found.errors + 12.0 * (np.arange(len(found.errors)) == mass))]
    far.append(replace(found, step=found.step + 12.0 * (np.arange(len(found.step)) == tilt)))
    assert found.prior_p > UNUSUAL_P
    assert max(one.prior_p for one in far) < UNUSUAL_P
