"""Offsets that the error of the reference image gives to all later sightings, in sightings made from exact geometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from measure.geometry.body import Body, body_points
from measure.geometry.own_noise import own_noise
from measure.geometry.reference_error import ReferenceError, have_left, reference_error, share_left, without_reference_error
from measure.geometry.rigid_body import CYLINDER, fit_platform
from measure.tables.trajectory import CHANNELS

FRAMES, SCATTER = 60, 8.0
"""Every coordinate scatters by so many stated standard deviations, in the reference image too."""


def _body(drum, marks):
    return Body(drum.camera, body_points(marks, drum.camera, drum.radius_m), marks.response)


def _carried(drum, offset_px):
    """What offsets in the reference image, (6, 2), add to the sightings, (frames, 6, 2)."""
    marks = drum.seen(0.0)
    return np.einsum("tnij,nj->tni", _body(drum, marks).carried(drum.pose) * share_left(marks)[..., None, None], offset_px)


def _film(drum, seed, offset=None):
    """Sightings that scatter, and err by the reference image; drawn offsets unless they are given."""
    rng = np.random.default_rng([seed, 11])
    sigma = SCATTER * drum.sigma
    offset = rng.normal(0.0, sigma, (6, 2)) if offset is None else offset
    noise = rng.normal(0.0, sigma, (drum.frames, 6, 2))
    noise[0] = 0.0
    return drum.seen(noise + _carried(drum, offset))


def _mended(drum, marks, fit=None):
    return without_reference_error(marks, drum.camera, body_points(marks, drum.camera, drum.radius_m), fit or drum.fit(marks))


def _gaps(drum, fit):
    """Errors of the pose and their standard deviations, but in the first frame."""
    at = [CHANNELS.index(channel) for channel in fit.free]
    return (fit.pose - drum.pose)[1:, at], np.sqrt(np.diagonal(fit.covariance, axis1=1, axis2=2))[1:]


@pytest.mark.slow
def test_what_all_frames_err_alike_shrinks_and_bars_hold(drum):
    drum = drum(frames=FRAMES)
    before, after, inside = [], [], []
    for seed in range(4):
        marks = _film(drum, seed)
        first = drum.fit(marks)
        gap, sigma = _gaps(drum, _mended(drum, marks, first)[1])
        before.append((_gaps(drum, first)[0] / sigma)[drum.frames // 3 :].mean(axis=0))
        after.append((gap / sigma)[drum.frames // 3 :].mean(axis=0))
        inside.append(np.abs(gap) < 1.96 * sigma)
    assert np.mean(np.square(after)) < 0.6 * np.mean(np.square(before))
    assert 0.88 < np.mean(inside) < 0.98


def test_an_offset_that_no_motion_of_the_body_makes_is_found_and_taken_off(drum):
    """Of two marks in a column, one too far to the left and one too far to the right."""
    drum, offset = drum(frames=FRAMES), np.zeros((6, 2))
    offset[[0, 3], 0] = 0.15, -0.15
    marks = _film(drum, 1, offset)
    fit = drum.fit(marks)
    noise = own_noise(marks, fit, have_left(marks))
    assert noise is not None
    wide = noise.on(marks)
    found = reference_error(wide, drum.fit(wide), _body(drum, marks), noise.reference_px2)
    sigma = np.sqrt(np.diag(found.covariance_px2)).reshape(6, 2)
    assert found.offset_px[0, 0] - found.offset_px[3, 0] == pytest.approx(0.3, abs=0.12)
    assert (np.abs(found.offset_px - offset) < 3.0 * sigma).all()
    shift = _carried(drum, found.offset_px)
    assert found.taken_off(marks).x_px == pytest.approx(marks.x_px - shift[..., 0], abs=5e-3)


def test_an_offset_shrinks_as_its_mark_turns_away(drum):
    """On a drum that turns by 30 deg a mark at the side is seen from more aside, one at the other side less."""
    drum = drum(frames=FRAMES)
    carried = _body(drum, drum.seen(0.0)).carried(drum.pose)
    azimuth = np.arcsin(0.5e-3 * 76.0 / drum.radius_m)
    turned = np.cos(np.array([-azimuth, 0.0, azimuth]) + np.radians(30.0)) / np.cos([-azimuth, 0.0, azimuth])
    assert carried[0] == pytest.approx(np.broadcast_to(np.eye(2), (6, 2, 2)), abs=1e-6)
    assert carried[-1, :3, 0, 0] == pytest.approx(turned, rel=0.06)


def test_what_looks_like_a_pose_stays_in_the_bars(drum):
    """All marks are off alike: that is a shift of the platform, which nothing but the prior of the offsets can tell."""
    drum = drum(frames=FRAMES, turn_deg=2.0)
    marks = _film(drum, 3, np.tile([2.0 * SCATTER * drum.sigma, 0.0], (6, 1)))
    gap, sigma = _gaps(drum, _mended(drum, marks)[1])
    mean = 0.5e-3 * SCATTER * drum.sigma / np.sqrt(6.0)
    assert np.median(sigma[:, 0]) > 1.2 * mean
    assert np.abs(gap[-20:, 0]).mean() > 2.0 * mean


@pytest.mark.parametrize("scatter", [1.4, 8.0])
def test_a_wrong_geometry_is_not_taken_for_an_error_of_the_reference_image(drum, scatter):
    """The platform tilts towards the camera, which the fit does not know: theta_y errs by milliradians, and no more than before."""
    drum, before, after = drum(frames=FRAMES // 2), [], []
    for seed in range(2):
        noise = scatter * drum.sigma * np.random.default_rng([seed, 12]).normal(size=(drum.frames, 6, 2))
        marks = drum.seen(noise - noise[:1])
        points = body_points(marks, drum.camera, drum.radius_m)
        first = fit_platform(marks, drum.camera, points, CYLINDER)
        mended = without_reference_error(marks, drum.camera, points, first)[1]
        before.append(_gaps(drum, first)[0][:, 2])
        after.append(_gaps(drum, mended)[0][:, 2])
    assert np.sqrt(np.mean(np.square(before))) > 1e-3
    assert np.mean(np.square(after)) < 1.1 * np.mean(np.square(before))


def test_marks_as_good_as_they_say_are_left_as_they_are(drum):
    drum = drum(frames=FRAMES)
    noise = drum.sigma * np.random.default_rng(5).normal(size=(FRAMES, 6, 2))
    marks = drum.seen(noise - noise[:1])
    fit = drum.fit(marks)
    same, fitted = without_reference_error(marks, drum.camera, body_points(marks, drum.camera, drum.radius_m), fit)
    assert same is marks
    assert fitted is fit


def test_marks_at_their_first_places_show_no_offset(drum):
    """Nothing moves, so that all frames err as the reference image does: nothing is taken off, and nothing is added to the bars."""
    drum = replace(drum(frames=FRAMES, turn_deg=0.0), sigma=0.01)
    still = drum.places_px[:1] - drum.places_px
    noise = SCATTER * drum.sigma * np.random.default_rng(6).normal(size=(FRAMES, 6, 2)) * 0.3
    marks = drum.seen(still + noise)
    assert not have_left(marks).any()
    shift = reference_error(marks, drum.fit(marks), _body(drum, marks), np.full((6, 2), 0.01))
    assert np.abs(np.linalg.norm(shift.carried, axis=(2, 3))).max() < 0.5
    assert shift.offset_px == pytest.approx(0.0, abs=0.05)


def test_a_mark_that_is_lost_has_no_part_in_it(drum):
    drum = drum(frames=FRAMES)
    gone = np.zeros((FRAMES, 6), bool)
    gone[20:, 4] = True
    marks = _film(drum, 4).without(gone, "lost")
    mended, fit = _mended(drum, marks)
    assert np.isnan(mended.x_px[20:, 4]).all()
    assert fit.has_pose.all()
    gap, sigma = _gaps(drum, fit)
    assert np.isfinite(sigma).all()
    assert np.mean(np.abs(gap) < 1.96 * sigma) > 0.8


def test_errors_that_the_reference_image_does_not_share_count_as_kept_from_frame_to_frame(drum):
    """As in compressed films: nothing of the frames' scatter is in the reference image, so that the bars of the sightings grow by it."""
    drum = drum(frames=FRAMES)
    marks = _film(drum, 2, np.zeros((6, 2)))
    fit = drum.fit(marks)
    noise = own_noise(marks, fit, have_left(marks))
    assert noise is not None
    wide = noise.on(marks)
    found = reference_error(wide, drum.fit(wide), _body(drum, marks), noise.reference_px2)
    assert 0.2 < found.kept <= 1.0
    assert noise.slow(1.0).variance == pytest.approx(2.0 * noise.variance - 1.0)
    assert noise.slow(0.0).variance == pytest.approx(noise.variance)
    mended = _mended(drum, marks, fit)[0]
    least = (noise.slow(found.kept).on(marks)).covariance_px2
    assert (np.diagonal(mended.covariance_px2 - least, axis1=2, axis2=3)[1:] > -1e-12).all()


def test_a_pose_is_as_uncertain_as_an_offset_of_one_standard_deviation_moves_it(drum):
    """Offsets of all marks together, known to 0.02 px: the pose is fitted to marks that are shifted by these."""
    drum, together = drum(frames=FRAMES), np.tile([0.02, 0.01], 6)
    marks = drum.seen(0.0)
    fit = drum.fit(marks)
    carried = _body(drum, marks).carried(drum.pose)
    error = ReferenceError(carried, np.zeros((6, 2)), np.outer(together, together), 0.0)
    shift = np.einsum("tnij,nj->tni", carried, together.reshape(6, 2))
    moved = (drum.fit(drum.seen(shift)).pose - fit.pose)[:, [CHANNELS.index(channel) for channel in fit.free]]
    added = error.on_fit(fit, marks).covariance - fit.covariance
    assert np.sqrt(np.diagonal(added, axis1=1, axis2=2)) == pytest.approx(np.abs(moved), rel=0.02, abs=1e-8)
