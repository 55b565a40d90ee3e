"""The command, on made loops and on loops from real machines."""

import json
from pathlib import Path

import numpy as np
import pytest

from identify.commands.fit_actuator import main
from measure import Loop, read_loop, write_loop
from measure.readers.column_mapping import read_mapping
from measure.tables.csv_cells import write_columns
from simulate.files.model_file import read_model
from simulate.loop import loop_force

REAL = Path("../shared/real/loops")
LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
needs_real = pytest.mark.skipif(not REAL.is_dir(), reason="../shared/real is absent")


@pytest.fixture
def loop_files(tmp_path):
    rng = np.random.default_rng(5)
    paths = []
    for frequency in (0.5, 1.0, 3.0):
        n = int(3.2 / frequency * 300)
        t = np.arange(n * 10) / 3000.0
        w = 2 * np.pi * frequency
        u = 0.25 + 0.05 * np.sin(w * t)
        force = loop_force(LINES, t, u, 0.05 * w * np.cos(w * t), -0.05 * w**2 * np.sin(w * t), 2.75)
        paths.append(tmp_path / f"loop_{frequency}.csv")
        write_loop(Loop(t[::10], u[::10], force[::10] + 2e-3 * rng.standard_normal(n)), paths[-1])
    return [str(path) for path in paths]


def test_loops_become_a_model_file_that_gives_back_the_truth(loop_files, tmp_path, capsys):
    outputs = [tmp_path / name for name in ("actuator.toml", "result.json", "page.png", "page.html")]
    status = main([*loop_files, "-o", str(outputs[0]), "--json", str(outputs[1]), "--figure", str(outputs[2]), "--page", str(outputs[3])])
    assert status == 0
    actuator = read_model(outputs[0]).actuator
    assert actuator.b_l_N == pytest.approx(2.79, abs=0.01)
    assert actuator.beta_per_m == pytest.approx(400.0, rel=0.1)
    assert actuator.covariance is not None
    result = json.loads(outputs[1].read_text())
    assert result["verdict"] == "ok"
    assert [round(row["frequency_Hz"], 2) for row in result["loops"]] == [0.5, 1.0, 3.0]
    assert all(abs(row["area_error_percent"]) < 2.0 for row in result["loops"])
    assert outputs[2].stat().st_size > 10_000
    page = outputs[3].read_text()
    assert f"The law meets 3 loops to {result['pooled_nrmse_percent']:.2g} % of the range of all forces" in page
    assert "loop_0.5.csv: 0.5 Hz, stroke 100 mm" in page
    assert "://" not in page
    assert "verdict  ok" in capsys.readouterr().out


def test_figures_stand_alone_in_a_folder(loop_files, tmp_path):
    folder = tmp_path / "figures"
    assert main([loop_files[1], "--figures", str(folder), "--no-suggest", "--quiet"]) == 0
    kinds = {path.suffix for path in folder.iterdir()}
    names = {path.stem for path in folder.iterdir()}
    assert kinds == {".png", ".pdf"}
    assert names == {"01-fit", "02-each-loop", "04-residual", "06-friction", "07-level", "08-beta", "09-correlations"}


def test_same_input_gives_the_same_bytes(loop_files, tmp_path):
    first, second = tmp_path / "one", tmp_path / "two"
    for folder in (first, second):
        folder.mkdir()
        main([*loop_files, "--quiet", "--json", str(folder / "r.json")])
    assert json.loads((first / "r.json").read_text())["parameters"] == json.loads((second / "r.json").read_text())["parameters"]


def test_quiet_says_nothing(loop_files, capsys):
    assert main([*loop_files, "--quiet"]) == 0
    assert capsys.readouterr().out == ""


def test_the_same_file_twice_counts_once_and_is_said(loop_files, tmp_path, capsys):
    twin = tmp_path / "twin.csv"
    twin.write_bytes(Path(loop_files[0]).read_bytes())
    assert main([loop_files[0], str(twin), "--no-suggest"]) == 0
    assert "is the same file as" in capsys.readouterr().out


def test_a_preview_fits_nothing(loop_files, capsys):
    assert main([loop_files[0], "--preview"]) == 0
    out = capsys.readouterr().out
    assert "unit m = 1 m" in out
    assert "verdict" not in out


@pytest.mark.parametrize(("unit", "kept"), [("mm", "mm*-1"), ("mm*-1", "mm*1")])
def test_a_sign_that_was_turned_stands_in_the_saved_mapping(loop_files, tmp_path, capsys, unit, kept):
    loop, rig, clockwise = read_loop(Path(loop_files[1])), tmp_path / "rig.toml", tmp_path / "clockwise.csv"
    travel = -1e3 * loop.elongation_m * (-1 if unit == "mm*-1" else 1)
    write_columns({"time_s": loop.time_s, "travel": travel, "force_N": loop.force_N}, clockwise)
    given = [str(clockwise), "--column", "elongation=travel", "--unit", f"elongation={unit}", "--no-suggest"]
    assert main([*given, "--save-mapping", str(rig)]) == 0
    assert "counted the other way round" in capsys.readouterr().out
    assert read_mapping(rig).units["elongation"] == kept
    assert main([str(clockwise), "--mapping", str(rig), "--no-suggest"]) == 0
    assert "counted the other way round" not in capsys.readouterr().out


def test_an_actuator_can_be_put_into_a_model(loop_files, tmp_path):
    base, copy = tmp_path / "base.toml", tmp_path / "copy.toml"
    assert main([*loop_files, "--quiet", "--no-suggest", "-o", str(base)]) == 0
    text = base.read_text() + "\n[platform]\nmass_kg = 1.25\n"
    base.write_text(text)
    assert main([*loop_files, "--quiet", "--no-suggest", "--model", str(base), "-o", str(copy)]) == 0
    assert read_model(copy).platform.mass_kg == 1.25


def test_polynomials_in_the_speed_stand_in_the_model_file(loop_files, tmp_path, capsys):
    out, result = tmp_path / "rate.toml", tmp_path / "rate.json"
    assert main([*loop_files, "--rate", "speed", "--rate-order", "1", "--no-suggest", "-o", str(out), "--quiet"]) == 0
    rate = read_model(out).actuator.rate
    assert rate is not None
    assert rate.abscissa == "speed_m_per_s"
    assert rate.b_l[0] == pytest.approx(2.79, abs=0.01)
    assert main([*loop_files, "--rate", "frequency", "--no-suggest", "--json", str(result)]) == 0
    assert "order 0 is taken" in capsys.readouterr().out
    assert set(json.loads(result.read_text())["rate"]["left_out_nrmse_percent"]) == {"0", "1"}


def test_profile_and_bootstrap_stand_in_the_result(loop_files, tmp_path):
    out = tmp_path / "r.json"
    assert main([*loop_files, "--profile", "--bootstrap", "4", "--seed", "3", "--no-suggest", "--json", str(out), "--quiet"]) == 0
    result = json.loads(out.read_text())
    low, high = result["beta_profile"]["ci95"]
    assert low < 400.0 < high
    assert set(result["bootstrap"]["ci95"]) == set(result["parameters"])
    assert result["provenance"]["seed"] == 3


def test_a_frequency_that_the_name_claims_and_the_signal_denies_is_said(loop_files, tmp_path, capsys):
    wrong = tmp_path / "run_2Hz.csv"
    wrong.write_bytes(Path(loop_files[1]).read_bytes())
    main([str(wrong), "--no-suggest"])
    assert "its name says 2 Hz, the signal 1 Hz" in capsys.readouterr().out


REFUSED = {
    "missing file": (["nowhere.csv"], "no such file"),
    "unknown effect": (["LOOP", "--effect", "hub-inertai"], 'did you mean "hub-inertia"'),
    "an effect no loop shows": (["LOOP", "--effect", "scale-error"], "no loop shows it"),
    "an unknown option": (["LOOP", "--efect", "x"], '"--effect"'),
    "a figure of no kind": (["LOOP", "--figure", "x.docx"], "figures are"),
    "no folder for figures": (["LOOP", "--figures", "nowhere/figures"], "does not exist"),
    "a model without a copy": (["LOOP", "--model", "x.toml"], "--output"),
    "no such folder": (["LOOP", "--json", "nowhere/x.json"], "does not exist"),
    "a wrong column": (["LOOP", "--column", "force=Load"], 'no column "Load"'),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_ends_in_one_sentence_and_writes_nothing(case, loop_files, tmp_path, capsys):
    words, sentence = REFUSED[case]
    before = sorted(tmp_path.iterdir())
    status = main(
        [loop_files[0] if word == "LOOP" else word for word in words] + ["-o", str(tmp_path / "out.toml")] * ("--model" not in words)
    )
    assert status == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("fit-actuator: error: ")
    assert sentence in captured.err
    assert sorted(tmp_path.iterdir()) == before


@needs_real
@pytest.mark.slow
def test_ten_runs_of_a_real_damper_give_the_published_friction(tmp_path):
    files = [str(path) for path in sorted((REAL / "mr-damper-0V").glob("*.csv"))]
    out = tmp_path / "r.json"
    assert main([*files, "--unit", "elongation=mm", "--effect", "viscous-friction", "--no-suggest", "--json", str(out), "--quiet"]) == 0
    result = json.loads(out.read_text())
    assert result["pooled_nrmse_percent"] < 2.8
    assert result["parameters"]["viscous-friction.damping_N_s_per_m"]["value"] == pytest.approx(802.0, rel=0.15)
    assert result["half_height_N"] == pytest.approx(50.24, rel=0.10)
    assert result["frequency_amplitude_correlation"] < -0.98


@needs_real
@pytest.mark.slow
def test_without_viscous_friction_the_dampers_residual_points_at_speed(tmp_path):
    files = [str(path) for path in sorted((REAL / "mr-damper-0V").glob("*.csv"))][::3]
    out = tmp_path / "r.json"
    main([*files, "--unit", "elongation=mm", "--no-suggest", "--json", str(out), "--quiet"])
    result = json.loads(out.read_text())
    assert 6.0 < result["pooled_nrmse_percent"] < 8.0
    assert result["residual_depends_on"].startswith("speed")


SEAL = [
    word
    for key, place, unit in (("time", 1, "ms"), ("elongation", 5, "mm"), ("force", 7, "N"))
    for word in ("--column", f"{key}={place}", "--unit", f"{key}={unit}")
]


@needs_real
@pytest.mark.parametrize("every", [2, pytest.param(1, marks=pytest.mark.calibrate)])
def test_raw_files_of_a_real_seal_end_in_a_fit_and_a_verdict(tmp_path, every):
    errors = []
    for file in sorted((REAL / "pneumatic-seal").glob("*.csv"))[::every]:
        out = tmp_path / f"{file.stem}.json"
        status = main([str(file), *SEAL, "--no-suggest", "--json", str(out), "--quiet"])
        result = json.loads(out.read_text())
        assert status == (0 if result["verdict"] in ("ok", "approximate") else 1)
        assert result["reason"]
        errors.append(result["pooled_nrmse_percent"])
    assert len(errors) == 8 // every
    assert np.median(errors) < 4.0
    assert max(errors) < 4.5


@needs_real
def test_the_supply_pressure_is_found_in_a_real_seals_force(tmp_path, capsys):
    files = [str(path) for path in sorted((REAL / "pneumatic-seal").glob("KDN_*.csv"))]
    main([files[0], *SEAL, "--no-suggest"])
    assert '--covariate "column 6"' in capsys.readouterr().out
    out = tmp_path / "r.json"
    main([*files, *SEAL, "--covariate", "column 6", "--no-suggest", "--json", str(out), "--quiet"])
    covariate = json.loads(out.read_text())["covariate"]
    assert covariate["N_per_unit"] == pytest.approx(51.06, rel=0.05)
    assert 20.0 < covariate["share_of_height_percent"] < 35.0
