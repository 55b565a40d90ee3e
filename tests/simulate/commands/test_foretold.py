"""Sweeps and designs say beforehand about how long they take, from a sample; ten times the runs are ten times as much."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from simulate.commands import design_control
from simulate.commands.sweep_deployments import main
from simulate.control import design as design_of_control
from simulate.files.model_file import read_model
from simulate.sweeps import run_sweep

MODEL = Path(__file__).parents[3] / "datasets" / "prototype.toml"


@pytest.fixture
def one_second(monkeypatch):
    """A sample of the work takes a second, on every machine."""
    for module in (run_sweep, design_of_control):
        monkeypatch.setattr(module, "timed", lambda work: 1.0)


def test_a_sweep_foretells_ten_times_as_much_for_ten_times_the_runs(one_second):
    said = []
    for runs in (64, 640):
        factors = ["platform.mass_kg=+-5%"]
        run_sweep.sweep(read_model(MODEL), factors, "random", runs, foretell=said.append)
    assert said[1] == pytest.approx(10 * said[0])


def test_a_sweep_that_goes_on_foretells_what_is_left(one_second, tmp_path):
    brief = read_model(MODEL)
    brief = replace(brief, simulation=replace(brief.simulation, duration_s=0.02))
    said: list[float] = []
    words: dict[str, Any] = {"folder": tmp_path / "part", "foretell": said.append}
    run_sweep.sweep(brief, ["platform.mass_kg=+-5%"], "random", 600, **words)
    (tmp_path / "part" / "000000512.npy").unlink()
    run_sweep.sweep(brief, ["platform.mass_kg=+-5%"], "random", 600, resume=True, **words)
    run_sweep.sweep(brief, ["platform.mass_kg=+-5%"], "random", 600, **words)
    assert [seconds / said[0] for seconds in said] == pytest.approx([1.0, 88 / 600, 1.0])


def test_a_sweep_that_ends_never_is_refused_before_it_begins(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(run_sweep, "timed", lambda work: 1e9)
    assert main([str(MODEL), "--design", "random", "--runs", "64", "-o", str(tmp_path / "sweep")]) == 2
    assert "--runs" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_the_command_says_it_on_standard_error(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(run_sweep, "timed", lambda work: 3200.0)
    factor = ["--factor", "platform.mass_kg=+-5%"]
    assert main([str(MODEL), *factor, "--set", "simulation.duration_s=0.05", "-o", str(tmp_path / "sweep")]) == 0
    assert "sweep-deployments: this takes about 53 min" in capsys.readouterr().err


def test_a_design_of_a_controller_that_ends_never_is_refused_before_it_begins(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(design_of_control, "timed", lambda work: 1e12)
    monkeypatch.setattr(design_of_control, "_found", lambda *given: pytest.fail("begun"))
    assert design_control.main([str(MODEL), "-o", str(tmp_path / "designed.toml")]) == 2
    assert "this would take for ever. Give fewer --draws" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
