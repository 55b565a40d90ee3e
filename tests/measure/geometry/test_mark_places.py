"""Rows of marks once the body is known, against the exact geometry of a drum that turns."""

from __future__ import annotations

import numpy as np

from measure.geometry.mark_places import places_on_body


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
