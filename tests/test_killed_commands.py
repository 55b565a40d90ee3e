"""A command that is killed at any time leaves the old results as they were and nothing half written; the next run tidies up."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest
import tomli_w

ROOT = Path(__file__).parents[1]
DEMO = ROOT / "datasets" / "demo"
COMMANDS = {
    "track-video": ["measure.commands.track_video", "film.avi", "--project", "film.toml", "-o", "out.csv", "--json", "out.json"],
    "fit-actuator": ["identify.commands.fit_actuator", "loop.csv", "-o", "out.toml", "--json", "out.json", "--figure", "out.png"],
    "simulate-deployment": ["simulate.commands.simulate_deployment", "model.toml", "-o", "out.csv", "--page", "out.html"],
    "sweep-deployments": ["simulate.commands.sweep_deployments", "model.toml", "--resume", "-o", "out", "--json", "out.json"],
    "compare-model": ["identify.commands.compare_model", "model.toml", "test.csv", "-o", "out.png", "--json", "out.json"],
    "explain-gap": ["identify.commands.explain_gap", "model.toml", "test.csv", "--budget", "quick", "-o", "out", "--json", "out.json"],
}
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)


@pytest.fixture
def bench(tmp_path):
    """A folder with the demonstration's data, and a run of a tenth of a second."""
    model = tomllib.loads((ROOT / "datasets" / "prototype.toml").read_text(encoding="utf-8"))
    model["simulation"] = {"duration_s": 0.1, "sample_rate_Hz": 1000.0}
    (tmp_path / "model.toml").write_text(tomli_w.dumps(model))
    for name, source in {"film.avi": "film.avi", "film.toml": "film.toml", "test.csv": "deployment-2.csv"}.items():
        shutil.copy(DEMO / source, tmp_path / name)
    shutil.copy(sorted((DEMO / "loops").glob("*.csv"))[0], tmp_path / "loop.csv")
    return tmp_path


def started(bench, words):
    command = [sys.executable, "-c", f"import sys; from {words[0]} import main; sys.exit(main(sys.argv[1:]))", *words[1:]]
    return subprocess.Popen(
        command, cwd=bench, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )


def contents(bench):
    """Every file with its content, but the pieces of a sweep, which --resume needs."""
    return {str(p.relative_to(bench)): p.read_bytes() for p in bench.rglob("*") if p.is_file() and ".part" not in str(p)}


def same(one, other):
    """Whether two states are alike but for the time that a sweep took."""

    def still(name, content):
        return b"".join(line for line in content.splitlines() if b'"wall_s"' not in line) if name == "out.json" else content

    return {name: still(name, content) for name, content in one.items()} == {name: still(name, content) for name, content in other.items()}


@pytest.mark.calibrate
@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_twenty_kills_leave_the_old_results_whole_and_the_next_run_gives_the_same(bench, name, share_of, calibration_seed):
    chance = random.Random(f"{calibration_seed} {name}")
    begun = time.monotonic()
    assert started(bench, COMMANDS[name]).wait() in (0, 1)
    lasts = time.monotonic() - begun
    whole = contents(bench)
    for _ in range(share_of(20)):
        process = started(bench, COMMANDS[name])
        time.sleep(chance.uniform(0.0, 1.1 * lasts))
        ending = chance.choice(SIGNALS)
        process.send_signal(ending)
        _, said = process.communicate()
        assert b"Traceback" not in said or process.returncode < 0 or b"site-packages" not in said, said
        left = contents(bench)
        hidden = {path for path in left if ".unspool-" in path}
        assert not hidden or ending == signal.SIGKILL
        assert same({path: content for path, content in left.items() if path not in hidden}, whole)
    assert started(bench, COMMANDS[name]).wait() in (0, 1)
    assert same(contents(bench), whole)
