"""Lists of runs: what is accepted, and the sentence for what is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from identify.campaign import read_campaign
from identify.commands import compare_model, explain_gap
from measure.errors import InputError
from measure.tables import Trajectory, write_trajectory
from simulate.model_file import read_model

PROTOTYPE = Path(__file__).resolve().parents[2] / "datasets" / "prototype.toml"


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
        ("[[run]]\nhold_out = false\n", "give the name of a table"),
        ('runs = "one.csv"\n', 'unknown key "runs"'),
        ("[[run]\n", "is not TOML"),
    ],
)
def test_a_list_that_cannot_be_used_is_refused_in_a_sentence(table, text, found):
    with pytest.raises(InputError, match=found.replace("(", r"\(")):
        read_campaign([listed(table, text)])


@pytest.mark.parametrize("command", [compare_model, explain_gap])
def test_unusable_input_ends_with_status_2_and_nothing_written(table, tmp_path, capsys, command):
    bad = listed(table, '[[run]]\nfile = "one.csv"\nmodel.platform.mas_kg = 1.0\n')
    out = tmp_path / "out"
    status = command.main([str(PROTOTYPE), str(bad), "--json", str(tmp_path / "r.json"), "-o", str(out.with_suffix(".png"))])
    assert status == 2
    assert 'unknown key "platform.mas_kg"; did you mean "mass_kg"' in capsys.readouterr().err
    assert not (tmp_path / "r.json").exists()
    assert not out.with_suffix(".png").exists()
