"""Rows of marks once the body is known, against the exact geometry of a drum that turns."""

from __future__ import annotations

import numpy as np

from measure.geometry.body import body_points
from measure.geometry.mark_places import places_on_body
from measure.geometry.rigid_body import contradicted


def _off(marks, places_px):
    return np.stack([marks.x_px, marks.y_px], axis=-1) - places_px


def test_a_place_on_a_bent_mark_is_where_the_body_carries_its_reference_point(drum):
    """What a subset makes of its bending is in the sightings and not in the places."""
    drum = drum()
    noise = np.random.default_rng(7).normal(0.0, drum.sigma, (drum.frames, 6, 2))
    marks = drum.seen(noise)
    places = places_on_body(marks, drum.camera, drum.radius_m, drum.fit(marks))
    assert np.abs(_off(marks, drum.places_px)).max() > 10.0 * drum.sigma
    assert np.abs(_off(places, drum.places_px) - noise).max() < 0.1 * drum.sigma


def test_the_residuals_of_the_fit_are_those_of_the_places(drum):
    drum = drum()
    marks = drum.seen(np.random.default_rng(8).normal(0.0, drum.sigma, (drum.frames, 6, 2)))
    fit = drum.fit(marks)
    body = drum.carried_px(fit.pose)
    assert np.allclose(_off(places_on_body(marks, drum.camera, drum.radius_m, fit), body), fit.residual_px, atol=1e-9)


def test_a_frame_without_a_pose_keeps_its_sightings(drum):
    drum = drum()
    marks = drum.seen(np.zeros((drum.frames, 6, 2)))
    marks.status[20, 1:] = "lost"
    fit = drum.fit(marks)
    places = places_on_body(marks, drum.camera, drum.radius_m, fit)
    assert not fit.has_pose[20]
    assert places.x_px[20, 0] == marks.x_px[20, 0]
    assert places.x_px[21, 0] != marks.x_px[21, 0]


def _wrong(drum, error_px):
    marks = drum.seen(error_px)
    return contradicted(marks, drum.camera, body_points(marks, drum.camera, drum.radius_m), drum.fit(marks))


def test_a_sighting_at_another_pixel_is_contradicted_and_no_other(drum):
    drum = drum()
    error = np.random.default_rng(9).normal(0.0, drum.sigma, (drum.frames, 6, 2))
    error[20, 3] += [0.6, 0.5]
    assert np.argwhere(_wrong(drum, error)).tolist() == [[20, 3]]


def test_a_sighting_that_is_left_out_but_near_its_place_stays(drum):
    """Many standard deviations off, so that the pose does without it; as a place to a third of a pixel it still stands."""
    drum = drum()
    error = np.random.default_rng(9).normal(0.0, drum.sigma, (drum.frames, 6, 2))
    error[20, 3] += [0.25, 0.2]
    assert not drum.fit(drum.seen(error)).used[20, 3]
    assert not _wrong(drum, error).any()


def test_a_sighting_within_its_bar_is_not_contradicted_however_far(drum):
    """An uncertain mark may be a pixel off."""
    drum = drum(sigma=0.4)
    error = np.random.default_rng(9).normal(0.0, drum.sigma, (drum.frames, 6, 2))
    assert np.hypot(*error.reshape(-1, 2).T).max() > 1.0
    assert not _wrong(drum, error).any()
