"""Model against measurement in numbers that can be checked by hand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from identify.campaign.run import Run
from identify.commands.compare_model import main
from identify.estimation.observation import RunRelease, View, between, observe, rig_time
from identify.estimation.parameters import lines_of
from identify.gap.compare import compare
from identify.report.result import result_of
from identify.selection.explain import explain
from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory
from simulate.deployment.deploy import deploy
from simulate.effects import HubInertia, TimeOffset
from simulate.files.model_file import read_model
from simulate.loop import loop_force
from simulate.model.model import with_value

PROTOTYPE = Path(__file__).resolve().parents[1].joinpath("rig.toml")


@pytest.fixture
def model():
    return read_model(PROTOTYPE)


def film(model, offset=0.0, sigma=1e-5, seed=0, release=None):
    time = np.arange(120) / 250.0
    shown = observe(View(model, time, release or RunRelease(position_m=(1e-3, 0.0, 0.0))))
    noise = np.random.default_rng(seed).normal(0.0, sigma, (2, 120))
    channels = {"x_m": shown["x_m"] + noise[0], "z_m": shown["z_m"] + offset + noise[1]}
    return Trajectory(time, channels, {name: np.full(120, sigma) for name in channels}, name="film")


def test_a_model_that_is_true_leaves_noise_and_fits_to_its_level(model):
    found = compare(model, [Run(film(model))])
    assert found.gap_is_noise
    z = next(curve for curve in found.curves if curve.channel == "z_m").numbers
    assert z["rmse"] == pytest.approx(1e-5, rel=0.2)
    assert z["fit_percent"] > 99.9
    assert z["nrmse_percent"] == pytest.approx(100 * z["rmse"] / np.ptp(film(model).channels["z_m"]), rel=1e-9)


def test_taken_to_the_letter_an_offset_is_the_error(model):
    found = compare(model, [Run(film(model, offset=0.003, release=RunRelease(position_m=(1e-3, 0.0, 0.0))))], fit_release=False)
    z = next(curve for curve in found.curves if curve.channel == "z_m")
    assert z.gap.mean() == pytest.approx(0.003, rel=1e-2)
    assert not found.gap_is_noise


def test_between_its_samples_a_deployment_is_seen_as_at_them(model):
    fine = deploy(model)
    times = fine.time_s[10:600:7]
    shown = observe(View(model, times, RunRelease()))
    assert np.max(np.abs(shown["z_m"] - fine.channels["z_m"][10:600:7])) < 5e-6


def test_two_runs_that_differ_by_five_percent_are_said_to(model):
    one, two = film(model), film(model, seed=1)
    spread = 0.05 * np.ptp(two.channels["z_m"])
    moved = Trajectory(two.time_s, {**two.channels, "z_m": two.channels["z_m"] + spread}, name="second")
    assert compare(model, [Run(one), Run(moved)]).dispersion_percent == pytest.approx(5.0, rel=0.02)


def test_the_command_writes_json_and_figure(model, tmp_path, capsys):
    from measure.tables.trajectory import write_trajectory

    write_trajectory(film(model), tmp_path / "film.csv")
    status = main([str(PROTOTYPE), str(tmp_path / "film.csv"), "--json", str(tmp_path / "r.json"), "-o", str(tmp_path / "r.png")])
    assert status == 0
    result = json.loads((tmp_path / "r.json").read_text())
    assert set(result["runs"][0]["channels"]["z_m"]) == {"rmse", "max_abs", "nrmse_percent", "fit_percent", "noise_sigma"}
    assert result["gap_is_noise"] is True
    assert result["dispersion_percent"] is None
    assert (tmp_path / "r.png").stat().st_size > 10_000
    assert "the gap is" in capsys.readouterr().out


def test_between_rows_a_polynomial_of_the_fifth_degree_is_met_exactly_and_few_rows_do():
    at = np.array([0.0, 0.3, 2.5, 7.0, 10.75, 11.0])
    curve = np.polynomial.Polynomial([1.0, -0.4, 0.3, -0.05, 2e-3, 1e-4])
    assert between(np.column_stack([curve(np.arange(12.0)), np.arange(12.0)]), at) == pytest.approx(
        np.column_stack([curve(at), at]), rel=1e-12
    )
    assert between(np.array([[1.0], [3.0]]), np.array([0.25]))[0, 0] == pytest.approx(1.5)


def test_a_loop_is_compared_as_it_was_measured_whatever_its_motion_may_be_wrong_by(model):
    """A hub too light by 50 g on a heavy one: the error of the amplitude could be the cause, the difference is there all the same."""
    heavy, chance = model.with_effect(HubInertia(0.6)), np.random.default_rng(5)
    t, w = np.arange(1001) * 1e-3, 6.0 * np.pi
    u, v, a = 0.1 + 0.03 * np.sin(w * t), 0.03 * w * np.cos(w * t), -0.03 * w**2 * np.sin(w * t)
    force = loop_force(lines_of(heavy), t, u, v, a, 2.84, heavy.effects) - 0.05 * a
    measured = Loop(t, u + chance.normal(0.0, 1e-5, 1001), force + chance.normal(0.0, 1e-3, 1001))
    (curve,) = compare(heavy, [Run(measured)]).curves
    assert curve.numbers["rmse"] == pytest.approx(0.05 * np.std(a), rel=0.02)


CLOCK = TimeOffset().with_flat(np.array([0.004, 0.003]))


def test_a_clock_that_the_onset_sets_is_right_there_whatever_it_shows(model):
    shown = np.array([0.0, 0.1, 0.5])
    assert rig_time((CLOCK,), shown) == pytest.approx((shown - 0.004) / 1.003)
    assert rig_time((CLOCK,), shown, 0.1) == pytest.approx(0.1 + (shown - 0.1) / 1.003)


@pytest.mark.slow
def test_of_tables_that_count_from_their_first_frame_a_clock_shows_its_rate_and_not_its_offset(model):
    """The camera runs before the release; where its clock began, nobody can tell."""
    runs = []
    for start in (0.25, 0.30):
        there = with_value(model, "geometry.stowed_height_m", start)
        film = observe(View(there.with_effect(CLOCK), np.arange(150) / 250.0, RunRelease(instant_s=0.02)))
        noise = np.random.default_rng(int(100 * start)).normal(0.0, 4e-6, (2, 150))
        channels = {"x_m": film["x_m"] - film["x_m"][0] + noise[0], "z_m": film["z_m"] - film["z_m"][0] + start + noise[1]}
        table = Trajectory(np.arange(150) / 250.0, channels, {name: np.full(150, 4e-6) for name in channels}, name=f"film {start}")
        runs.append(Run(table, {"geometry": {"stowed_height_m": start}}))
    found = explain(model, runs, {"time-offset": TimeOffset})
    parameters = result_of(found)["effects"][0]["parameters"]
    assert parameters["rate_fraction"]["identifiable"]
    low, high = parameters["rate_fraction"]["ci95"]
    assert 0.0 < low < 0.003 < high
    assert not parameters["offset_s"]["identifiable"]
    assert parameters["offset_s"]["value"] == pytest.approx(0.0, abs=2e-3)  # half a frame: nothing holds it but its start
    assert np.isnan(parameters["offset_s"]["stderr"])
    low, high = found.findings[0].effect.bounds(model, found.after.problem.measures)["offset_s"]
    assert parameters["offset_s"]["ci95"] == pytest.approx([low, high])
