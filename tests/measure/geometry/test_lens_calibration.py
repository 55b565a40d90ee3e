"""A lens from made pictures of a checkerboard, and what it does to places in the picture."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from measure.common.errors import InputError
from measure.footage.formats import open_footage
from measure.footage.writers import write_film
from measure.geometry.camera import Camera
from measure.geometry.lens_calibration import calibrate

FOCAL, AXIS, BENT = 700.0, (318.0, 244.0), (-0.18, 0.05, 0.001, -0.0006)
LENS = Camera(1e-3, (320.0, 240.0), 0.0, 0.7, AXIS, FOCAL, BENT)
SLANTS = ((0.0, 0.0), (0.4, 0.1), (-0.4, 0.2), (0.1, 0.45), (-0.2, -0.45), (0.35, -0.35))


def _board(slant, seed):
    """A board of 8 x 6 squares of 20 mm, 0.35 m away, its edges soft by half a pixel: every pixel asks where its ray meets the board."""
    y, x = np.mgrid[:480, :640].astype(float)
    ideal = LENS.without_distortion(np.stack([x, y], axis=-1))
    rays = np.concatenate([(ideal - AXIS) / FOCAL, np.ones((*x.shape, 1))], axis=-1)
    turn, _ = cv2.Rodrigues(np.array([*slant, 0.1 * slant[0]]))
    centre = np.array([0.0, 0.0, 0.35])
    place = rays * ((centre @ turn[:, 2]) / (rays @ turn[:, 2]))[..., None] - centre
    u, v = place @ turn[:, 0] / 0.02, place @ turn[:, 1] / 0.02
    edges = np.tanh(16 * np.sin(np.pi * u)) * np.tanh(16 * np.sin(np.pi * v))
    grey = np.where((np.abs(u) < 4) & (np.abs(v) < 3), 120.0 - 80.0 * edges, 200.0)
    return np.rint(grey + np.random.default_rng(seed).normal(0, 1.5, grey.shape)).clip(0, 255).astype(np.uint8)


def test_places_through_the_lens_are_those_of_opencv():
    points = np.random.default_rng(0).uniform([-0.25, -0.25, 0.45], [0.25, 0.25, 0.95], (30, 3))
    matrix = np.array([[FOCAL, 0, AXIS[0]], [0, FOCAL, AXIS[1]], [0, 0, 1]])
    theirs = np.asarray(cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, np.array(BENT))[0], float).reshape(-1, 2)
    ideal = np.array(AXIS) + FOCAL * points[:, :2] / points[:, 2:]
    assert np.allclose(LENS.with_distortion(ideal), theirs, atol=1e-9)
    assert np.allclose(LENS.without_distortion(theirs), ideal, atol=1e-6)


def test_projection_through_a_bent_lens_and_its_inverse_agree():
    points = np.random.default_rng(0).normal(0, 0.05, (20, 3))
    assert np.allclose(LENS.place(LENS.project(points), points[:, 1]), points, atol=1e-9)


def test_a_checkerboard_gives_the_lens_back(tmp_path):
    write_film(tmp_path / "board", (_board(slant, n) for n, slant in enumerate(SLANTS)))
    lens = calibrate(open_footage(tmp_path / "board"), 7, 5, 20.0)
    assert lens.views >= 5
    assert abs(lens.focal_px - FOCAL) < max(4 * lens.focal_sigma_px, 0.5)
    assert lens.focal_sigma_px < 3.0
    found = Camera(1e-3, (320.0, 240.0), 0.0, 0.7, lens.principal_px, lens.focal_px, lens.distortion)
    y, x = np.mgrid[150:350:50, 200:450:50].astype(float)
    places = np.stack([x, y], axis=-1)
    bends = [(c.without_distortion(places) - np.array(c.principal_px)) / c.focal_px * FOCAL for c in (LENS, found)]
    gap = bends[0] - bends[1]
    assert np.abs(gap - gap.mean(axis=(0, 1))).max() < 0.3


def test_a_folder_without_a_board_is_no_calibration(tmp_path):
    write_film(tmp_path / "board", [np.full((100, 120), 90, np.uint8)] * 6)
    with pytest.raises(InputError, match="found in 0 of 6"):
        calibrate(open_footage(tmp_path / "board"), 7, 5, 20.0)
