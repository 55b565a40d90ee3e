"""Millimetres and the vertical, from things of known size in made pictures."""

from __future__ import annotations

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.geometry.film_project import make_project
from measure.geometry.rule_and_plumb_line import pitch_along, plumb_line
from measure.geometry.scale import camera_of, picture_scale

BLANK = np.full((60, 80), 100, np.uint8)


def _sized(**sections):
    found = picture_scale(make_project(sections), BLANK)
    assert found is not None
    return found


def test_two_points_half_a_pixel_unsure_give_a_scale_seven_thousandths_unsure():
    found = _sized(scale={"from_px_mm": (10, 10, 10, 110, 50.0)})
    assert found.mm_per_px == 0.5
    assert found.relative_sigma == pytest.approx(0.5 * np.sqrt(2) / 100)


def test_a_rule_behind_the_marks_is_seen_smaller_than_them():
    """Seen from 1 m, a pixel covers 2 % more on a rule 20 mm behind, and 5 mm of doubt are half a percent."""
    behind = {"from_px_mm": (10, 10, 10, 110, 51.0), "depth_mm": 20.0, "depth_sigma_mm": 5.0, "point_sigma_px": 0.0}
    found = _sized(scale=behind, camera={"distance_m": 1.0})
    assert found.mm_per_px == pytest.approx(0.5)
    assert found.relative_sigma == pytest.approx(5.0 / 1020.0)
    with pytest.raises(InputError, match="give distance_m"):
        _sized(scale=behind)


def test_a_calibrated_lens_and_a_distance_are_a_scale_and_a_lens_and_a_scale_a_distance():
    lens = {"focal_px": 2000.0, "focal_sigma_px": 4.0}
    found = _sized(camera={**lens, "distance_m": 1.5, "distance_sigma_m": 0.003})
    assert found.mm_per_px == pytest.approx(0.75)
    assert found.relative_sigma == pytest.approx(0.002 * np.sqrt(2))
    project = make_project({"camera": lens, "scale": {"mm_per_px": 0.75}})
    assert camera_of(project, _sized(scale={"mm_per_px": 0.75}), (40.0, 30.0), (80, 60)).distance_m == pytest.approx(1.5)


def _rule(pitch, slant, noise_seed):
    """Dark marks across a light rule, every fifth longer, slanted in the picture; soft edges, exact everywhere."""
    y, x = np.mgrid[:120, :420].astype(float)
    along, across = (x - 20) * np.cos(slant) + (y - 60) * np.sin(slant), -(x - 20) * np.sin(slant) + (y - 60) * np.cos(slant)
    grey = np.full(x.shape, 180.0)
    for n in range(int(400 / pitch) + 1):
        long = 30.0 if n % 5 == 0 else 15.0
        grey -= 110 * np.exp(-0.5 * ((along - n * pitch) / 1.1) ** 2) / (1 + np.exp((np.abs(across) - long) / 0.7))
    return np.rint(grey + np.random.default_rng(noise_seed).normal(0, 2.0, grey.shape)).clip(0, 255).astype(np.uint8)


def test_the_graduation_of_a_slanted_rule_gives_its_pitch_with_an_honest_sigma():
    ratios = []
    for n, pitch in enumerate((6.3137, 7.77, 9.1, 12.46)):
        slant = 0.03 * n
        line = (20.0, 60.0, 20.0 + 370 * np.cos(slant), 60.0 + 370 * np.sin(slant))
        found, sigma = pitch_along(_rule(pitch, slant, n), line)
        assert abs(found / pitch - 1.0) < 5e-4
        assert sigma / pitch < 5e-4
        ratios.append((found - pitch) / sigma)
    assert np.abs(ratios).max() < 4.0


def test_a_line_beside_the_rule_has_no_graduation():
    noise = np.random.default_rng(0).integers(90, 110, (120, 420)).astype(np.uint8)
    with pytest.raises(InputError, match="no graduation"):
        pitch_along(noise, (20.0, 60.0, 400.0, 60.0))
    with pytest.raises(InputError, match="reaches out of the picture"):
        pitch_along(noise, (20.0, 60.0, 500.0, 60.0))


def _hanging(lean, seed):
    """A dark line that leans by so many degrees, with noise."""
    y, x = np.mgrid[:300, :80].astype(float)
    off = (x - 40) * np.cos(np.radians(lean)) + (y - 150) * np.sin(np.radians(lean))
    return 150 - 90 * np.exp(-0.5 * (off / 0.8) ** 2) + np.random.default_rng(seed).normal(0, 2.0, x.shape)


def _up_of(grey):
    return plumb_line(np.rint(grey).clip(0, 255).astype(np.uint8), (41.0, 20.0, 39.0, 280.0))


@pytest.mark.parametrize("lean", [-2.3, 0.0, 1.7])
def test_a_plumb_line_shows_where_up_is_though_something_covers_a_part_of_it(lean):
    ratios = []
    for seed in range(4):
        grey = _hanging(lean, seed)
        grey[120:130] = 60.0
        up, sigma = _up_of(grey)
        assert abs(up - lean) < 0.05
        ratios.append((up - lean) / sigma)
    assert np.sqrt(np.mean(np.square(ratios))) < 2.5


def test_the_sigma_of_up_is_neither_too_small_nor_too_large():
    leans = np.random.default_rng(7).uniform(-3.0, 3.0, 50)
    ratios = [(up - lean) / sigma for seed, lean in enumerate(leans) for up, sigma in [_up_of(_hanging(lean, seed))]]
    assert 0.65 < np.sqrt(np.mean(np.square(ratios))) < 1.4


def test_where_nothing_hangs_there_is_no_plumb_line():
    noise = np.random.default_rng(0).integers(90, 110, (300, 80)).astype(np.uint8)
    with pytest.raises(InputError, match="no thin line"):
        plumb_line(noise, (40.0, 20.0, 40.0, 280.0))


def test_what_is_unsure_adds_up_in_squares():
    points = {"from_px_mm": (10, 10, 40, 50, 25.0), "point_sigma_px": 0.3, "length_sigma_mm": 0.1, "relative_sigma": 0.002}
    found = _sized(scale=points)
    assert found.mm_per_px == pytest.approx(0.5)
    assert found.relative_sigma == pytest.approx(np.sqrt(2 * (0.3 / 50) ** 2 + (0.1 / 25) ** 2 + 0.002**2))
    assert found.summary()["said"] == "from two points 50.0 px apart"


@pytest.mark.parametrize("depth_mm", [20.0, -30.0])
def test_a_depth_that_is_known_by_a_distance_that_is_not_leaves_its_part_of_that(depth_mm):
    camera = {"distance_m": 1.0, "distance_sigma_m": 0.05}
    found = _sized(scale={"mm_per_px": 0.5, "depth_mm": depth_mm, "depth_sigma_mm": 4.0}, camera=camera)
    assert found.mm_per_px == pytest.approx(0.5 * 1000.0 / (1000.0 + depth_mm))
    assert found.relative_sigma == pytest.approx(np.hypot(4.0, abs(depth_mm) * 0.05) / (1000.0 + depth_mm))


def test_a_rule_of_known_pitch_gives_the_scale_and_a_plumb_line_up():
    picture = _rule(9.1, 0.0, 3)
    project = make_project({"scale": {"rule_px_mm": (20.0, 60.0, 390.0, 60.0, 2.0), "relative_sigma": 0.001}})
    found = picture_scale(project, picture)
    assert found is not None
    assert found.mm_per_px == pytest.approx(2.0 / 9.1, rel=5e-4)
    assert found.relative_sigma == pytest.approx(0.001, rel=0.2)
    assert found.source.startswith("from a rule, 9.1")
    hung = make_project({"scale": {"mm_per_px": 0.5, "plumb_px": (41.0, 20.0, 39.0, 280.0)}})
    up = picture_scale(hung, np.rint(_hanging(1.7, 0)).clip(0, 255).astype(np.uint8))
    assert up is not None
    assert (up.up_deg, up.up_sigma_deg > 0.0) == (pytest.approx(1.7, abs=0.05), True)
    assert _sized(scale={"mm_per_px": 0.5, "up_deg": 3.0}).up_deg == 3.0
    assert picture_scale(make_project({}), BLANK) is None


def test_points_that_coincide_and_a_rule_behind_the_camera_are_refused():
    with pytest.raises(InputError, match=r"the points are 1\.41 px apart"):
        _sized(scale={"from_px_mm": (10, 10, 11, 11, 50.0)})
    assert _sized(scale={"from_px_mm": (10, 10, 12, 10, 1.0)}).mm_per_px == 0.5
    with pytest.raises(InputError, match="behind the camera, which is 1 m away"):
        _sized(scale={"mm_per_px": 0.5, "depth_mm": -1000.0}, camera={"distance_m": 1.0})


def _camera(**camera):
    return camera_of(make_project({"camera": camera}), _sized(scale={"mm_per_px": 0.5, "up_deg": 2.0}), (40.0, 30.0), (81, 61))


def test_a_camera_looks_at_the_middle_of_the_picture_unless_told_otherwise():
    plain = _camera()
    assert (plain.m_per_px, plain.origin_px, plain.up_rad) == (5e-4, (40.0, 30.0), pytest.approx(np.radians(2.0)))
    assert (plain.distance_m, plain.principal_px, plain.distortion) == (np.inf, None, ())
    near = _camera(distance_m=1.5)
    assert (near.distance_m, near.principal_px, near.focal_px) == (1.5, (40.0, 30.0), pytest.approx(3000.0))
    lens = _camera(focal_px=1000.0, principal_px=(33.0, 22.0), distortion=(0.1, 0.0, 0.0, 0.0))
    assert (lens.distance_m, lens.principal_px, lens.focal_px) == (pytest.approx(0.5), (33.0, 22.0), 1000.0)
    assert _camera(focal_px=1000.0, distance_m=2.0).distance_m == 2.0
    with pytest.raises(InputError, match="distortion needs the focal length"):
        _camera(distortion=(0.1, 0.0, 0.0, 0.0))
