"""A sweep that is killed at any moment leaves whole files or none, and goes on to the same bytes."""

import json
import random
import resource
import signal
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.commands import sweep_deployments
from simulate.files.model_file import write_model
from simulate.sweeps.chunks import Chunks

WORDS = ["prototype.toml", "--design", "random", "--runs", "12288", "--seed", "3", "--quiet", "--set", "simulation.duration_s=0.3"]
RESULT = ("coefficients.csv", "responses.csv", "responses.csv.provenance.json", "sweep.png")


def started(folder, *more):
    words = [sys.executable, "-m", "simulate.commands.sweep_deployments", *WORDS, "-o", "out", "--json", "out.json", *more]
    return subprocess.Popen(words, cwd=folder, stderr=subprocess.PIPE)


def result(folder):
    report = json.loads((folder / "out.json").read_text())
    return {name: (folder / "out" / name).read_bytes() for name in RESULT}, report


def require_whole(folder):
    """Every file that does not begin with a point is whole; the result folder is complete or absent."""
    for path in folder.glob("out.part/[0-9]*.npy"):
        assert np.load(path, allow_pickle=False).shape == (512, 6)
    if (folder / "out").exists():
        assert {path.name for path in (folder / "out").iterdir()} == set(RESULT)
    if (folder / "out.json").exists():
        json.loads((folder / "out.json").read_text())


@pytest.mark.calibrate
def test_killed_at_twenty_random_moments_it_never_leaves_a_half_file_and_ends_in_the_same_bytes(tmp_path, prototype):
    for name in ("undisturbed", "killed"):
        (tmp_path / name).mkdir()
        write_model(prototype, tmp_path / name / "prototype.toml")
    begun = time.perf_counter()
    assert started(tmp_path / "undisturbed").wait() == 0
    takes = time.perf_counter() - begun
    whole, folder, chance = result(tmp_path / "undisturbed"), tmp_path / "killed", random.Random(1)
    kills = most = 0
    while kills < 20:
        begun = time.perf_counter()
        run = started(folder, "--resume")
        try:
            status = run.wait(chance.uniform(0.3, 1.0) * takes)
            takes = min(takes, time.perf_counter() - begun)
        except subprocess.TimeoutExpired:
            run.send_signal(signal.SIGKILL)
            status = run.wait()
        kills += status == -signal.SIGKILL
        require_whole(folder)
        if status == 0:  # it was through before it was hit: the next one starts from nothing
            assert result(folder) == whole
            for path in (*(folder / "out").iterdir(), folder / "out.json"):
                path.unlink()
            (folder / "out").rmdir()
        most = max(most, len(list(folder.glob("out.part/[0-9]*.npy"))))
    assert most > 1, "no kill came in the middle of a sweep"
    assert started(folder, "--resume").wait() == 0
    assert result(folder) == whole
    assert not (folder / "out.part").exists()


@pytest.mark.parametrize(
    "change", [["--set", "platform.mass_kg=0.9"], ["--seed", "9"], ["--runs", "1024"], ["--factor", "platform.mass_kg=+-1%"]]
)
def test_pieces_of_another_model_or_design_are_refused(tmp_path, prototype, monkeypatch, capsys, change):
    monkeypatch.chdir(tmp_path)
    write_model(prototype, tmp_path / "prototype.toml")
    words = ["prototype.toml", "--design", "random", "--runs", "600", "--set", "simulation.duration_s=0.05", "-o", "out", "--quiet"]
    monkeypatch.setattr("simulate.sweeps.result.SweepResult.report", property(_stopped))
    assert sweep_deployments.main(words) == 130
    pieces = {path.name: path.read_bytes() for path in (tmp_path / "out.part").glob("[0-9]*.npy")}
    assert len(pieces) == 2
    assert sweep_deployments.main([*words, "--resume", *change]) == 2
    assert "another model, design or version" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in (tmp_path / "out.part").glob("[0-9]*.npy")} == pieces


def _stopped(_):
    raise KeyboardInterrupt


def test_a_damaged_piece_is_a_sentence_that_names_it(tmp_path, prototype, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_model(prototype, tmp_path / "prototype.toml")
    words = ["prototype.toml", "--design", "random", "--runs", "600", "--set", "simulation.duration_s=0.05", "-o", "out", "--quiet"]
    with monkeypatch.context() as patch:
        patch.setattr("simulate.sweeps.result.SweepResult.report", property(_stopped))
        assert sweep_deployments.main(words) == 130
    piece = sorted((tmp_path / "out.part").glob("[0-9]*.npy"))[0]
    content = piece.read_bytes()
    for damaged in (content[:-8], content[:20], b"", b"x" * 500):
        piece.write_bytes(damaged)
        assert sweep_deployments.main([*words, "--resume"]) == 2
        assert f"{piece.name}: is damaged; remove it" in capsys.readouterr().err
    piece.unlink()
    assert sweep_deployments.main([*words, "--resume"]) == 0


@pytest.mark.parametrize("most", [50, 150, 1000])
def test_a_piece_that_the_disk_takes_in_part_is_none(tmp_path, most):
    pieces: Any = Chunks(tmp_path, None)  # type: ignore[arg-type]
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    try:
        with pytest.raises(InputError, match="cannot be written"):
            list(pieces.keep([(0, np.zeros((20, 9)))]))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not list(tmp_path.iterdir())
