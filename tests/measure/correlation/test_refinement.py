"""Sub-pixel refinement against pictures whose shift is known exactly."""

from __future__ import annotations

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.correlation.reference_image import reference
from measure.correlation.refinement import Expected, Match, recognise, refine, surface_near
from measure.correlation.spline import FILTER, coefficients
from measure.correlation.steepest_descent import AFFINE, EUCLIDEAN, TRANSLATION
from measure.correlation.template_matching import correlation_map, search

CENTRE, SUBSET = 36, 41


def _refined(picture, mark, guess=None, scale=None) -> Match:
    start = mark.start if guess is None else guess
    near = surface_near(picture, mark.half, start)
    assert near is not None
    found = refine(near, mark, start, scale)
    assert found is not None
    return found


def _shifts(speckled, shift, warp, repeats, **made):
    """Errors (n, 2) of the refined position, and the same over their stated sigma."""
    errors, ratios = [], []
    for n in range(repeats):
        mark = reference(speckled(seed=n, noise_seed=2 * n, **made), CENTRE, CENTRE, SUBSET, warp)
        found = _refined(speckled(shift, seed=n, noise_seed=2 * n + 1, **made), mark)
        errors.append(mark.point(found.warp) - CENTRE - shift)
        ratios.append(errors[-1] / np.sqrt(np.diag(found.covariance)))
    return np.array(errors), np.array(ratios)


@pytest.mark.parametrize("warp", [TRANSLATION, AFFINE])
@pytest.mark.parametrize("grain", [1.0, 1.6])
def test_known_shifts_come_back_without_bias_and_with_an_honest_sigma(speckled, warp, grain):
    errors, ratios = zip(*(_shifts(speckled, (s, 0.3), warp, 8, grain=grain) for s in (0.0, 0.25, 0.5)), strict=True)
    assert np.abs(np.mean(errors, axis=1)).max() < 0.004
    assert np.sqrt(np.mean(np.square(errors))) < 0.0075
    assert 0.88 < np.mean(np.abs(ratios) < 1.96) <= 1.0
    assert 0.8 < np.std(ratios) < 1.25


def test_light_that_changes_by_a_third_changes_nothing(speckled):
    mark = reference(speckled(), CENTRE, CENTRE, SUBSET)
    bright = speckled((0.4, 0.2), noise_seed=1).astype(float)
    places = [mark.point(_refined(np.rint(g * bright + o).clip(0, 255).astype(np.uint8), mark).warp) for g, o in ((1, 0), (0.7, 20))]
    assert np.abs(places[0] - places[1]).max() < 0.01


def test_light_that_changes_across_the_mark_is_told_from_motion(speckled):
    mark = reference(speckled(), CENTRE, CENTRE, SUBSET)
    x = np.arange(72) - CENTRE
    current = np.rint(speckled((0.4, 0.2), noise_seed=1) * (1.0 + 0.3 * x / SUBSET)).clip(0, 255).astype(np.uint8)
    found = recognise(current, mark, mark.start, Expected(0.7, 0.001))
    assert found is not None
    assert np.abs(mark.point(found.warp) - CENTRE - [0.4, 0.2]).max() < 0.02
    assert np.abs(mark.point(_refined(current, mark).warp) - CENTRE - [0.4, 0.2]).max() > 0.03


def test_a_turned_mark_needs_a_warp_that_turns(speckled):
    turn = np.radians(8.0)
    mark = reference(speckled(), CENTRE, CENTRE, 31, EUCLIDEAN)
    guess = mark.start
    guess[[0, 1, 3, 4]] = np.cos(turn - 0.03), -np.sin(turn - 0.03), np.sin(turn - 0.03), np.cos(turn - 0.03)
    found = _refined(speckled((0.3, -0.2), turn=turn, noise_seed=1), mark, guess)
    assert np.abs(mark.point(found.warp) - CENTRE - [0.3, -0.2]).max() < 0.02
    assert abs(np.arctan2(found.warp[3], found.warp[0]) - turn) < 1e-3


def test_a_rod_in_front_hardly_moves_a_robustly_refined_mark(speckled):
    mark = reference(speckled(), CENTRE, CENTRE, SUBSET)
    current = speckled((0.4, 0.3), noise_seed=1)
    current[:, 40:46] = 30
    plain, robust = _refined(current, mark), _refined(current, mark, scale=1.0)
    assert np.abs(mark.point(robust.warp) - CENTRE - [0.4, 0.3]).max() < 0.03
    assert np.abs(mark.point(plain.warp) - CENTRE - [0.4, 0.3]).max() > 0.03
    assert 0.1 < robust.hidden < 0.3


def test_what_the_mask_leaves_out_moves_nothing(speckled):
    """A round mark on a background that stays behind: the whole square errs, its disc does not."""
    y, x = np.mgrid[:72, :72] - CENTRE
    errors = {}
    for name, mask in (("disc", np.hypot(x, y) < 14), ("square", None)):
        pictures = []
        for n, shift in enumerate(((0.0, 0.0), (0.6, 0.4))):
            moved = np.hypot(x - shift[0], y - shift[1]) < 17
            pictures.append(np.where(moved, speckled(shift, seed=1, noise_seed=n), speckled(seed=8, noise_seed=n + 5)).astype(np.uint8))
        mark = reference(pictures[0], CENTRE, CENTRE, SUBSET, mask=mask)
        errors[name] = np.abs(mark.point(_refined(pictures[1], mark).warp) - CENTRE - [0.6, 0.4]).max()
    assert errors["disc"] < 0.02
    assert errors["square"] > 0.05


def test_what_the_mask_leaves_out_is_not_searched_for(speckled):
    """A small round mark moved far over a background that stays: with its square it is taken to be where the background is."""
    y, x = np.mgrid[:72, :72] - CENTRE
    disc, shift = np.hypot(x, y) < 6, (9.0, -7.0)
    before = np.where(disc, speckled(seed=1), speckled(seed=8, noise_seed=5)).astype(np.uint8)
    moved = np.hypot(x - shift[0], y - shift[1]) < 6
    after = np.where(moved, speckled(shift, seed=1, noise_seed=1), speckled(seed=8, noise_seed=6)).astype(np.uint8)
    square = slice(CENTRE - 15, CENTRE + 16), slice(CENTRE - 15, CENTRE + 16)
    masked, whole = (search(after, before[square], CENTRE, CENTRE, None, mask) for mask in (disc[square], None))
    assert masked is not None
    assert whole is not None
    assert (masked.x - CENTRE, masked.y - CENTRE) == shift
    assert masked.zncc > 0.9
    assert (whole.x - CENTRE, whole.y - CENTRE) == (0, 0)


def test_under_a_mask_the_correlation_is_numpys_and_a_flat_place_has_none(speckled):
    picture = speckled().astype(np.float32)
    picture[:, 50:] = 90.0
    mask = np.hypot(*(np.mgrid[:15, :15] - 7)) < 6
    patch = picture[20:35, 22:37]
    scores = correlation_map(picture, patch, mask)
    for row, column in ((20, 22), (3, 11), (40, 30)):
        under = picture[row : row + 15, column : column + 15][mask]
        assert scores[row, column] == pytest.approx(np.corrcoef(under, patch[mask])[0, 1], abs=1e-4)
    assert np.all(scores[:, 52:] == -1.0)


def test_a_mask_that_leaves_nothing_is_refused(speckled):
    with pytest.raises(InputError, match="leaves 0 pixels"):
        reference(speckled(), CENTRE, CENTRE, SUBSET, mask=np.zeros((72, 72), bool))


def test_a_round_dot_cannot_tell_its_rotation():
    y, x = np.mgrid[:72, :72]
    dot = np.rint(60 + 130 / (1 + np.exp((np.hypot(x - 36, y - 36) - 12) / 0.7))).astype(np.uint8)
    assert reference(dot, 36, 36, 41, EUCLIDEAN).warp == TRANSLATION
    assert reference(dot, 36, 36, 41).basis.shape == (6, 5)


def test_crossed_edges_fix_their_directions_and_not_the_stretches_along_them(speckled):
    y, x = np.mgrid[:72, :72] - 36.3
    quadrant = np.rint(60 + 65 * (1 + np.tanh(x / 0.8) * np.tanh(y / 0.8))).astype(np.uint8)
    basis = reference(quadrant, 36.3, 36.3, 41).basis
    assert basis.shape == (6, 4)
    assert np.abs(basis[[2, 5], 2:]).max() < 0.1 * np.abs(basis[3:5, 2:]).max()
    assert reference(speckled(), CENTRE, CENTRE, SUBSET).basis.shape == (6, 6)


def test_a_dot_in_noise_that_turns_with_its_plate_is_neither_lost_nor_moved():
    """Its rotation is not fixed by its texture, so that nothing may make the warp wander along it."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[:90, :90] - 45.0
    film = []
    for n in range(14):
        r = np.hypot(x - 0.61 * n + 4.0, y - 0.23 * n)
        film.append(np.rint(170 - 140 / (1 + np.exp((r - 9) / 0.5)) + rng.normal(0.0, 1.5, r.shape)).clip(0, 255).astype(np.uint8))
    mark = reference(film[0], 41.0, 45.0, 25)
    guess = mark.start
    for n, picture in enumerate(film):
        near = surface_near(picture, mark.half, guess)
        assert near is not None
        match = refine(near, mark, guess)
        assert match is not None
        guess = match.warp
        assert np.abs(mark.point(match.warp) - [41.0 + 0.61 * n, 45.0 + 0.23 * n]).max() < 0.06
        assert np.abs(match.warp[[0, 1, 3, 4]] - [1.0, 0.0, 0.0, 1.0]).max() < 0.02


def test_a_mark_on_bare_metal_is_refused(speckled):
    with pytest.raises(InputError, match="too little texture"):
        reference(np.full((72, 72), 90, np.uint8), CENTRE, CENTRE, SUBSET)
    edge = np.repeat(np.where(np.arange(72) < 36, 50, 200)[None], 72, axis=0).astype(np.uint8)
    with pytest.raises(InputError, match="edges in two directions"):
        reference(edge, CENTRE, CENTRE, SUBSET)


def test_a_subset_over_the_border_is_refused(speckled):
    with pytest.raises(InputError, match="reaches over the border"):
        reference(speckled(), 5, CENTRE, SUBSET)


def _match(noise, zncc, hidden=0.0, uneven_light=False):
    return Match(np.zeros(6), np.eye(2), zncc, 1.0, noise, hidden, True, 0.0, uneven_light)


def test_what_to_expect_is_a_running_mean_over_frames_that_nothing_covers():
    """Three tenths of the first one that counts, then a tenth of each; the first frame of all is the reference itself."""
    expected = Expected().updated(_match(9.0, 0.5), first=True)
    assert (expected.noise, expected.unexplained) == (0.0, 0.0)
    expected = expected.updated(_match(2.0, 0.8), first=False)
    assert (expected.noise, expected.unexplained) == (pytest.approx(0.6), pytest.approx(0.3 * 0.36))
    again = expected.updated(_match(1.6, 0.8, uneven_light=True), first=False)
    assert (again.noise, again.unexplained) == (pytest.approx(0.7), pytest.approx(0.108 + 0.1 * (0.36 - 0.108)))
    covered = again.updated(_match(50.0, 0.1, hidden=0.2), first=False)
    assert (covered.noise, covered.unexplained, covered.hidden, covered.uneven_light) == (again.noise, again.unexplained, 0.2, True)
    assert covered.updated(_match(0.7, 0.8), first=False).hidden == 0.0
    assert covered.updated(_match(0.7, 0.8), first=False).uneven_light
    assert (covered.after(True).lost, covered.after(True).hidden) == (True, 0.2)


@pytest.mark.parametrize(("place", "inside"), [((15.0, 30.0), True), ((14.2, 30.0), True), ((13.9, 30.0), False), ((30.0, 13.9), False)])
def test_a_subset_may_reach_less_than_a_pixel_over_the_border(place, inside):
    """On the left, and mirrored on the right; above, and below."""
    picture = np.zeros((72, 80), np.uint8)
    for x, y in (place, (79.0 - place[0], 71.0 - place[1])):
        warp = np.array([1.0, 0.0, x, 0.0, 1.0, y])
        assert (surface_near(picture, 15, warp) is not None) == inside


@pytest.mark.parametrize("matrix", [(1.0, 0.0, 0.0, 1.0), (1.2, 0.0, 0.0, 0.7), (0.8, -0.5, 0.5, 0.8)])
def test_the_part_that_is_prepared_holds_the_subset_as_it_is_stretched_and_turned_with_some_to_spare(speckled, matrix):
    picture = speckled(size=140)
    warp = np.array([matrix[0], matrix[1], 70.4, matrix[2], matrix[3], 66.7])
    near = surface_near(picture, 15, warp)
    assert near is not None
    rows, columns = near.surface.shape
    corners = np.array([[sx, sy] for sx in (-15.0, 15.0) for sy in (-15.0, 15.0)]) @ warp.reshape(2, 3)[:, :2].T + [70.4, 66.7]
    for axis, (first, count) in enumerate(((near.left, columns), (near.top, rows))):
        assert 6.0 <= corners[:, axis].min() - first < 8.0
        assert 6.0 <= first + count - 1 - corners[:, axis].max() < 8.0
    whole = coefficients(picture, 0, 0, 140, 140, FILTER)
    assert near.surface == pytest.approx(whole[near.top : near.top + rows, near.left : near.left + columns], abs=1e-3)


def test_a_mark_that_is_far_off_or_another_picture_is_not_recognised(speckled):
    mark = reference(speckled(), CENTRE, CENTRE, 31)
    assert recognise(speckled((0.5, 0.2), noise_seed=1), mark, mark.start, Expected(0.7, 0.002)) is not None
    assert recognise(speckled(seed=5), mark, mark.start, Expected(0.7, 0.002)) is None
    outside = mark.start
    outside[2] = 3.0
    assert recognise(speckled(), mark, outside, Expected()) is None


@pytest.mark.parametrize(("gain", "found"), [(0.55, True), (0.45, False), (1.4, True)])
def test_a_mark_that_was_lost_must_be_lit_about_as_it_was(speckled, gain, found):
    """A part of it is covered, so that it is looked at under robust weights."""
    mark = reference(speckled(), CENTRE, CENTRE, 41)
    current = np.rint(gain * (speckled((0.3, 0.1), noise_seed=1).astype(float) - 100.0) + 100.0).clip(0, 255)
    current[:, 40:44] = 10.0
    seen = recognise(current.astype(np.uint8), mark, mark.start, Expected(0.7, 0.002).after(True))
    assert (seen is not None) == found
    assert recognise(current.astype(np.uint8), mark, mark.start, Expected(0.7, 0.002)) is not None
