"""The polynomials travel the whole chain: loops, model file, deployment, sweep, comparison, explanation."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from identify.commands import compare_model, explain_gap, fit_actuator
from measure.tables.trajectory import read_trajectory
from simulate.commands import simulate_deployment, sweep_deployments
from simulate.effects import CATALOGUE
from simulate.files.model_file import read_document, read_model

DEMO = Path(__file__).resolve().parents[3] / "datasets" / "demo"
ONE_STROKE = sorted(map(str, (DEMO / "loops").glob("*-20mm.csv")))


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """The shipped loops of one stroke fitted over frequency and over speed, as model files of the shipped rig."""
    folder = tmp_path_factory.mktemp("fitted")
    for rate in ("frequency", "speed"):
        made = ["-o", str(folder / f"{rate}.toml"), "--json", str(folder / f"{rate}.json"), "--no-suggest", "--quiet"]
        fit_actuator.main([*ONE_STROKE, "--rate", rate, "--model", str(DEMO / "rig.toml"), *made])
    return folder


def test_the_file_keeps_what_the_loops_covered(fitted):
    rate = read_model(fitted / "frequency.toml").actuator.rate
    assert rate is not None
    assert rate.frequency_Hz == pytest.approx((0.2, 1.0, 3.0), rel=1e-3)
    assert rate.stroke_m == pytest.approx((0.02,) * 3, rel=1e-3)
    assert rate.mid_stroke_speed_m_per_s == pytest.approx(tuple(np.pi * 0.02 * f for f in (0.2, 1.0, 3.0)), rel=1e-3)


def test_fits_over_frequency_and_over_speed_deploy_alike(fitted, capsys):
    runs = {}
    for rate in ("frequency", "speed"):
        assert simulate_deployment.main([str(fitted / f"{rate}.toml"), "-o", str(fitted / f"{rate}.csv")]) == 0
        runs[rate] = read_trajectory(fitted / f"{rate}.csv").channels
    assert max(np.max(np.abs(runs["frequency"][name] - runs["speed"][name])) for name in runs["speed"]) < 1e-9
    assert capsys.readouterr().out.count("and their polynomials are extrapolated") == 2


def test_loops_that_an_inertia_turns_are_said_to_and_the_effect_is_offered(fitted):
    result = json.loads((fitted / "speed.json").read_text())
    assert result["rate"]["inertia"]["mass_kg"] == pytest.approx(0.01, rel=0.02)
    assert result["rate"]["inertia"]["turns_the_loops"] is True
    assert any("Give --effect hub-inertia instead of --rate" in note for note in result["notes"])


def test_a_factor_on_the_level_moves_the_deployments_of_a_sweep(fitted, capsys):
    out = fitted / "swept"
    factor = ["--factor", "actuator.stored_force_N[0]=+-2%"]
    words = [str(fitted / "frequency.toml"), "-o", str(out), *factor, "--json", str(fitted / "swept.json")]
    assert sweep_deployments.main(words) == 0
    result = json.loads((fitted / "swept.json").read_text())
    assert abs(result["coefficients"]["A"]) > 1.0
    assert any("taken against speed" in text for text in result["warnings"])
    shutil.rmtree(out)


def test_the_comparison_says_what_it_assumed(fitted, capsys):
    assert compare_model.main([str(fitted / "frequency.toml"), ONE_STROKE[0]]) == 0
    assert "taken against speed at mid-stroke" in capsys.readouterr().out


@pytest.mark.parametrize("rate", ["frequency", "speed"])
def test_the_explanation_starts_from_either(fitted, tmp_path, monkeypatch, rate):
    few = {name: CATALOGUE[name] for name in ("hub-inertia", "viscous-friction")}
    monkeypatch.setattr("simulate.files.own_effects.catalogue_with", lambda files: few)
    words = [str(fitted / f"{rate}.toml"), *ONE_STROKE, "--budget", "quick", "-o", str(tmp_path / "out"), "--quiet"]
    assert explain_gap.main(words) in (0, 1)
    extended = read_document(tmp_path / "out" / "extended.toml")  # which may hold an effect of its own, drafted
    before = read_model(fitted / f"{rate}.toml").actuator.rate
    assert before is not None
    assert extended["actuator"]["rate"]["stroke_m"] == list(before.stroke_m)
    assert not extended["actuator"]["rate"].get("b_l")
