"""The demonstration as a user runs it, on the shipped data and on the same data with nothing hidden."""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path

import pytest
import tomli_w

from identify.commands.subcommands.demo import main

DATASETS = Path(__file__).resolve().parents[3] / "datasets"


def half_of_the_data(folder):
    """The demonstration's film, the deployment that is held out, and the loops of the long stroke."""
    shutil.copytree(DATASETS / "demo", folder)
    listed = tomllib.loads((folder / "campaign.toml").read_text())["run"]
    kept = [run for run in listed if "deployment-2" not in run["file"] and "-20mm" not in run["file"]]
    assert len(kept) == 5
    (folder / "campaign.toml").write_text(tomli_w.dumps({"run": kept}))
    for file in {run["file"] for run in listed} - {run["file"] for run in kept}:
        (folder / file).unlink()
    return ["--data", str(folder)]


@pytest.mark.calibrate
@pytest.mark.parametrize("whole", [False, True])
def test_the_demonstration_names_the_hidden_effect_from_film_and_loops(tmp_path, capsys, made_by, whole):
    """With all of its data, as `make demo` runs it, and with half of them. The tutorial does the same from Python."""
    assert main(["-o", str(tmp_path), *([] if whole else half_of_the_data(tmp_path / "half"))]) == 0
    result = json.loads((tmp_path / "result.json").read_text())
    hidden = made_by.HIDDEN
    assert result["verdict"] == "named"
    (effect,) = result["effects"]
    assert effect["name"] == hidden.name
    low, high = effect["parameters"]["mass_kg"]["ci95"]
    assert low <= hidden.mass_kg <= high
    assert result["gap"]["before"]["rms_over_noise"] > 10
    assert result["gap"]["after"]["rms_over_noise"] < 1.1
    assert result["gap"]["held_out"]["after"]["rms_over_noise"] < 1.15
    steps = [line.split()[0] for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")]
    assert steps == ["measure", "identify", "simulate", "compare", "explain", "report"]
    assert "://" not in (tmp_path / "report.html").read_text()


@pytest.mark.calibrate
def test_the_same_film_and_loops_without_the_effect_show_no_gap(tmp_path, made_by):
    made_by.make(tmp_path / "data", hidden=None)
    assert main(["-o", str(tmp_path / "out"), "--data", str(tmp_path / "data" / "demo"), "--quiet"]) == 0
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert result["verdict"] == "no-gap", result["sentence"]


@pytest.mark.slow
def test_the_script_makes_the_shipped_tables_to_the_byte(tmp_path, made_by, monkeypatch):
    monkeypatch.setattr(made_by, "render", lambda *motion, **options: None)  # the pictures are no table, and have no chance in common
    made_by.make(tmp_path)
    shipped = [path for path in DATASETS.rglob("*") if path.suffix in (".csv", ".toml")]
    assert len(shipped) == 12
    for path in shipped:
        assert (tmp_path / path.relative_to(DATASETS)).read_bytes() == path.read_bytes(), path.name
