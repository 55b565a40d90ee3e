"""A fit in numbers and as a table: what is corrected agrees, and the statistics are those of the samples."""

import csv
import json

import numpy as np
import pytest

from identify.actuator.actuator_fit import corrected_force
from identify.actuator.curves import curve_columns, statistics_of, statistics_sentence
from identify.actuator.fit_actuator import fit_actuator
from identify.commands.fit_actuator import main
from identify.loops.prepare import prepare
from measure import Loop, write_loop
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
PER_BAR = 0.05


def shaken(pressure_bar, seed):
    """Three cycles at 1 Hz under a pressure that adds to the force."""
    chance, t = np.random.default_rng(seed), np.arange(640) / 200.0
    u = 0.25 + 0.04 * np.sin(2 * np.pi * t)
    force = loop_force(LINES, t, u, 0 * t, 0 * t, 2.8) + PER_BAR * pressure_bar + 2e-3 * chance.standard_normal(len(t))
    return Loop(t, u + 1e-5 * chance.standard_normal(len(t)), force, f"{pressure_bar:g} bar", {"p_bar": np.full(len(t), pressure_bar)})


@pytest.fixture(scope="module")
def fitted():
    return fit_actuator([prepare(shaken(p, k)) for k, p in enumerate((1.0, 2.0, 4.0))], covariate="p_bar", suggest=False)


def test_corrected_loops_lie_on_each_other_where_a_covariate_parts_the_measured_ones(fitted):
    levels = [np.mean(corrected_force(fitted, k)[data.used]) for k, data in enumerate(fitted.loops)]
    measured = [np.mean(data.force_N[data.used]) for data in fitted.loops]
    assert np.ptp(measured) > 0.14
    assert np.ptp(levels) < 2e-3
    table = curve_columns(fitted)
    assert table["fitted_N"] + table["residual_N"] == pytest.approx(table["force_N"], abs=1e-12)
    assert set(table["file"]) == {"1 bar", "2 bar", "4 bar"}
    assert np.std(table["residual_N"]) == pytest.approx(2e-3, rel=0.2)


def test_statistics_count_points_and_parameters(fitted):
    found = statistics_of(fitted)
    assert found["points"] == sum(int(data.used.sum()) for data in fitted.loops)
    assert found["reduced_chi_square"] == pytest.approx(1.0, abs=0.25)
    mean = np.log(found["chi_square"] / found["points"])
    assert found["bic"] == pytest.approx(found["points"] * mean + np.log(found["points"]) * found["free_parameters"])
    matrix = np.array(found["correlations"]["matrix"])
    assert found["correlations"]["names"] == fitted.names
    assert np.diag(matrix) == pytest.approx(1.0)
    assert np.all(np.abs(matrix) <= 1.0)
    assert f"{found['points']} points" in statistics_sentence(found)


def test_the_command_writes_the_curve_and_the_statistics(tmp_path, capsys):
    write_loop(shaken(1.0, 5), tmp_path / "a.csv")
    words = [str(tmp_path / "a.csv"), "--curve", str(tmp_path / "curve.csv"), "--json", str(tmp_path / "a.json"), "--no-suggest"]
    assert main(words) == 0
    result = json.loads((tmp_path / "a.json").read_text())
    with open(tmp_path / "curve.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == result["statistics"]["points"]
    assert float(rows[0]["fitted_N"]) == pytest.approx(2.8, abs=0.2)
    assert "points, worth" in capsys.readouterr().out
