"""simulate-deployment and sweep-deployments as a user calls them."""

import json
import shutil

import numpy as np
import pytest
from scipy.stats import norm

from measure.tables.trajectory import read_trajectory
from simulate.commands import simulate_deployment, sweep_deployments
from simulate.files.model_file import write_model
from simulate.sweeps.sweep import Sweep


@pytest.fixture
def folder(tmp_path, prototype, monkeypatch):
    write_model(prototype, tmp_path / "prototype.toml")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def files(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_deployment_is_written_as_trajectory_legs_figure_and_json(folder, capsys):
    words = ["prototype.toml", "-o", "t.csv", "--legs", "legs.csv", "--energy", "e.csv", "--figure", "f.png", "--json", "r.json"]
    assert simulate_deployment.main(words) == 0
    assert files(folder) == ["e.csv", "f.png", "legs.csv", "prototype.toml", "r.json", "t.csv", "t.csv.provenance.json"]
    trajectory = read_trajectory(folder / "t.csv")
    assert trajectory.channels["z_m"][0] == 0.252
    result = json.loads((folder / "r.json").read_text())
    assert result["time_to_full_height_s"] == pytest.approx(0.505, abs=0.002)
    work = result["energy_J"]
    assert work["kinetic"] == pytest.approx(work["by_legs"] + work["by_stops"] + work["by_weight"] + work["by_effects"], abs=1e-7)
    header = (folder / "legs.csv").read_text().splitlines()[0].split(",")
    legs = np.loadtxt(folder / "legs.csv", delimiter=",", skiprows=1)
    assert legs[0, header.index("elongation_3_m")] == 0
    assert legs[0, header.index("force_3_N")] == 2.987
    assert max(result["step_error"]["whole_run"].values()) < 1e-5
    names = (folder / "e.csv").read_text().splitlines()[0].split(",")
    balance = dict(zip(names, np.loadtxt(folder / "e.csv", delimiter=",", skiprows=1).T, strict=True))
    assert balance["lost_in_stops_J"][-1] == pytest.approx(work["lost_in_stops"])
    assert (folder / "f.png").read_bytes().startswith(b"\x89PNG")
    assert "energy closes" in capsys.readouterr().out


def test_a_rig_is_exported_for_mujoco(folder):
    words = ["--set", "platform.inertia_kg_m2=[0.0016, 0.0016, 0.003]", "--mjcf", "rig.xml", "--quiet"]
    assert simulate_deployment.main(["prototype.toml", *words]) == 0
    assert (folder / "rig.xml").read_text().count("<spatial") == 6


def test_the_same_command_gives_the_same_bytes(folder):
    words = ["prototype.toml", "-o", "t.csv", "--figure", "f.png", "--json", "r.json", "--quiet"]
    simulate_deployment.main(words)
    first = {name: (folder / name).read_bytes() for name in files(folder)}
    simulate_deployment.main(words)
    assert first == {name: (folder / name).read_bytes() for name in files(folder)}


def test_a_diverged_run_ends_with_status_1_its_time_and_empty_cells(folder, capsys):
    words = ["--set", "simulation.step_s=0.004", "--set", "simulation.sample_rate_Hz=250", "--set", "end_stop.stiffness_N_per_m=1e9"]
    assert simulate_deployment.main(["prototype.toml", "-o", "t.csv", "--json", "r.json", *words]) == 1
    assert "diverged at 0.5" in capsys.readouterr().out
    assert json.loads((folder / "r.json").read_text())["diverged_at_s"] > 0.5
    assert np.isnan(read_trajectory(folder / "t.csv").channels["z_m"][-1])


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["nowhere.toml"], "no such file"),
        (["prototype.toml", "--set", "platform.mas_kg=1"], 'did you mean "mass_kg"'),
        (["prototype.toml", "--set", "platform.mass_kg=-1"], "platform.mass_kg"),
        (["prototype.toml", "--set", "platform.mass_kg=heavy"], "a value as in the model file"),
        (["prototype.toml", "--set", "actuator.b_l_N[6]=1"], "not one of its 6 entries"),
        (["prototype.toml", "--set", "effect.hub-inertai.mass_kg=1"], 'did you mean "hub-inertia"'),
        (["prototype.toml", "--figure", "f.gif"], ".png, .svg or .pdf"),
        (["prototype.toml", "-o", "prototype.toml"], "is an input"),
        (["prototype.toml", "--mjcf", "rig.xml", "--set", "platform.inertia_kg_m2=[1, 1, 3]"], "no rigid body is like that"),
        (["prototype.toml", "--outptu", "x"], 'did you mean "--output"'),
        (["prototype.toml", "-o", "nowhere/t.csv"], "does not exist"),
    ],
)
def test_unusable_input_ends_in_one_sentence_status_2_and_no_file(folder, capsys, words, named):
    assert simulate_deployment.main(words) == 2
    message = capsys.readouterr().err
    assert message.startswith("simulate-deployment: error: ")
    assert named in message
    assert files(folder) == ["prototype.toml"]


def test_a_setting_reaches_the_model_by_its_name_in_the_file(folder):
    words = ["--set", "actuator.b_l_N[0]=2.89", "--set", "effect.gravity-imbalance.force_N=0.1", "--set", "simulation.duration_s=0.2"]
    assert simulate_deployment.main(["prototype.toml", "--json", "r.json", "--quiet", *words]) == 0
    result = json.loads((folder / "r.json").read_text())
    assert result["duration_s"] == 0.2
    assert abs(result["theta_z_deg"]) > 0.1


@pytest.mark.slow
def test_a_sweep_gives_indices_of_any_keys_and_the_probability_of_a_rare_failure(folder, capsys):
    pytest.importorskip("SALib")
    words = ["prototype.toml", "--set", "simulation.duration_s=0.5", "--set", "simulation.sample_rate_Hz=200", "--indices", "sobol"]
    words += ["--factor", "actuator.stored_force_N[0]=sigma:1%", "--factor", "geometry.base_radius_m=+-1%", "--runs", "64"]
    assert sweep_deployments.main([*words, "--rare", "400", "--failure-deg", "2.5", "--json", "s.json", "-o", "out"]) == 0
    result = json.loads((folder / "s.json").read_text())
    assert result["runs"] == 64
    total = result["indices"]["indices"]["total"]
    assert total["A"]["value"] > 0.7 > 0.1 > total["B"]["value"]  # a ring of joints that stays a ring turns nothing
    assert [step["runs"] for step in result["indices"]["convergence"]] == [32, 64]
    assert result["failed_interval_percent"] is None
    # linear in one normal force: both sides beyond 2.5 deg
    expected = 2.0 * norm.sf(2.5 / abs(result["coefficients"]["A"]))
    assert 0.4 < result["subset_simulation"]["probability"] / expected < 2.5
    assert "indices.png" in files(folder / "out")
    said = capsys.readouterr().out
    assert "A actuator.stored_force_N[0]: " in said
    assert "probability beyond 2.5 deg" in said
    assert sweep_deployments.main([*words, "--design", "random"]) == 2
    assert "both choose the runs" in capsys.readouterr().err


def test_a_sweep_writes_what_the_contract_says(folder, capsys):
    words = [
        "prototype.toml",
        "--factor",
        "actuator.stored_force_N[0]=+-10%",
        "--factor",
        "actuator.stored_force_N[1]=+-0.279",
        "--json",
        "s.json",
        "-o",
        "out",
        "--page",
        "sweep.html",
    ]
    assert sweep_deployments.main(words) == 0
    result = json.loads((folder / "s.json").read_text())
    assert result["runs"] == 4
    assert result["diverged"] == 0
    stored_force = {"letter": "A", "key": "actuator.stored_force_N[0]", "low": pytest.approx(2.511), "high": pytest.approx(3.069)}
    assert result["factors"][0] == stored_force
    assert result["coefficients"]["A"] == pytest.approx(-result["coefficients"]["B"], rel=0.01)
    assert result["formula"].startswith("theta_z = ")
    assert result["variability_percent"]["A"] == pytest.approx(50, abs=1)
    assert set(result) >= {"failed_percent", "wall_s", "tolerance", "formula", "provenance"}
    assert files(folder / "out") == ["coefficients.csv", "responses.csv", "responses.csv.provenance.json", "sweep.png"]
    page = (folder / "sweep.html").read_text()
    assert f"{result['failed_percent']:.3g} % of 4 runs turn beyond 30 deg" in page
    assert "actuator.stored_force_N[1]" in page
    assert "://" not in page
    assert "theta_z = " in capsys.readouterr().out


def test_a_sampled_sweep_repeats_itself_by_its_seed(folder):
    words = ["prototype.toml", "--design", "random", "--runs", "40", "--set", "simulation.duration_s=0.1", "--quiet", "-o"]
    for name, more in (("a", ["--seed", "3"]), ("b", ["--seed", "3", "--workers", "1"]), ("c", ["--seed", "4"])):
        assert sweep_deployments.main([*words, name, *more]) == 0
    read = {name: (folder / name / "responses.csv").read_bytes() for name in "abc"}
    assert read["a"] == read["b"]
    assert read["a"] != read["c"]


def test_an_interrupted_sweep_goes_on_and_ends_in_the_same_bytes(folder, monkeypatch, capsys):
    words = ["prototype.toml", "--design", "random", "--runs", "1200", "--set", "simulation.duration_s=0.05", "-o", "out", "--quiet"]
    assert sweep_deployments.main(words) == 0
    whole = {name: (folder / "out" / name).read_bytes() for name in ("responses.csv", "coefficients.csv", "sweep.png")}
    done = Sweep.responses

    def failing(sweep, first, last):
        if first >= 1024:
            raise KeyboardInterrupt
        return done(sweep, first, last)

    monkeypatch.setattr(Sweep, "responses", failing)
    assert sweep_deployments.main([*words[:-2], "again", "--quiet"]) == 130
    assert files(folder / "again.part") == ["000000000.npy", "000000512.npy", "key"]
    assert not (folder / "again").exists()
    monkeypatch.setattr(Sweep, "responses", done)
    other = [*words[:-2], "again", "--quiet", "--resume", "--seed", "9"]
    assert sweep_deployments.main(other) == 2
    assert "another model, design or version" in capsys.readouterr().err
    calls = []
    monkeypatch.setattr(Sweep, "responses", lambda sweep, first, last: calls.append(first) or done(sweep, first, last))
    assert sweep_deployments.main([*words[:-2], "again", "--quiet", "--resume"]) == 0
    assert 512 not in calls
    assert {name: (folder / "again" / name).read_bytes() for name in whole} == whole
    assert not (folder / "again.part").exists()


def test_a_folder_of_the_user_with_the_name_of_the_pieces_is_not_touched(folder, capsys):
    words = ["prototype.toml", "-o", "sw", "--factor", "platform.mass_kg=+-1%", "--set", "simulation.duration_s=0.02"]
    for name, content in (("notes.txt", "mine"), ("key", "mine"), ("key", "0" * 64)):
        (folder / "sw.part" / "inner").mkdir(parents=True, exist_ok=True)
        (folder / "sw.part" / name).write_text(content)
        for more in ([], ["--resume"]):
            assert sweep_deployments.main([*words, *more]) == 2
            assert "is not the work of a sweep alone" in capsys.readouterr().err
            assert (folder / "sw.part" / name).read_text() == content
        shutil.rmtree(folder / "sw.part")
    (folder / "elsewhere").mkdir()
    (folder / "elsewhere" / "key").write_text("0" * 64)
    (folder / "sw.part").symlink_to("elsewhere")
    assert sweep_deployments.main(words) == 2
    assert (folder / "elsewhere" / "key").exists()


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["prototype.toml", "--factor", "platform.mas_kg=+-10%"], "no number of the model"),
        (["prototype.toml", "--response", "theta_deg"], 'did you mean "theta_z_deg"'),
        (["prototype.toml", "--design", "sobol", "--runs", "100"], "power of two"),
        (["prototype.toml", "--design", "best"], "invalid choice"),
        (["prototype.toml", "--workers", "0"], "at least 1"),
        (["prototype.toml", "--set", "simulation.step_s=1e-10"], "steps of"),
        (["prototype.toml", "-o", "prototype.toml"], "is a file"),
        (["prototype.toml", "-o", "nowhere/sweep"], "does not exist"),
    ],
)
def test_an_unusable_sweep_ends_in_one_sentence_status_2_and_no_file(folder, capsys, words, named):
    assert sweep_deployments.main(words) == 2
    assert named in capsys.readouterr().err
    assert files(folder) == ["prototype.toml"]
