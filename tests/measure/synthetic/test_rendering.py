"""What a made picture shows, against points of the drum sent through the camera one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from measure.geometry.camera import Camera, rotation
from measure.synthetic.made_film import MadeMark, Scene, pictures, true_motion
from measure.synthetic.rods import rod_cover
from measure.synthetic.scene import Rod
from measure.tables.trajectory import CHANNELS, Trajectory

RADIUS, HALF_HEIGHT = 0.032, 0.026
MARKS = (
    MadeMark(-0.45, 0.011, 0.022, "quadrant"),
    MadeMark(0.45, 0.008, 0.022, "dot"),
    MadeMark(0.0, -0.014, 0.016, "speckle", 0.002),
    MadeMark(np.pi, 0.0, 0.02, "dot"),
)
CAMERA = Camera(0.5e-3, (75.0, 90.0), 0.12, 0.8, (110.0, 120.0))
SCENE = Scene(160, 180, CAMERA, MARKS, RADIUS, HALF_HEIGHT, noise=0.0, bits=16, background=0.2, body=0.6)
POSE = np.array([0.004, -0.012, 0.003, 0.08, -0.11, 0.5])
EYE = np.array([0.0, -CAMERA.distance_m, 0.0])


def held(pose, **changed):
    """A film of a body that stays where it is, from a first sample at zero that is not shown."""
    time = np.arange(2) / 100.0
    motion = {channel: np.full(2, value) for channel, value in zip(CHANNELS, pose, strict=True)}
    for channel in CHANNELS[:3]:
        motion[channel][0] = 0.0
    shown = Trajectory(time, motion)
    film = pictures(shown, replace(SCENE, **changed), fps=100.0, seed=4)
    return list(film)[1] / (255.0 * 256.0)


def albedo_of(mark, u, v):
    """Of a quadrant or dot at (u, v) from its centre, and whether that is clear of an edge by 1.2 mm."""
    half, margin = mark.size_m / 2, 1.2e-3
    inside = half - max(abs(u), abs(v)) > margin
    if mark.kind == "quadrant":
        return (0.85 if u * v > 0 else 0.12), inside and min(abs(u), abs(v)) > margin
    beyond = np.hypot(u, v) - 0.7 * half
    return (0.12 if beyond < 0 else 0.85), inside and abs(beyond) > margin


def from_centre(mark, psi, z):
    return RADIUS * ((psi - mark.azimuth_rad + np.pi) % (2 * np.pi) - np.pi), z - mark.height_m


def seen_at(psi, z, pose):
    """Pixels of points of the wall, (n, 2), the outward normals there and the cosines to the line of sight."""
    turn, normal = rotation(pose[3:]), np.stack([np.sin(psi), -np.cos(psi), np.zeros(len(psi))], axis=-1)
    world = (RADIUS * normal + np.outer(z, [0.0, 0.0, 1.0])) @ turn.T + pose[:3]
    s, c = np.sin(CAMERA.up_rad), np.cos(CAMERA.up_rad)
    off = (np.array(CAMERA.origin_px) - CAMERA.principal_px) * CAMERA.m_per_px
    sight = EYE - [off @ [c, s], 0.0, off @ [s, -c]] - world
    outward = normal @ turn.T
    return np.rint(CAMERA.project(world)).astype(int), outward, np.sum(outward * sight, axis=1) / np.linalg.norm(sight, axis=1)


def wall(around, along):
    return tuple(grid.ravel() for grid in np.meshgrid(np.linspace(-np.pi, np.pi, around), HALF_HEIGHT * np.linspace(-1, 1, along)))


@pytest.mark.parametrize("pose", [np.zeros(6), POSE, POSE * [1, 1, 1, -1, 1, -1.3]])
def test_every_point_of_the_drum_is_seen_where_the_camera_puts_it(pose):
    picture, (psi, z) = held(pose), wall(90, 31)
    pixels, outward, facing = seen_at(psi, z, pose)
    kinds = set()
    for k in np.flatnonzero((facing > 0.4) & (np.abs(z) < 0.95 * HALF_HEIGHT)):
        places = {mark.kind: (mark, *from_centre(mark, psi[k], z[k])) for mark in MARKS[:3]}
        near = [kind for kind, (mark, u, v) in places.items() if max(abs(u), abs(v)) < mark.size_m / 2 + 1.2e-3]
        albedo, clear = (0.6, True) if not near else albedo_of(*places[near[0]])
        if clear and len(near) < 2 and "speckle" not in near:
            kinds.add(albedo)
            assert picture[pixels[k, 1], pixels[k, 0]] == pytest.approx(albedo * (0.75 - 0.25 * outward[k, 1]), abs=0.012)
    assert kinds == {0.6, 0.12, 0.85}


@pytest.mark.parametrize("shift", [(0.0, 0.0), (-0.04, 0.04), (0.05, -0.05)])
def test_the_outline_of_the_drum_is_that_of_its_wall_also_over_the_border(shift):
    pose = POSE + np.array([shift[0], 0.0, shift[1], 0.0, 0.0, 0.0])
    psi, z = wall(500, 200)
    pixels, _, facing = seen_at(psi, z, pose)
    covered = np.zeros((180, 160), bool)
    x, y = pixels[(facing > 0.0) & (pixels >= 0).all(axis=1) & (pixels < [160, 180]).all(axis=1)].T
    covered[y, x] = True
    shown = np.abs(held(pose, marks=()) - 0.2) > 0.1
    assert covered.sum() > 1000
    assert (shown != covered).sum() < 0.05 * covered.sum()


def test_marks_are_where_the_truth_says_and_face_the_camera_or_not():
    time = np.arange(3) / 100.0
    theta = np.array([0.0, 0.4, 0.9])
    motion = Trajectory(time, {"z_m": 0.252 + np.array([0.0, 0.01, 0.03]), "x_m": np.array([0.1, 0.11, 0.09]), "theta_z_rad": 0.3 + theta})
    truth = true_motion(motion, SCENE, 100.0)
    assert truth.trajectory.channels["z_m"] == pytest.approx(0.252 + np.array([0.0, 0.01, 0.03]))
    assert truth.trajectory.channels["x_m"] == pytest.approx([0.0, 0.01, -0.01])
    assert truth.trajectory.channels["theta_z_rad"] == pytest.approx(theta)
    for k, mark in enumerate(MARKS):
        psi = mark.azimuth_rad + 0.3 + theta
        world = np.stack(
            [RADIUS * np.sin(psi) + [0.0, 0.01, -0.01], -RADIUS * np.cos(psi), mark.height_m + np.array([0.0, 0.01, 0.03])], axis=-1
        )
        assert np.column_stack([truth.x_px[:, k], truth.y_px[:, k]]) == pytest.approx(CAMERA.project(world), abs=1e-6)
        assert truth.facing[:, k] == pytest.approx(np.cos(psi))


def test_speckles_darken_a_mark_by_bumps_of_their_radius_and_leave_no_part_of_it_empty():
    speckled = Scene(100, 100, Camera(0.2e-3, (50.0, 50.0)), (MadeMark(0.0, 0.0, 0.018, "speckle", 0.0009),), 1.0, 0.03, noise=0.0, bits=16)
    still = Trajectory(np.arange(2) / 100.0, {"z_m": np.zeros(2)})
    mark = next(iter(pictures(still, speckled, fps=100.0, seed=1)))[8:92, 8:92] / (255.0 * 256.0)
    assert 0.12 - 0.01 < mark.min() < 0.16
    assert 0.75 < mark.max() < 0.86
    assert 0.2 < np.mean(mark < 0.48) < 0.6
    for part in mark.reshape(4, 21, 4, 21).swapaxes(1, 2).reshape(16, -1):
        assert part.max() - part.min() > 0.3


def film(scene, motion, **options):
    return [picture / 256.0 for picture in pictures(motion, scene, fps=100.0, seed=4, **options)]


EDGED = replace(SCENE, rays=2, marks=MARKS[:2])
MOVING = Trajectory(np.arange(11) / 100.0, {"x_m": 0.4 * np.arange(11) / 100.0, "z_m": 0.3 * (np.arange(11) / 100.0) ** 2})


def at_instant(t):
    return 255.0 * held(np.array([0.4 * t, 0.0, 0.3 * t * t, 0.0, 0.0, 0.0]), rays=2, marks=MARKS[:2])


def test_an_exposure_is_the_mean_of_the_instants_within_it():
    exposed = film(replace(EDGED, exposure_s=0.01), MOVING, frames=2)[1]
    assert exposed == pytest.approx(np.mean([at_instant(0.01 + part) for part in (-4e-3, -2e-3, 0.0, 2e-3, 4e-3)], axis=0), abs=0.02)


def test_each_band_of_rows_is_read_at_its_own_instant():
    """The first row half of the readout early, the last one late, the middle one in time."""
    rolled = film(replace(EDGED, readout_s=0.04), MOVING, frames=3)[2]
    for top in (0, 64, 88, 104, 176):
        band = slice(top, top + 4)
        assert rolled[band] == pytest.approx(at_instant(0.02 + 0.04 * ((top + 1.5) / 179.0 - 0.5))[band], abs=0.02)


def test_light_changes_along_the_film_and_across_the_picture():
    """Of a blank picture: the last frame by the stated factor, evenly in the logarithm, and from border to border."""
    blank = replace(SCENE, marks=(), radius_m=1e-4, half_height_m=1e-4, background=0.5)
    even = film(blank, MOVING)[0][0, 0]
    lit = film(replace(blank, light=0.64, light_gradient=0.2), MOVING)
    assert lit[0][5, 0] / even == pytest.approx(0.9, abs=1e-3)
    assert lit[0][5, -1] / even == pytest.approx(1.1, abs=1e-3)
    for frame, factor in ((0, 1.0), (5, 0.8), (10, 0.64)):
        assert lit[frame][7].mean() / even == pytest.approx(factor, abs=1e-3)


@pytest.mark.parametrize("bits", [8, 12, 16])
def test_noise_has_its_standard_deviation_in_grey_levels_of_8_bit(bits):
    blank = replace(SCENE, marks=(), radius_m=1e-4, half_height_m=1e-4, background=0.5, noise=3.0, bits=bits)
    picture = next(iter(pictures(MOVING, blank, fps=100.0, seed=3))) / 2.0 ** (bits - 8)
    assert picture.std() == pytest.approx(3.0, rel=0.03)
    assert picture.mean() == pytest.approx(127.5, abs=0.1)


def test_frames_are_taken_from_the_first_instant_to_the_last_and_no_more_than_asked():
    assert [len(film(replace(SCENE, rays=1), MOVING, frames=frames)) for frames in (None, 4, 40)] == [11, 4, 11]


def test_a_rod_covers_the_area_of_its_strip():
    """A slanted strip: its area, its middle, and nothing beyond its ends; where two cross, the larger share."""
    rod = Rod(20.3, 30.0, 60.3, 60.0, 4.0, 0.3)
    cover, grey = rod_cover(replace(SCENE, rods=(rod,)))
    y, x = np.mgrid[:180, :160]
    assert cover.sum() == pytest.approx(50.0 * 4.0, rel=0.01)
    assert [(cover * x).sum() / cover.sum(), (cover * y).sum() / cover.sum()] == pytest.approx([40.3, 45.0], abs=0.02)
    assert set(np.unique(grey)) == {0.0, 0.3}
    both = rod_cover(replace(SCENE, rods=(rod, Rod(40.0, 0.0, 40.0, 179.0, 6.0, 0.1))))
    assert both[0].max() == 1.0
    assert both[1][100, 40] == 0.1
    assert both[1][30, 20] == 0.3
