"""What a user wants of the parameters of a fit: held, bounded, begun elsewhere; and what cannot be wanted."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from identify.commands import compare_model, explain_gap, fit_actuator

DEMO = Path(__file__).resolve().parents[3] / "datasets" / "demo"
LOOPS = [str(path) for path in sorted((DEMO / "loops").glob("*20mm.csv"))]
MODEL = str(DEMO / "rig.toml")


def fitted(tmp_path, *options):
    out = tmp_path / "r.json"
    fit_actuator.main([*LOOPS, "--effect", "hub-inertia", "--quiet", "--json", str(out), *options])
    return json.loads(out.read_text())


def test_a_mass_is_held_and_beta_kept_within_bounds(tmp_path):
    found = fitted(tmp_path, "--fix", "hub-inertia.mass_kg=0.01", "--bound", "beta_per_m=..350")
    held = found["parameters"]["hub-inertia.mass_kg"]
    assert held == {"value": pytest.approx(0.01), "stderr": 0.0, "ci95": pytest.approx([0.01, 0.01]), "verdict": "ok"}
    assert found["at_bound"] == {"beta_per_m": "upper bound 350"}
    assert found["verdict"] == "at-bound"
    assert "upper bound 350" in found["reason"]


def test_a_value_that_is_not_given_is_that_of_the_model(tmp_path):
    model = tmp_path / "model.toml"
    fit_actuator.main([*LOOPS, "--effect", "hub-inertia", "--quiet", "-o", str(model)])
    copy = tmp_path / "copy.toml"
    found = fitted(tmp_path, "--model", str(model), "-o", str(copy), "--fix", "beta_per_m")
    assert found["parameters"]["beta_per_m"]["stderr"] == 0.0


WRONG = {
    "an unknown name": (["--fix", "beta_per_n=400"], 'did you mean "beta_per_m"'),
    "no value and no model": (["--fix", "beta_per_m"], "--fix beta_per_m=VALUE"),
    "no number": (["--start", "b_l_N=two"], "give a number"),
    "no pair": (["--bound", "beta_per_m=3"], "LOW..HIGH"),
    "bounds the other way round": (["--bound", "beta_per_m=9..3"], "not below"),
    "a negative mass": (["--fix", "hub-inertia.mass_kg=-1"], "between 0 and"),
    "two values": (["--fix", "b_l_N=2", "--start", "b_l_N=3"], "given a value twice"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_wanted_is_refused(case, capsys):
    options, sentence = WRONG[case]
    assert fit_actuator.main([*LOOPS, "--effect", "hub-inertia", "--quiet", *options]) == 2
    assert sentence in capsys.readouterr().err


def test_all_that_is_wrong_is_said_at_once(capsys):
    assert fit_actuator.main([*LOOPS, "--quiet", "--fix", "mass=1", "--bound", "b_l_N=2..x", "--start", "beta_per_m=-4"]) == 2
    said = capsys.readouterr().err
    assert all(part in said for part in ("--fix mass=1", "--bound b_l_N=2..x", "--start beta_per_m=-4"))


@pytest.mark.parametrize("command", [compare_model, explain_gap])
def test_the_other_commands_know_the_same_names(command, tmp_path, capsys):
    output = tmp_path / ("x.png" if command is compare_model else "x")
    assert command.main([MODEL, *LOOPS, "-o", str(output), "--quiet", "--fix", "beta_per_n=400"]) == 2
    assert 'did you mean "beta_per_m"' in capsys.readouterr().err


def test_a_model_is_compared_with_another_value_of_its_own(tmp_path):
    rms = []
    for options in ([], ["--fix", "beta_per_m=50"]):
        out = tmp_path / "c.json"
        assert compare_model.main([MODEL, *LOOPS, "--quiet", "--json", str(out), *options]) == 0
        rms.append(json.loads(out.read_text())["rms_over_noise"])
    assert rms[1] > 1.2 * rms[0]
