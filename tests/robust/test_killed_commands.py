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

import pytest
import tomli_w
from command_server import MAINS
from judging import tree
from odd_inputs import DEMO, ROOT
from test_write_faults import COMMANDS as QUICK

pytestmark = pytest.mark.xdist_group("commands")
COMMANDS = {
    "track-video": ["track-video", "film.avi", "--project", "film.toml", "-o", "out.csv", "--json", "out.json"],
    "fit-actuator": ["fit-actuator", "loop.csv", "-o", "out.toml", "--json", "out.json", "--figure", "out.png"],
    "simulate-deployment": ["simulate-deployment", "model.toml", "-o", "out.csv", "--page", "out.html"],
    "sweep-deployments": ["sweep-deployments", "model.toml", "--resume", "-o", "out", "--json", "out.json"],
    "compare-model": ["compare-model", "model.toml", "test.csv", "-o", "out.png", "--json", "out.json"],
    "explain-gap": ["explain-gap", "model.toml", "test.csv", "--budget", "quick", "-o", "out", "--json", "out.json"],
}
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
OURS = (b".unspool-", b".part")  # what a killed run may leave for the next one


@pytest.fixture
def demonstration(tmp_path):
    """A folder with the demonstration's data, and a run of a tenth of a second."""
    model = tomllib.loads((ROOT / "datasets" / "prototype.toml").read_text(encoding="utf-8"))
    for name, lasts in {"model.toml": 0.1, "rig.toml": 0.7}.items():
        model["simulation"] = {"duration_s": lasts, "sample_rate_Hz": 1000.0}
        (tmp_path / name).write_text(tomli_w.dumps(model))
    for name, source in {"film.avi": "film.avi", "film.toml": "film.toml", "test.csv": "deployment-2.csv"}.items():
        shutil.copy(DEMO / source, tmp_path / name)
    shutil.copy(sorted((DEMO / "loops").glob("*.csv"))[0], tmp_path / "loop.csv")
    return tmp_path


def started(folder, words):
    """The command as a user starts it, imports and all."""
    begun = f"import sys; sys.argv[0] = {words[0]!r}; import measure.commands, os; os.write(1, b'.'); "
    code = f"{begun}from {MAINS[words[0]]} import main; sys.exit(main())"
    command = [sys.executable, "-c", code, *words[1:]]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)


def ended(folder, words):
    """Status of the command, nobody disturbing it."""
    process = started(folder, words)
    process.communicate()
    return process.returncode


STATUS = {signal.SIGINT: {0, 1, 130}, signal.SIGTERM: {0, 1, 143, -signal.SIGTERM}, signal.SIGKILL: {0, 1, -signal.SIGKILL}}


def left_wrong(left, whole, ending, status, said):
    """What a kill may not leave or say; one that comes late finds a command that has ended."""
    hidden = {path for path in left if any(key in path for key in OURS)}
    results = {path: content for path, content in left.items() if path not in hidden}
    wrong = ["results are not the old ones"] * (results != whole)
    temporary = sorted(path for path in hidden if OURS[0] in path)
    wrong += [f"left over: {temporary}"] * bool(temporary and ending != signal.SIGKILL)
    wrong += [f"status {status}"] * (status not in STATUS[ending])
    sentences = status == 130 and said.strip().splitlines()
    return wrong + [f"said: {said[-500:]!r}"] * ("Traceback" in said or (bool(sentences) and "stopped" not in sentences[-1]))


@pytest.mark.calibrate
@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_twenty_kills_leave_the_old_results_whole_and_the_next_run_gives_the_same(
    demonstration, name, share_of, calibration_seed, validation_table
):
    chance = random.Random(f"{calibration_seed} {name}")
    begun = time.monotonic()
    assert ended(demonstration, COMMANDS[name]) in (0, 1)
    lasts = time.monotonic() - begun
    whole, wrong, kills = tree(demonstration), [], share_of(20)
    for _ in range(kills):
        process = started(demonstration, COMMANDS[name])
        assert process.stdout is not None
        process.stdout.read(1)  # its first line is reached
        time.sleep(chance.uniform(0.0, 1.1 * lasts))
        ending = chance.choice(SIGNALS)
        process.send_signal(ending)
        said = process.communicate()[1].decode("utf-8", "replace")
        wrong += [f"{ending.name}: {text}" for text in left_wrong(tree(demonstration), whole, ending, process.returncode, said)]
    assert ended(demonstration, COMMANDS[name]) in (0, 1)
    again = tree(demonstration) != whole
    row = {"command": name, "kills": kills, "wrong afterwards": len(wrong), "other bytes by the next run": again}
    validation_table("Kills at any time", [row], "INT, TERM or KILL, from the first line of the program to its end.")
    assert not wrong, "\n".join(wrong)
    assert not again


@pytest.mark.parametrize(("name", "ending"), [*zip(sorted(set(QUICK) - {"unspool"}), SIGNALS * 3, strict=False)])
def test_a_kill_leaves_the_old_results_whole_and_the_next_run_gives_the_same(commands, bench, name, ending):
    chance = random.Random(name)
    begun = time.monotonic()
    assert commands.run(QUICK[name], bench).status in (0, 1)
    lasts = time.monotonic() - begun
    whole = tree(bench)
    killed = commands.run(QUICK[name], bench, kill_after_s=chance.uniform(0.0, lasts), signal=int(ending))
    wrong = left_wrong(tree(bench), whole, ending, killed.status, killed.error)
    assert commands.run(QUICK[name], bench).status in (0, 1)
    assert not wrong, "\n".join(wrong)
    assert tree(bench) == whole
