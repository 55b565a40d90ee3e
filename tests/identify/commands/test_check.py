"""`unspool check` reports all that is wrong in files of every kind, and what it understood of the others."""

from __future__ import annotations

import json

import pytest

from identify.commands.subcommands.shipped import shipped
from identify.commands.unspool import main

DEMO = shipped("demo")


def checked(capsys, *files, options=()):
    status = main(["check", *map(str, files), *options])
    return status, capsys.readouterr().out


def test_files_of_every_kind_are_recognised(capsys, tmp_path):
    assert main(["init", str(tmp_path / "rig"), "--quiet"]) == 0
    loop, film = DEMO / "loops" / "loop-1Hz-20mm.csv", DEMO / "film.avi"
    files = [DEMO / "rig.toml", DEMO / "film.toml", tmp_path / "rig" / "bench.toml", loop, DEMO / "deployment-2.csv", film]
    status, said = checked(capsys, *files, options=["--json", str(tmp_path / "found.json")])
    assert status == 0
    found = json.loads((tmp_path / "found.json").read_text())
    assert [row["kind"] for row in found["files"]] == ["model", "film project", "columns of a bench", "loop", "trajectory", "film"]
    assert "1 Hz, amplitude 10 mm" in said
    assert "stroke of the legs 265.6" in said
    assert "150 frames, 304 x 1024 px" in said


def test_all_that_is_wrong_in_all_files_is_reported_at_once(capsys, tmp_path):
    model = (DEMO / "rig.toml").read_text().replace("mass_kg = 0.8", "mass_kg = -0.8").replace("b_u_N", "b_v_N")
    (tmp_path / "model.toml").write_text(model)
    (tmp_path / "film.toml").write_text("[film]\nfsp = 250.0\n[scale]\nmm_per_px = 0.0\n")
    (tmp_path / "loop.csv").write_text("time_s,elongation_m,force_N\n0.0,0.1,much\n")
    (tmp_path / "runs.toml").write_text('[[run]]\nfile = "gone.csv"\n[[run]]\nfile = "loop.csv"\nmapping = "away.toml"\n')
    status, said = checked(capsys, *(tmp_path / name for name in ("model.toml", "film.toml", "loop.csv", "runs.toml")))
    assert status == 2
    for word in ("platform.mass_kg", '"b_u_N"?', '"fps"?', "scale.mm_per_px", "much", "gone.csv: no such", "away.toml: no such"):
        assert word in said
    assert "0 of 4 files can be used" in said


def test_what_a_run_changes_is_checked_against_the_model_of_the_list(capsys, tmp_path):
    (tmp_path / "model.toml").write_text((DEMO / "rig.toml").read_text())
    (tmp_path / "one.csv").write_text((DEMO / "deployment-2.csv").read_text())
    text = 'model = "model.toml"\n[[run]]\nfile = "one.csv"\nmodel.geometry.stowed_hight_m = 0.3\n'
    (tmp_path / "runs.toml").write_text(text)
    status, said = checked(capsys, tmp_path / "runs.toml")
    assert status == 2
    assert 'did you mean "stowed_height_m"?' in said


ROWS = "".join(f"{k / 100},{0.25 + k / 1000},1e-300\n" for k in range(50))
TABLES = {
    "few.csv": ("time_s,z_m\n0,0.25\n0.1,0.3\n0.2,0.4\n", "a deployment needs at least 5"),
    "sure.csv": (
        "time_s,z_m,sigma_z_m\n" + "".join(f"{k / 100},{0.25 + k / 1000},1e-300\n" for k in range(50)),
        "nothing is measured better",
    ),
}
WITH_A_MODEL = {
    "ms.csv": ("time_s,z_m\n" + "".join(f"{4 * k},{0.25 + k / 400}\n" for k in range(150)), "If time_s is in ms, divide it by 1000"),
    "mm.csv": ("time_s,z_m\n" + "".join(f"{k / 250},{250 + k}\n" for k in range(150)), "If it is in mm, divide it by 1000"),
}


@pytest.mark.parametrize("name", [*TABLES, *WITH_A_MODEL])
def test_a_deployment_that_would_be_refused_is_not_called_usable(capsys, tmp_path, name):
    """By what no film shows, and beside a model by what the model never does; a list is checked with the model that it names."""
    text, words = {**TABLES, **WITH_A_MODEL}[name]
    (tmp_path / name).write_text(text)
    status, said = checked(capsys, tmp_path / name)
    assert (status, words in said) == ((2, True) if name in TABLES else (0, False))
    (tmp_path / "model.toml").write_text((DEMO / "rig.toml").read_text())
    status, said = checked(capsys, tmp_path / "model.toml", tmp_path / name)
    assert status == 2
    assert words in said
    (tmp_path / "runs.toml").write_text(f'model = "model.toml"\n[[run]]\nfile = "{name}"\n')
    status, said = checked(capsys, tmp_path / "runs.toml")
    assert status == 2
    assert words in said


def test_a_change_that_no_rig_has_is_refused_beside_its_model(capsys, tmp_path):
    (tmp_path / "one.csv").write_bytes((DEMO / "deployment-2.csv").read_bytes())
    (tmp_path / "runs.toml").write_text('[[run]]\nfile = "one.csv"\n[run.model.nuisance]\nrelease_position_m = 1e300\n')
    assert "1e+300 (unchecked: no model is named)" in checked(capsys, tmp_path / "runs.toml")[1]
    status, said = checked(capsys, DEMO / "rig.toml", tmp_path / "runs.toml")
    assert status == 2
    assert "nuisance.release_position_m: 1e+300 is not between" in said


def test_a_model_that_takes_more_steps_than_anybody_waits_for_is_not_called_usable(capsys, tmp_path):
    text = (DEMO / "rig.toml").read_text()
    (tmp_path / "stiff.toml").write_text(text.replace("stiffness_N_per_m = 4000.0", "stiffness_N_per_m = 1e12"))
    status, said = checked(capsys, tmp_path / "stiff.toml")
    assert status == 2
    assert "Change end_stop.stiffness_N_per_m" in said


def test_a_file_of_markers_is_a_trajectory_once_its_axes_are_known(capsys, tmp_path):
    rows = "\n".join(f"{k}\t{k / 100}\t{k}\t0\t{2 * k}" for k in range(1, 10))
    head = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tUnits\n100\tmm\nFrame#\tTime\tA\t\t\n\t\tX1\tY1\tZ1\n\n"
    (tmp_path / "a.trc").write_text(head + rows)
    status, said = checked(capsys, tmp_path / "a.trc")
    assert status == 2
    assert "--up z" in said
    status, said = checked(capsys, tmp_path / "a.trc", options=["--up", "z"])
    assert status == 0
    assert "z_m 0 to 0.016, seen in 9 rows" in said
    (tmp_path / "lab.toml").write_text('up = "z"\nmarkers = ["A"]\n')
    status, said = checked(capsys, tmp_path / "lab.toml")
    assert status == 0
    assert "up is z of the file; markers A" in said


NEXT = {"rig.toml": "simulate-deployment", "film.toml": "track-video", "film.avi": "track-video"}


@pytest.mark.parametrize(("name", "command"), NEXT.items())
def test_it_ends_with_the_next_command(capsys, name, command):
    status, said = checked(capsys, DEMO / name)
    assert status == 0
    assert said.splitlines()[-1].startswith(f"next     {command} ")


@pytest.mark.parametrize("option", ["-o", "--json"])
@pytest.mark.parametrize("taken", ["runs.toml", "loop.csv", "same-loop.csv", "bench.toml", "mine.py"])
def test_nothing_that_is_read_is_written_over(capsys, tmp_path, option, taken):
    """Neither a file that is named, nor one that a list of runs names, nor one of them through a link."""
    (tmp_path / "runs.toml").write_text('[[run]]\nfile = "loop.csv"\n')
    (tmp_path / "loop.csv").write_bytes((DEMO / "loops" / "loop-1Hz-20mm.csv").read_bytes())
    (tmp_path / "same-loop.csv").symlink_to(tmp_path / "loop.csv")
    (tmp_path / "bench.toml").write_text('[units]\nforce = "N"\n')
    (tmp_path / "mine.py").write_text("")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    words = ["--mapping", str(tmp_path / "bench.toml"), "--effects", str(tmp_path / "mine.py"), option, str(tmp_path / taken)]
    assert main(["check", str(tmp_path / "runs.toml"), *words]) == 2
    assert "inputs are never written" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
