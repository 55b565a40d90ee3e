"""design-deployment as a user calls it."""

import json

import pytest

from simulate.commands import design_deployment
from simulate.files.model_file import read_model, write_model
from simulate.model.model import value_of


@pytest.fixture
def folder(tmp_path, prototype, monkeypatch):
    write_model(prototype, tmp_path / "rig.toml")
    monkeypatch.chdir(tmp_path)
    return tmp_path


DAMPING = ["--free", "end_stop.damping_N_s_per_m=5..80"]


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--minimise", "worst:theta_z_deg"], "nothing is free"),
        ([*DAMPING, "--minimise", "worst:theta"], "no response is named"),
        ([*DAMPING, "--minimise", "best:theta_z_deg"], "is no measure"),
        ([*DAMPING, "--minimise", "robust:theta_z_deg"], "give --factor"),
        ([*DAMPING, "--minimise", "nominal:theta_z_deg", "--subject-to", "stop force below 3"], "--subject-to"),
        (["--free", "end_stop.damping=5..80", "--minimise", "nominal:theta_z_deg"], "no number of the model"),
        (["--free", "end_stop.damping_N_s_per_m=80..5", "--minimise", "nominal:theta_z_deg"], "LOW below HIGH"),
        ([*DAMPING, "--minimise", "nominal:theta_z_deg", "--cost", "a"], "--cost"),
        ([*DAMPING, "--minimise", "nominal:theta_z_deg", "-o", "rig.toml"], "rig.toml"),
    ],
)
def test_what_cannot_be_asked_is_refused_and_nothing_is_written(folder, capsys, words, named):
    assert design_deployment.main(["rig.toml", *words]) == 2
    said = capsys.readouterr().err
    assert said.startswith("design-deployment: error: ")
    assert named in said
    assert [path.name for path in folder.iterdir()] == ["rig.toml"]


def test_a_softer_rebound_is_found_within_the_force_of_the_stops_and_the_same_seed_gives_the_same_bytes(folder, capsys):
    words = ["rig.toml", "--set", "simulation.duration_s=0.8", "--set", "actuator.stored_force_N[0]=2.82", *DAMPING]
    words += ["--minimise", "nominal:theta_z_deg", "--subject-to", "worst:stop_force_N<70", "--evaluations", "24", "-o", "out.toml"]
    assert design_deployment.main([*words, "--json", "out.json"]) == 0
    result = json.loads((folder / "out.json").read_text())
    assert result["verdict"] == "found"
    goal, limit, free = result["objective"], result["limits"][0], result["free"][0]
    assert goal["fresh"] <= goal["before"]
    assert limit["kept"]
    assert limit["fresh"] < 70.0
    assert value_of(read_model(folder / "out.toml"), "end_stop.damping_N_s_per_m") == free["value"]
    assert free["key"] in capsys.readouterr().out
    first = (folder / "out.toml").read_bytes()
    assert design_deployment.main([*words, "--quiet"]) == 0
    assert (folder / "out.toml").read_bytes().split(b"[provenance]")[0] == first.split(b"[provenance]")[0]


def test_a_limit_that_nothing_keeps_ends_in_a_bad_verdict_and_no_model(folder, capsys):
    words = ["rig.toml", "--set", "simulation.duration_s=0.7", *DAMPING, "--minimise", "nominal:theta_z_deg"]
    assert design_deployment.main([*words, "--subject-to", "worst:stop_force_N<1", "--evaluations", "16", "--json", "out.json"]) == 1
    assert "no candidate keeps all limits" in capsys.readouterr().out
    assert not (folder / "designed.toml").exists()
    assert json.loads((folder / "out.json").read_text())["verdict"] == "none-feasible"
