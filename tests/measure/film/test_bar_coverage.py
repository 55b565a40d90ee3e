"""Stated 95 % bars of marks and of the platform against exact truth, over many synthetic pictures and films."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from calibration import consistent

from measure.correlation.reference_image import reference
from measure.correlation.refinement import refine, surface_near
from measure.film.track import track
from measure.footage.footage import from_array
from measure.geometry.camera import Camera
from measure.synthetic.made_film import MadeMark, Scene, pictures, project_for, true_motion
from measure.tables.trajectory import Trajectory

CENTRE, SUBSET = 36, 41


def _refined(before, after, shift):
    """Error of the refined reference point and its ratio to the stated sigma, (2,) each."""
    mark = reference(before, CENTRE, CENTRE, SUBSET)
    near = surface_near(after, mark.half, mark.start)
    assert near is not None
    match = refine(near, mark, mark.start)
    assert match is not None
    error = mark.point(match.warp) - CENTRE - shift
    return error, error / np.sqrt(np.diag(match.covariance))


@pytest.mark.calibrate
@pytest.mark.parametrize("grain", [1.0, 1.6])
def test_bars_of_marks_hold_the_truth_in_90_to_97_percent_of_400_pairs(grain, speckled, calibration_seed, share_of, validation_table):
    errors, ratios = [], []
    for number in range(share_of(400)):
        rng = np.random.default_rng([calibration_seed, number])
        shift, seed = rng.uniform(0.0, 1.0, 2), int(rng.integers(2**31))
        before = speckled(grain=grain, seed=seed, noise_seed=[seed, 1])
        error, ratio = _refined(before, speckled(shift, grain=grain, seed=seed, noise_seed=[seed, 2]), shift)
        errors.append(error)
        ratios.append(ratio)
    inside = np.abs(ratios) < 1.96
    row = {
        "speckle, px": grain, "pairs": len(errors), "inside, %": 100 * inside.mean(), "rms, px": np.sqrt(np.mean(np.square(errors))),
        "bias, px": np.abs(np.mean(errors, axis=0)).max(),
    }  # fmt: skip
    validation_table("95 % bars of marks", [row], "Shifts of 0 to 1 px, noise of 1.5 grey levels; aim 90 to 97 %.")
    assert all(consistent(int(axis.sum()), len(axis), 0.90, 0.97) for axis in inside.T), row


@pytest.mark.calibrate
def test_bars_of_a_turning_platform_hold_the_truth_in_24_films(rig, calibration_seed, share_of, validation_table):
    """All frames of a film share the noise of its reference image, so that a film, not a frame, is one case."""
    gaps: dict[str, list[np.ndarray]] = {}
    ratios: dict[str, list[np.ndarray]] = {}
    for number in range(share_of(24)):
        motion, scene = rig(theta_z=np.radians(30.0))
        truth = true_motion(motion, scene, 100.0).trajectory
        film = from_array(np.array(list(pictures(motion, scene, fps=100.0, seed=calibration_seed + number))))
        found = track(film, project_for(scene, 100.0, 0.252)).trajectory
        assert found is not None
        for channel, values in found.channels.items():
            gap = (values - truth.channels[channel])[1:]
            gaps.setdefault(channel, []).append(gap)
            ratios.setdefault(channel, []).append(gap / found.sigma[channel][1:])
    rows = [
        {
            "channel": channel, "films": len(of), "inside, %": 100 * np.mean(np.abs(of) < 1.96),
            "rms over sigma": np.sqrt(np.mean(np.square(of))), "rms": np.sqrt(np.mean(np.square(gaps[channel]))),
        }
        for channel, of in ratios.items()
    ]  # fmt: skip
    validation_table("95 % bars of a platform that turns by 30 deg", rows, "Six speckled marks on a cylinder; aim 85 to 99 %.")
    slack = 1.0 + 1.0 / np.sqrt(share_of(24)) - 1.0 / np.sqrt(24)  # fewer films say less
    low, high = 100.0 - 15.0 * slack, 99.5 * slack
    assert all(low < row["inside, %"] <= high and 0.6 / slack < row["rms over sigma"] < 1.4 * slack for row in rows), rows


def _drum(kind, seed):
    """A drum with six marks that rises, drifts, tilts and turns by 30 deg about the vertical in 60 frames."""
    rng = np.random.default_rng(seed)
    time = np.arange(60) / 100.0
    s = np.clip((time - 0.08) / 0.48, 0.0, 1.0)
    tilt = np.radians(rng.uniform(-1.5, 1.5, 2))
    motion = Trajectory(
        time,
        {
            "x_m": 0.004 * np.sin(3.0 * s), "z_m": 0.10 * s**2 * (3.0 - 2.0 * s), "theta_x_rad": tilt[0] * np.sin(3.0 * s),
            "theta_y_rad": tilt[1] * s**2, "theta_z_rad": np.radians(30.0) * s**2,
        },
    )  # fmt: skip
    size, azimuth = rng.uniform(0.014, 0.018), rng.uniform(0.40, 0.55)
    marks = tuple(MadeMark(a, h, size, kind) for h in (-0.0115, 0.0115) for a in (-azimuth, 0.0, azimuth))
    place = (152.0 + rng.uniform(0.0, 1.0), 330.0 + rng.uniform(0.0, 1.0))
    camera = Camera(0.5e-3, place, 0.0, 3.0, (152.0, 190.0))
    scene = Scene(304, 384, camera, marks, 0.07, 0.0235, background=0.05, rays=8)
    return motion, scene, 2 * int(1000.0 * size * 0.75) + 1


@pytest.mark.slow
def test_rows_of_quadrants_hold_although_an_edge_along_a_row_stands_in_quarters_of_a_pixel():
    """Such an edge leaves no residual in the picture. Without the marks' own scatter 75 % of the errors are within the bars."""
    inside = []
    for seed in (3, 4, 5):
        motion, scene, subset = _drum("quadrant", seed)
        scene = replace(scene, rays=4)
        truth = true_motion(motion, scene, 100.0)
        film = from_array(np.array(list(pictures(motion, scene, fps=100.0, seed=seed))))
        marks = track(film, project_for(scene, 100.0, 0.0, subset)).marks
        gap = np.stack([marks.x_px - truth.x_px, marks.y_px - truth.y_px], axis=-1)
        sigma = np.sqrt(np.diagonal(marks.covariance_px2, axis1=2, axis2=3))
        inside.append(np.mean(np.abs(gap / sigma)[1:] < 1.96))
    assert 0.85 < np.mean(inside) < 0.97, inside


@pytest.mark.calibrate
@pytest.mark.parametrize(("kind", "aim_deg"), [("dot", 0.1), ("quadrant", 0.3)])
def test_dots_and_quadrants_on_a_drum_are_seen_and_give_its_rotation(kind, aim_deg, calibration_seed, share_of, validation_table):
    """The pictures are cast with 8 x 8 rays a pixel, so that an upright edge is at its place to an eighth of a pixel."""
    gaps, ratios, unseen, off = [], [], 0, 0
    for number in range(share_of(12)):
        motion, scene, subset = _drum(kind, calibration_seed + number)
        truth = true_motion(motion, scene, 100.0)
        film = from_array(np.array(list(pictures(motion, scene, fps=100.0, seed=calibration_seed + number))))
        tracked = track(film, project_for(scene, 100.0, 0.0, subset))
        assert tracked.trajectory is not None
        gap = (tracked.trajectory.channels["theta_z_rad"] - truth.trajectory.channels["theta_z_rad"])[1:]
        gaps.append(gap)
        ratios.append(gap / tracked.trajectory.sigma["theta_z_rad"][1:])
        marks = tracked.marks
        unseen += int((~marks.observed).sum())
        off += int((np.hypot(marks.x_px - truth.x_px, marks.y_px - truth.y_px) > 0.5).sum())
    row = {
        "mark": kind, "films": len(gaps), "theta_z rms, deg": np.degrees(np.sqrt(np.nanmean(np.square(gaps)))),
        "inside, %": 100 * np.nanmean(np.abs(ratios) < 1.96), "sightings": 360 * len(gaps), "unseen": unseen, "off by 0.5 px": off,
    }  # fmt: skip
    validation_table(
        f"a drum with {kind}s that turns by 30 deg", [row], f"Aim: theta_z to {aim_deg} deg, none off by over 0.5 px unflagged."
    )
    assert row["theta_z rms, deg"] < aim_deg, row
    assert off <= 1e-3 * row["sightings"], row
    assert unseen <= 1e-2 * row["sightings"], row
