"""What the summary of a film says to people, word by word, and in numbers."""

from __future__ import annotations

import copy
from types import SimpleNamespace

import numpy as np
import pytest

from measure.correlation.marks import Marks
from measure.correlation.shape_function_bias import EVEN, NODES, Response
from measure.film.dispersion import compare_trajectories
from measure.film.noise import FilmNoise
from measure.film.one_body import Body, LeftOut
from measure.film.summary import dispersion_lines, lines_for_people, summarise
from measure.footage.footage import from_array
from measure.footage.integrity import IntegrityCheck
from measure.geometry.film_project import make_project
from measure.tables.trajectory import Trajectory

OK = {"sigma_px": 0.01, "rigid_residual_px": 0.1}
RESULT = {
    "verdict": "ok",
    "film": {
        "file": "a.avi", "frames": 90, "frames_read": 88, "fps": 250.0, "width_px": 304, "height_px": 1024, "bits": 8, "first_frame": 0,
        "from_s": 0.0, "to_s": 0.356, "remarks": ["frames are dark (1): 7"],
    },
    "marks": [
        {"name": "m1", "x_px": 10.26, "y_px": 20.0, "frames": {"ok": 88}, "first_not_ok": None, **OK},
        {"name": "m2", "x_px": 30.0, "y_px": 44.44, "frames": {"lost": 3, "ok": 85}, "first_not_ok": 9, **OK},
    ],
    "left_out": [],
    "subset_px": 25,
    "sigma_px": 0.0123,
    "scale": {"mm_per_px": 0.5, "relative_sigma": 0.0, "said": "given", "up_deg": 0.0, "up_sigma_deg": None},
    "platform": {
        "range": {"x_m": 0.0021, "theta_z_rad": 0.1, "z_m": None},
        "median_sigma": {"x_m": 4e-6, "theta_z_rad": 1e-3, "z_m": None},
        "remarks": [],
    },
    "noise": [],
}  # fmt: skip


def said(**changed):
    return lines_for_people({**copy.deepcopy(RESULT), **changed})


def test_each_thing_has_its_line():
    assert said() == [
        "film      88 of 90 frames, 304 x 1024 px, 8 bit, 250 frames/s",
        "          frames are dark (1): 7",
        "marks     2 of subset 25 px",
        "          m2 at 30.0,44.4: 3 lost, 85 ok; first not ok in frame 9",
        "sigma     0.0123 px   0.0062 mm per mark and frame",
        "platform  x moves 2.10 +- 0.004 mm, theta_z moves 5.73 +- 0.057 deg, z not observed",
        "verdict   ok",
    ]


def test_without_a_scale_and_a_platform_there_is_neither():
    lines = said(scale={"mm_per_px": None, "relative_sigma": None}, platform=None)
    assert "sigma     0.0123 px per mark and frame" in lines
    assert not any(line.startswith(("scale", "platform", "up")) for line in lines)
    assert not any(line.startswith("sigma") for line in said(sigma_px=None))


def test_a_scale_and_the_vertical_are_said_where_they_were_measured():
    scale = {"mm_per_px": 0.51234, "relative_sigma": 0.00123, "said": "by a rule", "up_deg": 1.2345, "up_sigma_deg": 0.02}
    lines = said(scale=scale)
    assert "scale     0.51234 mm/px +- 0.12 % (by a rule)" in lines
    assert "up        1.234 +- 0.020 deg by the plumb line" in lines
    assert any(line.startswith("scale") for line in said(scale={**RESULT["scale"], "relative_sigma": 0.01}))
    assert any(line.startswith("scale") for line in said(scale={**RESULT["scale"], "said": "from two points"}))
    assert not any(line.startswith(("scale", "up")) for line in said())


def test_marks_that_are_left_out_for_one_reason_stand_on_one_line_six_at_most():
    left = [{"x_px": 10.4 * k, "y_px": 1.6, "reason": "lost" if k < 7 else "still"} for k in range(1, 9)]
    lines = said(left_out=left)
    assert "left out  10,2 21,2 31,2 42,2 52,2 62,2: lost" in lines
    assert "left out  73,2 83,2: still" in lines
    assert "left out  10,2 21,2 31,2 42,2 52,2 62,2 ...: lost" in said(left_out=[{**one, "reason": "lost"} for one in left])


def test_noise_is_said_where_it_is_clearly_kept_from_frame_to_frame():
    noise = [{"channel": "x_m", "lag1": 0.31, "lag1_sigma": 0.1}, {"channel": "theta_z_rad", "lag1": 0.29, "lag1_sigma": 0.1}]
    assert "noise     correlated from frame to frame: x 0.31 +- 0.10" in said(noise=noise)
    assert not any(line.startswith("noise") for line in said(noise=noise[1:]))


def test_a_part_of_a_film_says_from_when_to_when():
    film = {**RESULT["film"], "first_frame": 25, "from_s": 0.1, "to_s": 0.3}
    assert said(film=film)[0].endswith("250 frames/s, from 0.1 to 0.3 s")


def test_films_that_differ_say_by_how_much_of_each_channel():
    time = np.arange(40) / 100.0
    ones = np.ones(40)
    first = Trajectory(time, {"z_m": time**2, "x_m": 0.0 * time}, {"z_m": 1e-5 * ones, "x_m": 1e-5 * ones})
    second = Trajectory(time, {"z_m": time**2, "x_m": 0.0 * time - 0.002}, {"z_m": 1e-5 * ones, "x_m": 1e-5 * ones})
    (line,) = dispersion_lines([compare_trajectories(first, second, "b.csv")])
    assert line.startswith("disperses x 2 mm, z ")
    assert line.endswith("%) rms from b.csv, +0.00 ms apart")


FRAMES = 10
FOOTAGE = from_array(np.full((FRAMES, 20, 30), 90, np.uint8), fps=100.0)
PROJECT = make_project({"film": {"fps": 100.0}, "marks": {"subset_px": 21}})


def marks_of(count=4, way=5.0):
    start = np.array([[20.0 * i, 7.0] for i in range(count)])
    path = start + np.linspace(0.0, 1.0, FRAMES)[:, None, None] * [way, 0.0]
    response = Response(
        start, start[:, None] + NODES, np.tile(EVEN, (count, 1, 1, 1)), np.full(count, 6), np.tile(np.eye(4), (count, 1, 1))
    )
    covariance = np.broadcast_to(1e-4 * np.eye(2), (FRAMES, count, 2, 2)).copy()
    even = np.ones((FRAMES, count))
    status = np.full((FRAMES, count), "ok", "<U12")
    return Marks(
        np.arange(FRAMES) / 100.0, [f"m{i}" for i in range(count)], response, path[..., 0], path[..., 1], covariance, even, 0 * even, status
    )


def without(marks, frames, which, status="lost"):
    gone = np.zeros(marks.status.shape, bool)
    gone[frames, which] = True
    return marks.without(gone, status)


def fit_of(marks, rigid=True, residual=0.0, has_pose=None):
    posed = np.ones(FRAMES, bool) if has_pose is None else has_pose
    of_marks = np.full(len(marks.names), residual)
    pixels = np.full((*marks.status.shape, 2), 3.0)
    return SimpleNamespace(
        has_pose=posed, is_rigid=rigid, mark_residual_px=of_marks, used=marks.observed, residual_px=pixels, free=("x_m", "z_m"),
        widened=np.array([1.0, 2.0, 4.0]), rough=np.array([1.0, 1.5]),
    )  # fmt: skip


def summary(body, fit=None, table=None, footage=FOOTAGE):
    return summarise(footage, PROJECT, None, body, fit, table, IntegrityCheck())


def test_the_verdict_is_the_first_thing_that_is_wrong():
    marks = marks_of()
    gone = without(marks, slice(2, 4), slice(None), "missing")
    lost = without(marks, 5, slice(None))
    few = without(marks, slice(1, None), slice(0, 3))
    assert summary(Body(gone))["verdict"] == "incomplete"
    assert summary(Body(marks_of(way=0.05)))["verdict"] == "still"
    assert summary(Body(lost))["verdict"] == "lost"
    assert summary(Body(marks), fit_of(marks, has_pose=np.arange(FRAMES) != 4))["verdict"] == "lost"
    assert summary(Body(few))["verdict"] == "few-marks"
    assert summary(Body(marks, lost=5))["verdict"] == "few-marks"
    assert summary(Body(marks, lost=4))["verdict"] == "ok"
    assert summary(Body(without(marks, slice(0, 5), slice(0, 4, 2))))["verdict"] == "ok"
    assert summary(Body(marks), fit_of(marks, rigid=False, residual=0.11))["verdict"] == "not-rigid"
    assert summary(Body(marks), fit_of(marks, rigid=False, residual=0.09))["verdict"] == "ok"
    assert summary(Body(marks), fit_of(marks, rigid=True, residual=0.11))["verdict"] == "ok"
    assert summary(Body(marks, rivals=2))["verdict"] == "several-bodies"
    assert summary(Body(marks))["verdict"] == "ok"


def test_numbers_of_marks_and_film_are_those_of_the_tables():
    marks = without(marks_of(), slice(3, 5), 1, "occluded")
    found = summary(Body(marks, (LeftOut(1.0, 2.0, "still"),)), fit_of(marks))
    assert found["film"]["frames_read"] == found["film"]["frames"] == FRAMES
    assert (found["film"]["from_s"], found["film"]["to_s"]) == (0.0, pytest.approx(0.09))
    assert (found["film"]["width_px"], found["film"]["height_px"], found["film"]["bits"]) == (30, 20, 8)
    assert found["left_out"] == [{"x_px": 1.0, "y_px": 2.0, "reason": "still"}]
    assert found["sigma_px"] == pytest.approx(0.01)
    one = found["marks"][1]
    assert (one["name"], one["x_px"], one["y_px"], one["frames"], one["first_not_ok"]) == ("m1", 20.0, 7.0, {"occluded": 2, "ok": 8}, 3)
    assert (one["sigma_px"], one["rigid_residual_px"]) == (pytest.approx(0.01), pytest.approx(3.0))
    assert found["marks"][0]["first_not_ok"] is None
    nowhere = summary(Body(without(marks, slice(None), 2)))["marks"][2]
    assert (nowhere["sigma_px"], nowhere["rigid_residual_px"], nowhere["first_not_ok"]) == (None, None, 0)


def test_numbers_of_the_platform_are_those_of_its_trajectory():
    marks = marks_of()
    z = np.array([0.25, 0.26, np.nan, *np.full(7, 0.29)])
    table = Trajectory(
        marks.time_s, {"x_m": np.full(10, np.nan), "z_m": z}, {"x_m": np.full(10, np.nan), "z_m": np.linspace(1e-5, 3e-5, 10)}
    )
    found = summary(Body(marks), fit_of(marks, rigid=False), table)["platform"]
    assert found["range"] == {"x_m": None, "z_m": pytest.approx(0.04)}
    assert found["median_sigma"] == {"x_m": None, "z_m": pytest.approx(2e-5)}
    assert (found["channels"], found["frames_with_pose"], found["widened"]) == (["x_m", "z_m"], 10, 2.0)
    assert found["rough"] == {"x_m": 1.0, "z_m": 1.5}
    assert "rigid body" in found["remarks"][0]
    assert set(found["instants"]) == {"release_s", "fastest_s", "end_of_stroke_s"}
    short = Trajectory(marks.time_s, {"z_m": np.where(np.arange(10) < 7, z, np.nan)}, {"z_m": np.full(10, 1e-5)})
    assert summary(Body(marks), fit_of(marks), short)["platform"]["instants"] == {}
    assert summary(Body(marks), fit_of(marks), table)["platform"]["remarks"] == []


def test_a_channel_of_noise_has_the_fields_that_the_lines_want():
    assert {"channel", "lag1", "lag1_sigma"} <= set(FilmNoise.__dataclass_fields__)
