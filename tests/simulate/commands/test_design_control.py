"""design-control as a user calls it."""

import json
from dataclasses import replace

import pytest

from simulate.commands import design_control
from simulate.deployment.deploy import deploy
from simulate.files.model_file import read_model, write_model


@pytest.fixture
def folder(tmp_path, prototype, monkeypatch):
    write_model(prototype, tmp_path / "rig.toml")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_what_cannot_be_asked_is_refused_and_nothing_is_written(folder, capsys):
    for words in (["--angle", "30", "--angle", "10", "--probability", "0.9"], ["--law", "no-law"], ["--probability", "0.999999"]):
        assert design_control.main(["rig.toml", *words]) == 2
        assert capsys.readouterr().err.startswith("design-control: error: ")
    assert design_control.main(["rig.toml", "-o", "rig.toml"]) == 2
    assert [path.name for path in folder.iterdir()] == ["rig.toml"]


@pytest.mark.calibrate
def test_a_model_with_its_controller_the_result_and_the_page_are_written(folder, capsys):
    words = [
        "rig.toml",
        "--set",
        "simulation.duration_s=0.7",
        "--probability",
        "0.9",
        "--draws",
        "64",
        "-o",
        "out.toml",
        "--json",
        "out.json",
        "--page",
        "out.html",
    ]
    assert design_control.main(words) == 0
    assert sorted(path.name for path in folder.iterdir()) == ["out.html", "out.json", "out.toml", "rig.toml"]
    result, model = json.loads((folder / "out.json").read_text()), read_model(folder / "out.toml")
    assert result["verdict"] == "certified"
    assert model.controller is not None
    assert model.controller.table() == {key: value for key, value in result["controller"].items() if value is not None}
    assert [row["stops"] for row in result["certificate"]] == ["halved", "as given", "doubled"]
    assert {row["law"] for row in result["other_laws"]} >= {"profile", "one-way", "eddy-damper", "mechanical-link"}
    page = (folder / "out.html").read_text()
    assert "without control" in page
    assert "http" not in page.replace("http-equiv", "")
    said = capsys.readouterr().out
    assert "certified for 0.9" in said
    askew = replace(model, actuator=model.actuator.shifted((0.28, -0.28, 0.28, -0.28, 0.28, -0.28)))
    free, held = (abs(deploy(rig).summary["theta_z_deg"]) for rig in (replace(askew, controller=None), askew))
    assert held < 30.0 < free
