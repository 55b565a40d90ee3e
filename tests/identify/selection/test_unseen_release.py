"""What a film does not show of a release may be to either side of it: where errors of the model file are improbable, both are tried."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.criteria import UNUSUAL_P
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


def led_to(monkeypatch, across_p):
    """Let every way from afar end where what no film shows is so probable, and report where they begin: parameters and errors."""
    starts = []

    def beside(stand, q, sizes, _, **options):
        starts.append((q, sizes))
        return stand

    monkeypatch.setattr(weighing, "led_beside", beside)
    monkeypatch.setattr(Stand, "across_p", lambda stand, found: across_p)
    return starts


def test_where_what_no_film_shows_is_improbable_it_is_led_from_either_side_along_what_shows_most(loose, monkeypatch):
    starts = led_to(monkeypatch, 0.9 * UNUSUAL_P)
    weighing._from_afar(loose)
    unseen, odd = loose.given.unseen, loose.errors.odd_part(1, loose.given.model.geometry)
    assert len(starts) == 5  # from the model file, and two ways in two directions
    for q, _ in starts[1:]:
        assert not q[unseen].any()
        assert q[~unseen] == pytest.approx(loose.fit.q[~unseen])
    sizes = np.array([of for _, of in starts[1:]])
    assert sizes @ odd == pytest.approx(sizes)
    assert sizes @ sizes.T == pytest.approx(9.0 * np.array([[1, -1, 0, 0], [-1, 1, 0, 0], [0, 0, 1, -1], [0, 0, -1, 1]]), abs=1e-9)
    shown = np.linalg.norm(sizes @ loose.errors.columns.T, axis=1)
    assert shown[0] > shown[2] > 3.0 * np.median(np.linalg.norm(loose.errors.columns @ odd, axis=0))


def test_what_is_probable_is_not(loose, monkeypatch):
    starts = led_to(monkeypatch, 1.1 * UNUSUAL_P)
    weighing._from_afar(loose)
    assert len(starts) == 1


@pytest.mark.parametrize(("name", "place", "is_across"), [("centre-of-mass-offset", 1, True), ("platform-mass", 0, False)])
def test_what_is_far_off_is_across_only_if_a_mirror_turns_it_round(loose, name, place, is_across):
    found, own = loose.weighed(), loose.errors.keys.index((name, place))
    far = replace(found, errors=found.errors + 12.0 * (np.arange(len(found.errors)) == own))
    assert far.prior_p < UNUSUAL_P
    assert (loose.across_p(far) < 1e-3) == is_across
    assert loose.across_p(far) == pytest.approx(loose.across_p(found), rel=1e-6) or is_across


@pytest.mark.parametrize(("key", "is_across"), [("theta_x_rad", True), ("theta_y_rad", False)])
def test_a_release_that_is_far_off_is_across_only_as_far_as_no_film_shows_it(loose, key, is_across):
    found = loose.weighed()
    own = next(i for i, one in enumerate(loose.fit.problem.parameters) if one.key == key)
    far = replace(found, step=found.step + 12.0 * loose.fit.problem.parameters[own].spread * (np.arange(len(found.step)) == own))
    assert (loose.across_p(far) < 1e-3) == is_across


def test_films_that_tell_a_rig_from_its_image_leave_nothing_across(loose, monkeypatch):
    monkeypatch.setattr(type(loose.given), "mirrors", lambda problem: iter(()))
    assert loose.across_p(loose.weighed()) == 1.0
    assert list(weighing._off_to_sides(loose)) == []


def test_errors_and_a_release_that_are_far_off_are_improbable_alike(loose):
    found = loose.weighed()
    mass = loose.errors.names.index("platform-mass")
    tilt = next(i for i, one in enumerate(loose.fit.problem.parameters) if one.key == "theta_y_rad")
    far = [replace(found, errors=found.errors + 12.0 * (np.arange(len(found.errors)) == mass))]
    far.append(replace(found, step=found.step + 12.0 * (np.arange(len(found.step)) == tilt)))
    assert found.prior_p > UNUSUAL_P
    assert max(one.prior_p for one in far) < UNUSUAL_P
