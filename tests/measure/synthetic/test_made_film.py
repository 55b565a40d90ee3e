"""Made films: what they show is what they say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.footage.formats import open_footage
from measure.geometry.film_project import project_text, read_project
from measure.synthetic.made_film import (
    MadeMark,
    Rod,
    pictures,
    project_for,
    render,
    true_motion,
)


def _one(motion, scene, **more):
    return next(iter(pictures(motion, scene, fps=100.0, seed=1, frames=1, **more)))


def test_a_dot_is_where_the_truth_says(rig):
    motion, scene = rig()
    scene = replace(scene, marks=(MadeMark(0.0, 0.0, 0.017, "dot"),), noise=0.0, rays=8, background=0.0)
    at = true_motion(motion, scene, 100.0)
    picture = _one(motion, scene).astype(float)
    x, y = round(at.x_px[0, 0]), round(at.y_px[0, 0])
    dark = picture.max() - picture[y - 14 : y + 15, x - 14 : x + 15]
    dark[dark < 0.5 * dark.max()] = 0.0
    rows, columns = np.mgrid[y - 14 : y + 15, x - 14 : x + 15]
    assert abs((dark * columns).sum() / dark.sum() - at.x_px[0, 0]) < 0.03
    assert abs((dark * rows).sum() / dark.sum() - at.y_px[0, 0]) < 0.03


def test_same_seed_same_pictures_and_another_seed_other_noise(rig):
    motion, scene = rig()
    first, again = _one(motion, scene), _one(motion, scene)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, next(iter(pictures(motion, scene, fps=100.0, seed=2, frames=1))))


def test_deeper_pictures_show_the_same_in_finer_steps(rig):
    motion, scene = rig(noise=0.0)
    eight, twelve = _one(motion, scene), _one(motion, replace(scene, bits=12))
    assert twelve.dtype == np.uint16
    assert twelve.max() < 4096
    assert np.abs(twelve / 16.0 - eight).max() <= 0.5 + 1 / 32


def test_a_rod_hides_what_is_behind_it(rig):
    motion, scene = rig(noise=0.0)
    rod = Rod(128.0, 0.0, 128.0, 255.0, 5.0, grey=0.1)
    with_rod = _one(motion, replace(scene, rods=(rod,))).astype(float)
    assert np.allclose(with_rod[10:240, 126:131], 0.1 * 255, atol=1)


def test_the_film_on_disk_is_the_film_that_was_made(rig, tmp_path):
    motion, scene = rig(seconds=0.04)
    truth = render(motion, scene, tmp_path / "film.avi", fps=100.0, seed=1)
    frames = [picture for _, picture in open_footage(tmp_path / "film.avi").pictures()]
    assert len(frames) == len(truth.trajectory.time_s) == 5
    assert np.array_equal(frames, list(pictures(motion, scene, fps=100.0, seed=1)))


def test_a_made_camera_film_carries_its_own_clock_and_depth(rig, tmp_path):
    motion, scene = rig(seconds=0.04, bits=12, exposure_s=0.001)
    render(motion, scene, tmp_path / "film.mraw", fps=100.0, seed=1)
    film = open_footage(tmp_path / "film.mraw")
    assert (film.fps, film.exposure_s, film.bits, film.frames, film.remarks) == (100.0, 0.001, 12, 5, ())
    assert np.array_equal([picture for _, picture in film.pictures()], list(pictures(motion, scene, fps=100.0, seed=1)))


def test_its_project_file_survives_writing_and_reading(rig, tmp_path):
    _, scene = rig()
    project = project_for(scene, 100.0, 0.252)
    (tmp_path / "p.toml").write_text(project_text(project))
    assert read_project(tmp_path / "p.toml") == project


def test_a_film_has_eight_twelve_or_sixteen_bits(rig):
    motion, scene = rig(bits=10)
    with pytest.raises(InputError, match="8, 12 or 16"):
        _one(motion, scene)
