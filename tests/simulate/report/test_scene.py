"""Deployments as data of the scene, and the figures of a sweep's page, on runs that are made by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from measure.tables.trajectory import CHANNELS, Trajectory
from simulate.deployment.result import Deployment
from simulate.kernel.layout import SAMPLE_ELONGATION, SAMPLE_FORCE, SAMPLE_POSE, SAMPLE_SIZE
from simulate.report.replay_page import _data
from simulate.report.scene import kept_frames, plain, scene_of, seen
from simulate.report.sweep_page import _histogram, _indices, _summary, _tolerance, _two_factors

COUNT = 101
TIME = np.arange(COUNT) / 100.0


@pytest.fixture
def run(lopsided):
    turned = Rotation.from_rotvec(np.outer(TIME, [0.1, -0.2, 1.5]))
    samples = np.zeros((COUNT, SAMPLE_SIZE))
    samples[:, SAMPLE_POSE : SAMPLE_POSE + 3] = np.outer(TIME, [0.01, -0.02, 0.3])
    samples[:, SAMPLE_POSE + 3 : SAMPLE_POSE + 7] = turned.as_quat(scalar_first=True)
    samples[:, SAMPLE_FORCE : SAMPLE_FORCE + 6] = np.outer(TIME, np.arange(1.0, 7.0))
    samples[:, SAMPLE_ELONGATION : SAMPLE_ELONGATION + 6] = 0.1 * TIME[:, None]
    return Deployment(lopsided, TIME, samples, 5e-4, None)


@pytest.mark.parametrize(("most", "kept"), [(5, [0, 25, 50, 75, 100]), (101, list(range(101))), (400, list(range(101))), (1, [0])])
def test_frames_are_spread_evenly_from_the_first_to_the_last(run, most, kept):
    assert kept_frames(run, most).tolist() == kept


def test_a_scene_has_the_rig_in_its_size_and_every_run_in_its_frames(run):
    scene = scene_of({"one": run, "other": run}, ["given", "effect"], frames=5, link="curves", begin_s=0.7, legs=True)
    g = run.model.geometry
    assert scene["time"] == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert [(m["name"], m["colour"], len(m["place"]), len(m["quaternion"][0])) for m in scene["models"]] == [
        ("one", "given", 5, 4), ("other", "effect", 5, 4),
    ]  # fmt: skip
    assert scene["models"][0]["force"][2] == [0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    assert scene["base"] == [list(p) for p in g.base_joints_m]
    assert scene["joints"] == [list(p) for p in g.platform_joints_m]
    assert (scene["stowed"], scene["middle"]) == (g.stowed_height_m, g.deployed_height_m / 2)
    assert scene["size"] == max(np.max(np.abs(g.base_joints_m)), g.deployed_height_m / 2)
    assert (scene["measured"], scene["link"], scene["begin"], scene["shown"]) == (None, "curves", 0.7, 0.5)
    stowed = np.array(scene["lengths"][0])
    assert np.array(scene["lengths"][-1]) - stowed == pytest.approx(np.full(6, 0.1), abs=1e-6)
    plainly = scene_of({"one": run}, ["given"])
    assert (plainly["lengths"], len(plainly["time"]), plainly["begin"]) == (None, 101, 0.0)
    tall = replace(run, model=replace(run.model, geometry=replace(g, deployed_height_m=4.0)))
    assert scene_of({"one": tall}, ["given"])["size"] == 2.0
    assert _data(tall, None)["size"] == _data(tall, None)["middle"] == 2.0
    assert _data(run, None)["size"] == scene["size"]


def test_what_was_measured_is_turned_as_it_was_and_null_outside_of_the_measurement(run):
    kept = kept_frames(run, 11)
    part = slice(20, 71)
    channels = {name: values[part] for name, values in run.channels.items()}
    found = seen(run, kept, Trajectory(TIME[part], channels))
    assert [place is None for place in found["place"]] == [True] * 2 + [False] * 6 + [True] * 3
    pose = run.samples[kept, SAMPLE_POSE : SAMPLE_POSE + 7]
    for k in range(2, 8):
        assert found["place"][k] == pytest.approx(pose[k, :3], abs=1e-6)
        assert abs(np.dot(found["quaternion"][k], pose[k, 3:])) == pytest.approx(1.0, abs=1e-6)


def test_a_channel_that_was_not_measured_is_as_modelled_and_gaps_are_bridged(run):
    kept = kept_frames(run, 11)
    z = 0.5 + TIME
    z[30:41] = np.nan
    found = seen(run, kept, Trajectory(TIME, {"z_m": z, "x_m": np.full(COUNT, np.nan)}))
    assert [place[2] for place in found["place"]] == pytest.approx(0.5 + TIME[kept])
    assert [place[0] for place in found["place"]] == pytest.approx(run.channels["x_m"][kept])
    assert set(CHANNELS) - {"z_m"} <= set(run.channels)


def test_numbers_have_six_digits_and_what_is_none_is_null():
    assert plain(np.array([1.23456789, np.nan, -np.inf, 0.0])) == [1.23457, None, None, 0.0]
    assert plain(np.array([[1.0], [np.inf]])) == [[1.0], [None]]


def test_a_page_has_curves_in_millimetres_and_degrees_and_measured_ones_as_far_as_the_run_goes(run):
    longer = np.append(TIME, [1.1, 1.2])
    data = _data(run, Trajectory(longer, {"z_m": np.full(103, 0.3), "theta_z_rad": np.full(103, np.pi / 6)}))
    height, lateral, rotation, force = data["panels"]
    assert height["lines"][0]["values"][-1] == pytest.approx(300.0)
    assert [line["name"] for line in lateral["lines"]] == ["x", "y"]
    assert "measured" not in lateral["lines"][0]
    theta = rotation["lines"][2]
    assert theta["values"][50] == pytest.approx(np.degrees(run.channels["theta_z_rad"][50]), rel=1e-5)
    assert (len(theta["measured"]["time"]), theta["measured"]["values"][-1]) == (101, pytest.approx(30.0))
    assert [line["values"][-1] for line in force["lines"]] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert [panel["least"] for panel in data["panels"]] == [1.0, 1.0, 1.0, 0.1]


LEVELS = np.linspace(-1.0, 1.0, 17)


def swept(**changed) -> Any:
    factors = [SimpleNamespace(letter=letter, key=f"key.{letter}") for letter in "ABC"]
    given = {
        "response": "theta_z_deg", "unit": "deg", "limit": 30.0, "failure_deg": 30.0, "largest_pair": (0, 2),
        "sweep": SimpleNamespace(factors=factors, model=SimpleNamespace(name="rig")),
        "histogram": lambda: (np.array([2, 0, 4]), np.array([-40.0, -20.0, 0.0, 20.0])),
        "map": lambda one, other: 10.0 * LEVELS[:, None] + other * LEVELS[None, :],
    }  # fmt: skip
    return SimpleNamespace(**{**given, **changed})


def test_a_histogram_is_a_band_of_steps_with_the_limits_that_lie_within_it():
    (panel,) = _histogram(swept()).panels
    (band,) = panel.bands
    assert band.x.tolist() == [-40.0, -20.0, -20.0, 0.0, 0.0, 20.0]
    assert band.high.tolist() == [2.0, 2.0, 0.0, 0.0, 4.0, 4.0]
    assert band.low.tolist() == [0.0] * 6
    assert [line.x.tolist() for line in panel.lines] == [[-30.0, -30.0]]
    assert panel.limits == (0.0, pytest.approx(4.2))
    assert _histogram(swept(limit=None)).panels[0].lines == []
    assert _histogram(swept(limit=10.0)).title == "theta_z_deg of 6 runs"
    assert [line.x[0] for line in _histogram(swept(limit=20.0)).panels[0].lines] == [-20.0, 20.0]


def test_the_response_over_two_factors_has_the_first_along_and_the_second_as_curves():
    (section,) = _two_factors(swept())
    lines = section.figures[0].panels[0].lines
    assert [line.name for line in lines] == ["C = -1", "C = -0.5", "C = 0", "C = 0.5", "C = 1"]
    assert [line.y[0] for line in lines] == [-12.0, -11.0, -10.0, -9.0, -8.0]
    assert lines[0].x.tolist() == LEVELS.tolist()
    assert section.figures[0].caption.startswith("key.A (A) along, key.C (C) as curves; -1 and 1 are the ends")
    assert _two_factors(swept(largest_pair=None)) == []


def test_the_tolerance_has_what_was_simulated_and_the_line_of_the_slopes():
    curve = [{"spread_N": 0.01, "angle_deg": 9.0}, {"spread_N": 0.02, "angle_deg": 17.0}]
    report = {"tolerance": {"curve": curve, "probability": 0.95, "slope_deg_per_N": [300.0, -400.0]}}
    (section,) = _tolerance(report, ["said"])
    simulated, slopes = section.figures[0].panels[0].lines
    assert (simulated.x.tolist(), simulated.y.tolist()) == ([10.0, 20.0], [9.0, 17.0])
    assert slopes.y == pytest.approx(1.959964 * 500.0 * np.array([0.01, 0.02]))
    assert section.figures[0].title == "Angle kept in 95 % of the runs"
    assert _tolerance({"tolerance": {**report["tolerance"], "curve": []}}, []) == []


REPORT: dict[str, Any] = {
    "runs": 400, "design": "random", "factors": [{}, {}, {}], "diverged": 0, "failed_percent": 4.9, "failed_before_stop_percent": 1.2,
    "failed_interval_percent": (3.2, 7.5), "variability_percent": {"A": 46.0, "B": 42.0, "C": 12.0},
    "step": {"sensitive_probes": 8, "probes": 32, "largest_error_deg": 0.021, "step_s": 2e-3}, "provenance": {"seed": 3},
}  # fmt: skip


def summary(**changed):
    return _summary(swept(), {**REPORT, **changed}, ["said"])


def test_a_sweep_is_good_below_five_percent_of_failures_doubtful_above_and_bad_where_it_diverged():
    found = [summary().tone, summary(failed_percent=5.1).tone, summary(diverged=1).tone]
    assert found == ["good", "doubt", "bad"]


def test_factors_of_nearly_the_same_share_are_named_together():
    (_, _, most) = summary().numbers
    assert (most.value, most.remark) == ("A, B", "together 88 % of the variability")
    assert summary(variability_percent={"A": 50.0, "B": 44.0}).numbers[2].value == "A"
    assert len(summary(variability_percent={}).numbers) == 2


def test_indices_have_a_row_a_factor_with_their_intervals():
    row = {"value": 0.51234, "interval": (0.4, 0.6)}
    found = {"indices": {"indices": {"total": {"A": row, "B": row}, "first_order": {"A": row, "B": {**row, "value": 0.1}}}}}
    (table,) = _indices(found)
    assert table.rows[1] == ["B", "0.512 (0.4 to 0.6)", "0.1 (0.4 to 0.6)"]
    assert _indices({"indices": None}) == _indices({"indices": {"indices": None}}) == []
