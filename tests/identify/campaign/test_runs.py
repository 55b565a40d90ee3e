"""Lists of runs: what is accepted, and the sentence for what is not."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from identify.campaign.campaign_file import read_list
from identify.campaign.runs import read_campaign
from identify.commands import compare_model, explain_gap
from measure.common.errors import InputError
from measure.readers.column_mapping import ColumnMapping, write_mapping
from measure.tables.loop import Loop, write_loop
from measure.tables.trajectory import Trajectory, write_trajectory
from simulate.files.model_file import read_model
from simulate.loop import loop_force

PROTOTYPE = Path(__file__).resolve().parents[1].joinpath("rig.toml")


@pytest.fixture
def table(tmp_path):
    time = np.arange(40) / 250.0
    write_trajectory(Trajectory(time, {"z_m": 0.252 + 2.0 * time**2}), tmp_path / "one.csv")
    return tmp_path / "one.csv"


def listed(table: Path, text: str) -> Path:
    path = table.parent / "runs.toml"
    path.write_text(text)
    return path


def test_a_run_carries_what_it_changes_about_the_model(table):
    (run,) = read_campaign([listed(table, '[[run]]\nfile = "one.csv"\nmodel.platform.mass_kg = 1.0\n')])
    model = read_model(PROTOTYPE)
    assert run.model(model).platform.mass_kg == 1.0
    assert run.model(model).platform.inertia_kg_m2 == model.platform.inertia_kg_m2


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('[[run]]\nfile = "one.csv"\nhold_uot = true\n', '"hold_uot"; did you mean "hold_out"'),
        ('[[run]]\nfile = "one.csv"\nhold_out = true\n', "every run is held out"),
        ('[[run]]\nfile = "one.csv"\n[[run]]\nfile = "one.csv"\n', "the same measurement"),
        ('[[run]]\nfile = "two.csv"\n', "two.csv: no such file"),
        ("[[run]]\nhold_out = false\n", "give the name of a film or a table"),
        ('runs = "one.csv"\n', 'unknown key "runs"'),
        ("[[run]\n", "is not TOML"),
        ('[[run]]\nfile = "one.csv"\nmapping = 3\n', "name of a mapping file"),
        ('[[run]]\nfile = "one.csv"\nmapping = "rig.toml"\n', "rig.toml: no such file"),
    ],
)
def test_a_list_that_cannot_be_used_is_refused_in_a_sentence(table, text, found):
    with pytest.raises(InputError, match=found.replace("(", r"\(")):
        read_campaign([listed(table, text)])


def test_all_that_is_wrong_in_a_list_and_in_its_files_is_reported_at_once(table):
    (table.parent / "odd.csv").write_text("time_s,z_m\n0.0,much\n0.1,0.3\n")
    rows = '[[run]]\nfile = "one.csv"\nhold_uot = true\n[[run]]\nfile = 3\n'
    with pytest.raises(InputError) as caught:
        read_campaign([listed(table, rows), table.parent / "gone.csv"])
    said = str(caught.value)
    assert all(word in said for word in ("[[run]] one.csv: unknown key", "[[run]] number 2: file is 3", "gone.csv: no such file"))
    with pytest.raises(InputError) as caught:
        read_campaign([listed(table, '[[run]]\nfile = "odd.csv"\n[[run]]\nfile = "gone.csv"\n')])
    assert "odd.csv, line 2" in str(caught.value)
    assert "gone.csv: no such file" in str(caught.value)


def test_a_film_in_a_list_is_refused_with_the_command_that_measures_it(table):
    with pytest.raises(InputError, match=r"film\.avi: is a film.*unspool run.*track-video .*film\.avi --project .*film\.toml -o film\.csv"):
        read_campaign([listed(table, '[[run]]\nfile = "film.avi"\nproject = "film.toml"\n')])


@pytest.mark.parametrize("command", [compare_model, explain_gap])
def test_unusable_input_ends_with_status_2_and_nothing_written(table, tmp_path, capsys, command):
    bad = listed(table, '[[run]]\nfile = "one.csv"\nmodel.platform.mas_kg = 1.0\n')
    out = tmp_path / "out"
    status = command.main([str(PROTOTYPE), str(bad), "--json", str(tmp_path / "r.json"), "-o", str(out.with_suffix(".png"))])
    assert status == 2
    assert 'unknown key "platform.mas_kg"; did you mean "mass_kg"' in capsys.readouterr().err
    assert not (tmp_path / "r.json").exists()
    assert not out.with_suffix(".png").exists()


TIME = np.arange(600) / 200.0
WAVE = 30.0 * np.sin(2 * np.pi * TIME)
FORCE = loop_force(np.array([-0.25, 2.79, -0.3, 2.89, 400.0]), TIME, WAVE / 1e3, 0 * TIME, 0 * TIME, 2.8)
OPTIONS = ["--column", "time=1", "--column", "elongation=3", "--column", "force=2"]
UNITS = ["--unit", "time=ms", "--unit", "elongation=mm", "--unit", "force=kN"]


@pytest.fixture
def laboratory(table):
    """A loop with milliseconds, kilonewtons before millimetres, semicolons and decimal commas; and its mapping file."""
    rows = (f"{1e3 * t:.1f};{f / 1e3:.8f};{u:.5f}".replace(".", ",") for t, f, u in zip(TIME, FORCE, WAVE, strict=True))
    (table.parent / "bench.txt").write_text("\n".join(rows))
    columns, units = {"time": "1", "elongation": "3", "force": "2"}, {"time": "ms", "elongation": "mm", "force": "kN"}
    write_mapping(ColumnMapping(columns, units), table.parent / "rig.toml")
    return table.parent / "bench.txt"


def test_a_run_may_be_a_laboratorys_own_file_with_the_mapping_of_its_rig(laboratory, table):
    text = '[[run]]\nfile = "bench.txt"\nmapping = "rig.toml"\n[[run]]\nfile = "one.csv"\n'
    loop, deployment = read_campaign([listed(table, text)])
    assert isinstance(deployment.table, Trajectory)
    assert isinstance(loop.table, Loop)
    assert loop.table.force_N == pytest.approx(FORCE, abs=1e-5)
    assert loop.table.elongation_m == pytest.approx(WAVE / 1e3, abs=1e-8)


@pytest.mark.parametrize("options", [[*OPTIONS, *UNITS], ["--mapping", "rig.toml"]])
def test_a_laboratorys_own_file_is_compared_beside_a_trajectory(laboratory, table, tmp_path, monkeypatch, options):
    monkeypatch.chdir(tmp_path)
    write_loop(Loop(TIME, WAVE / 1e3, FORCE), tmp_path / "own.csv")
    rmse = {}
    for name, told in (("bench.txt", options), ("own.csv", [])):
        assert compare_model.main([str(PROTOTYPE), name, str(table), *told, "--quiet", "--json", "r.json"]) == 0
        channels = {run["file"]: run["channels"] for run in json.loads((tmp_path / "r.json").read_text())["runs"]}
        assert set(channels["one.csv"]) == {"z_m"}
        rmse[name] = channels[name]["force_N"]["rmse"]
    assert rmse["bench.txt"] == pytest.approx(rmse["own.csv"], rel=1e-3)


def test_a_laboratorys_file_without_its_mapping_is_refused_with_the_options_that_help(laboratory):
    with pytest.raises(InputError, match="--column time=1"):
        read_campaign([laboratory])


@pytest.fixture
def markers(table):
    """Four markers on a platform that rises as in the table, in millimetres with y up; the fourth stands on the ground."""
    head = "PathFileType\t4\t(X/Y/Z)\tm.trc\nDataRate\tUnits\n250\tmm\nFrame#\tTime\tA\t\t\tB\t\t\tC\t\t\tD\t\t\n\t\tX1\n\n"
    rows = []
    for k in range(40):
        z = 252.0 + 2e3 * (k / 250.0) ** 2
        rows.append(f"{k}\t{k / 250.0}\t100\t{z}\t0\t-50\t{z}\t80\t-50\t{z}\t-80\t0\t1\t0")
    (table.parent / "m.trc").write_text(head + "\n".join(rows))
    return table.parent / "m.trc"


def test_a_list_says_which_markers_are_on_the_platform_and_which_axis_is_up(markers):
    text = '[[run]]\nfile = "m.trc"\nup = "y"\nmarkers = ["A", "B", "C"]\n'
    (run,) = read_campaign([listed(markers, text)])
    assert run.label == "m"
    assert isinstance(run.table, Trajectory)
    np.testing.assert_allclose(run.table.channels["z_m"], 2.0 * (np.arange(40) / 250.0) ** 2, atol=1e-12)


def test_options_say_the_same_for_a_file_and_for_a_list_that_leaves_it_open(markers):
    wanted = ColumnMapping(up="y", markers=("A", "B", "C"))
    for path in (markers, listed(markers, '[[run]]\nfile = "m.trc"\n')):
        (run,) = read_campaign([path], wanted)
        assert isinstance(run.table, Trajectory)
        assert np.ptp(run.table.channels["z_m"]) == pytest.approx(2.0 * (39 / 250.0) ** 2)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('up = "w"\n', "up is 'w'; give the axis"),
        ('up = "y"\nmarkers = "A"\n', "markers is 'A'; give the names"),
        ('up = "y"\nmarkers = ["A", "A"]\n', "name each marker once"),
        ('up = "y"\n', "do not move as one body"),
        ("", "--up z or --up y"),
    ],
)
def test_markers_in_a_list_that_cannot_be_used_are_refused_in_a_sentence(markers, text, found):
    with pytest.raises(InputError, match=found):
        read_campaign([listed(markers, f'[[run]]\nfile = "m.trc"\n{text}')])


def test_a_file_of_markers_is_compared_like_the_table_of_the_same_motion(markers, table, tmp_path):
    rmse = {}
    for path, options in ((markers, ["--up", "y", "--markers", "A,B,C"]), (table, [])):
        assert compare_model.main([str(PROTOTYPE), str(path), *options, "--quiet", "--json", str(tmp_path / "r.json")]) == 0
        rmse[path.name] = json.loads((tmp_path / "r.json").read_text())["runs"][0]["channels"]["z_m"]["rmse"]
    assert rmse["m.trc"] == pytest.approx(rmse["one.csv"], rel=0.2)


def test_a_run_that_is_no_table_is_named_by_its_number(tmp_path):
    path = tmp_path / "runs.toml"
    path.write_text('run = [1, "loop.csv"]\n')
    with pytest.raises(InputError) as caught:
        read_campaign([path])
    first, second = str(caught.value).splitlines()
    assert "[[run]] number 1 is 1; give a table" in first
    assert "[[run]] number 2 is 'loop.csv'; give a table" in second


@pytest.mark.parametrize("value", ["1", '"true"', '"yes"', "0.0"])
def test_held_out_is_a_truth_value_and_nothing_like_one(tmp_path, value):
    (tmp_path / "runs.toml").write_text(f'[[run]]\nfile = "a.csv"\nhold_out = {value}\n')
    with pytest.raises(InputError, match="give true or false"):
        read_list(tmp_path / "runs.toml")
