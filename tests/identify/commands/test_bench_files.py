"""What goes wrong with files on a bench, as the command answers it: two recordings, swapped columns, signs, units, growing strokes."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from identify.commands.fit_actuator import main
from measure import InputError, Loop
from measure.readers.loop_file import read_loop_file
from measure.tables.csv_cells import write_columns
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
RATE, FINE = 100.0, 10


def recorded(t: np.ndarray, u: np.ndarray, seed: int = 1) -> Loop:
    """A loop whose motion is given on fine steps, with the noise of a good bench."""
    chance, v = np.random.default_rng(seed), np.gradient(u, t)
    force = loop_force(LINES, t, u, v, 0 * t, 2.8)[::FINE]
    n = len(force)
    return Loop(t[::FINE], u[::FINE] + 2e-6 * chance.standard_normal(n), force + 1e-3 * chance.standard_normal(n))


def sine(frequency: float, seed: int = 1) -> Loop:
    t = np.arange(int(4.2 / frequency * RATE) * FINE) / (RATE * FINE)
    return recorded(t, 0.25 + 0.03 * np.sin(2 * np.pi * frequency * t), seed)


def growing() -> Loop:
    """Two triangles at each amplitude, 0.2 to 40 mm, each twice that before."""
    corners = [0.25]
    for amplitude in 0.04 / 2.0 ** np.arange(7, -1, -1):
        corners += [0.25 + amplitude, 0.25 - amplitude] * 2
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff([*corners, 0.25])))])
    t = np.arange(int(way[-1] / 0.02 * RATE) * FINE) / (RATE * FINE)
    return recorded(t, np.interp(0.02 * t, way, [*corners, 0.25]))


def written(folder: Path, name: str, loop: Loop, elongation=1.0, force=1.0, swapped=False) -> str:
    u, f = elongation * loop.elongation_m, force * loop.force_N
    write_columns({"time_s": loop.time_s, "elongation_m": f if swapped else u, "force_N": u if swapped else f}, folder / name)
    return str(folder / name)


def answered(folder: Path, *words: str) -> tuple[int, dict]:
    out = folder / "r.json"
    status = main([*words, "--no-suggest", "--quiet", "--json", str(out)])
    return status, json.loads(out.read_text())


def faults(result: dict) -> set[str]:
    return {fault["word"] for fault in result["faults"]}


def test_small_loops_of_a_growing_protocol_count(tmp_path):
    status, result = answered(tmp_path, written(tmp_path, "growing.csv", growing()))
    assert status == 0
    assert "nothing moves" not in " ".join(result["record"])
    assert result["loops"][0]["samples_idle"] < 50
    assert abs(result["parameters"]["beta_per_m"]["value"] - 400.0) < 4 * result["parameters"]["beta_per_m"]["stderr"]
    parts = result["loops"][0]["parts"]
    assert all(one["to_s"] <= other["from_s"] + 1e-9 for one, other in pairwise(parts))


def test_swapped_columns_are_named(tmp_path):
    status, result = answered(tmp_path, written(tmp_path, "swapped.csv", sine(1.0), swapped=True), "--as-given")
    assert "swapped" in faults(result)
    assert result["verdict"] != "ok"
    assert status == 1


@pytest.mark.parametrize(("elongation", "force"), [(-1.0, 1.0), (1.0, -1.0)])
def test_a_sign_that_was_turned_in_one_of_two_files_is_said_and_the_numbers_are_right(tmp_path, elongation, force):
    files = written(tmp_path, "a.csv", sine(0.5)), written(tmp_path, "b.csv", sine(1.0, 2), elongation, force)
    status, result = answered(tmp_path, *files)
    assert status == 0
    assert any("b.csv: runs clockwise" in note for note in result["notes"])
    if force < 0.0:  # an elongation turned about zero lies elsewhere, and so do its asymptotes
        assert result["parameters"]["beta_per_m"]["value"] == pytest.approx(400.0, rel=0.03)


@pytest.mark.parametrize(
    ("elongation", "force", "word"), [(1e3, 1.0, "elongation"), (1e-3, 1.0, "elongation"), (1.0, 1e3, "force"), (1.0, 1e-3, "force")]
)
def test_a_unit_off_by_a_thousand_in_one_of_three_files_is_refused_by_name(tmp_path, elongation, force, word):
    good = [written(tmp_path, f"{k}.csv", sine(f, k)) for k, f in enumerate((0.5, 1.0))]
    status, result = answered(tmp_path, *good, written(tmp_path, "odd.csv", sine(1.0, 5), elongation, force))
    assert status == 1
    assert result["verdict"] == "data-bad"
    assert "odd.csv" in result["reason"]
    assert f"--unit {word}=" in result["reason"]


def test_two_recordings_in_one_file_are_refused_with_the_line(tmp_path):
    path, first, second = tmp_path / "two.csv", sine(1.0), sine(0.5, 2)
    columns = [np.concatenate(pair) for pair in ((first.time_s, second.time_s), (first.elongation_m, second.elongation_m))]
    write_columns({"time_s": columns[0], "elongation_m": columns[1], "force_N": np.concatenate([first.force_N, second.force_N])}, path)
    with pytest.raises(InputError, match="two recordings"):
        read_loop_file(path)
